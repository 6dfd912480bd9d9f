//! What `#if` asks: `defined`, and the operators of C but `?:`.

use super::super::token::{At, Token};
use super::Preprocessor;

/// Parentheses within each other.
const DEPTH: usize = 32;

impl Preprocessor<'_> {
    /// Whether the expression in this line holds; one that is wrong does not.
    pub(super) fn expression(&mut self, at: At) -> bool {
        let words = self.words_of_line();
        let mut question = Question {
            words: &words,
            next: 0,
            depth: 0,
            has: &|name| self.macros.get(name).map(AsRef::as_ref),
        };
        let value = question.binary(0).filter(|_| question.next == words.len());
        if value.is_none() {
            let at = words.get(question.next).map_or(at, |(_, at)| *at);
            let help = "understood are `defined NAME`, whole numbers, macros that stand for one, the operators of C but `?:`, and parentheses";
            self.findings.error(
                "idl-bad-directive",
                at,
                "this condition is not understood",
                help,
            );
        }
        value.is_some_and(|value| value != 0)
    }
}

struct Question<'a> {
    words: &'a [(Token, At)],
    next: usize,
    depth: usize,
    has: &'a dyn Fn(&str) -> Option<&'a [Token]>,
}

/// Operators, those that bind loosest first.
const LEVELS: [&[&str]; 10] = [
    &["||"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<=", ">=", "<", ">"],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];

impl Question<'_> {
    fn symbol(&self) -> Option<&'static str> {
        match self.words.get(self.next) {
            Some((Token::Symbol(symbol), _)) => Some(symbol),
            _ => None,
        }
    }

    fn takes(&mut self, symbol: &str) -> bool {
        let found = self.symbol() == Some(symbol);
        self.next += usize::from(found);
        found
    }

    fn binary(&mut self, level: usize) -> Option<i128> {
        let Some(operators) = LEVELS.get(level) else {
            return self.unary();
        };
        let mut left = self.binary(level + 1)?;
        while let Some(symbol) = self.symbol().filter(|symbol| operators.contains(symbol)) {
            self.next += 1;
            let right = self.binary(level + 1)?;
            left = binary(symbol, left, right)?;
        }
        Some(left)
    }

    fn unary(&mut self) -> Option<i128> {
        self.depth += 1;
        let value = match self.depth <= DEPTH {
            true => self.operand(),
            false => None,
        };
        self.depth -= 1;
        value
    }

    fn operand(&mut self) -> Option<i128> {
        if self.takes("!") {
            return self.unary().map(|value| i128::from(value == 0));
        }
        if self.takes("-") {
            return self.unary()?.checked_neg();
        }
        if self.takes("+") {
            return self.unary();
        }
        if self.takes("~") {
            return self.unary().map(|value| !value);
        }
        if self.takes("(") {
            let value = self.binary(0)?;
            return self.takes(")").then_some(value);
        }
        let (token, _) = self.words.get(self.next)?;
        match token {
            Token::Integer(value) => {
                self.next += 1;
                Some(i128::from(*value))
            }
            Token::Identifier(name) if name == "defined" => {
                self.next += 1;
                self.defined()
            }
            Token::Identifier(name) => {
                self.next += 1;
                match (self.has)(name) {
                    None => Some(0),
                    Some([Token::Integer(value)]) => Some(i128::from(*value)),
                    Some(_) => {
                        self.next -= 1;
                        None
                    }
                }
            }
            _ => None,
        }
    }

    fn defined(&mut self) -> Option<i128> {
        let is_enclosed = self.takes("(");
        let name = match self.words.get(self.next)? {
            (Token::Identifier(name), _) => name.as_str(),
            (Token::Keyword(name), _) => name,
            _ => return None,
        };
        let value = i128::from((self.has)(name).is_some());
        self.next += 1;
        (!is_enclosed || self.takes(")")).then_some(value)
    }
}

/// None where there is no value: a division by zero, or a number that is too large.
fn binary(symbol: &str, left: i128, right: i128) -> Option<i128> {
    let shift = || u32::try_from(right).ok().filter(|by| *by < 64);
    Some(match symbol {
        "||" => i128::from(left != 0 || right != 0),
        "&&" => i128::from(left != 0 && right != 0),
        "|" => left | right,
        "^" => left ^ right,
        "&" => left & right,
        "==" => i128::from(left == right),
        "!=" => i128::from(left != right),
        "<=" => i128::from(left <= right),
        ">=" => i128::from(left >= right),
        "<" => i128::from(left < right),
        ">" => i128::from(left > right),
        "<<" => left.checked_mul(1 << shift()?)?,
        ">>" => left >> shift()?,
        "+" => left.checked_add(right)?,
        "-" => left.checked_sub(right)?,
        "*" => left.checked_mul(right)?,
        "/" => left.checked_div(right)?,
        _ => left.checked_rem(right)?,
    })
}
