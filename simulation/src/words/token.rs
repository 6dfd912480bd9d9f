//! Words of a text: separated by blanks, or in double quotes where a name has blanks.

use super::error::{WordError, nearest};

/// A word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token {
    /// It, without quotes.
    pub word: String,
    /// Characters before it.
    pub at: usize,
    /// It is a name, whatever it says.
    pub quoted: bool,
}

/// The words of a text, one after the other.
#[derive(Debug, Clone)]
pub struct Words<'a> {
    text: &'a str,
    tokens: std::iter::Peekable<std::vec::IntoIter<Token>>,
}

impl<'a> Words<'a> {
    /// Cuts a text.
    pub fn of(text: &'a str) -> Result<Self, WordError> {
        let tokens = tokens(text)?;
        Ok(Self {
            text,
            tokens: tokens.into_iter().peekable(),
        })
    }

    /// The next word; taken.
    pub fn next(&mut self) -> Option<Token> {
        self.tokens.next()
    }

    /// True when the next word is this one. It is taken then.
    pub fn takes(&mut self, word: &str) -> bool {
        let is = |token: &Token| !token.quoted && token.word == word;
        self.tokens.next_if(is).is_some()
    }

    /// A name; `what` says of what.
    pub fn name(&mut self, what: &str) -> Result<String, WordError> {
        match self.next() {
            Some(token) => Ok(token.word),
            None => Err(self.wrong(None, what, &[])),
        }
    }

    /// One of these words.
    pub fn one_of(&mut self, words: &[&'static str]) -> Result<&'static str, WordError> {
        let token = self.next();
        let known = token.as_ref().filter(|token| !token.quoted);
        let found = known.and_then(|token| words.iter().find(|word| **word == token.word));
        found
            .copied()
            .ok_or_else(|| self.wrong(token, &listed(words), words))
    }

    /// The error for a word.
    pub fn wrong(&self, token: Option<Token>, expected: &str, known: &[&str]) -> WordError {
        let word = token.as_ref().map(|token| token.word.as_str());
        WordError {
            text: self.text.to_owned(),
            at: token
                .as_ref()
                .map_or_else(|| self.text.chars().count(), |t| t.at),
            expected: expected.to_owned(),
            nearest: word.and_then(|word| nearest(word, known.iter().copied())),
            word: token.map(|token| token.word),
        }
    }
}

/// `a, b or c`.
pub fn listed(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [all @ .., last] => format!("{} or {last}", all.join(", ")),
    }
}

fn tokens(text: &str) -> Result<Vec<Token>, WordError> {
    let mut tokens = Vec::new();
    let mut letters = text.chars().enumerate().peekable();
    while let Some((at, letter)) = letters.next() {
        if letter.is_whitespace() {
            continue;
        }
        let mut word = String::new();
        if letter != '"' {
            word.push(letter);
            while let Some((_, letter)) = letters.next_if(|(_, l)| !l.is_whitespace()) {
                word.push(letter);
            }
            tokens.push(Token {
                word,
                at,
                quoted: false,
            });
            continue;
        }
        loop {
            match letters.next() {
                Some((_, '"')) => break,
                Some((_, '\\')) => word.extend(letters.next().map(|(_, letter)| letter)),
                Some((_, letter)) => word.push(letter),
                None => {
                    return Err(WordError {
                        text: text.to_owned(),
                        at: text.chars().count(),
                        word: None,
                        expected: "a second `\"`".to_owned(),
                        nearest: None,
                    });
                }
            }
        }
        tokens.push(Token {
            word,
            at,
            quoted: true,
        });
    }
    Ok(tokens)
}

/// A name as it can be read again.
pub fn quoted(name: &str) -> String {
    let plain = |letter: char| !letter.is_whitespace() && letter != '"';
    if !name.is_empty() && name.chars().all(plain) {
        return name.to_owned();
    }
    let escaped = name.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{escaped}\"")
}
