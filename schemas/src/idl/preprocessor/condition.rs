//! `#if`, `#ifdef`, `#ifndef`, `#elif`, `#else`, `#endif`.

use super::super::token::At;
use super::Preprocessor;

/// An open condition.
#[derive(Debug)]
pub(super) struct Condition {
    pub at: At,
    /// What stands here is read.
    pub active: bool,
    /// A branch was read, or none may be.
    pub taken: bool,
    /// `#else` has come.
    pub last: bool,
}

/// Conditions within each other.
const DEPTH: usize = 100;

impl Preprocessor<'_> {
    /// Where conditions stand, what is read.
    pub(super) fn is_active(&self) -> bool {
        self.conditions
            .last()
            .is_none_or(|condition| condition.active)
    }

    /// `#if` and the like: opens a condition.
    pub(super) fn open_condition(&mut self, word: &str, at: At) {
        if self.conditions.len() >= DEPTH {
            let message = format!("there are more than {DEPTH} conditions within each other");
            self.findings
                .error("idl-too-large", at, message, "leave out some of them");
        }
        let outer = self.is_active() && self.conditions.len() < DEPTH;
        let holds = outer
            && match word {
                "if" => self.expression(at),
                _ => self
                    .macro_name(at)
                    .is_some_and(|name| self.macros.contains_key(&name) == (word == "ifdef")),
            };
        self.conditions.push(Condition {
            at,
            active: holds,
            taken: holds || !outer,
            last: false,
        });
    }

    /// `#elif`, `#else` and `#endif` of the innermost condition of this file.
    pub(super) fn next_condition(&mut self, word: &str, at: At) {
        let own = self.open.last().map_or(0, |open| open.conditions);
        if self.conditions.len() <= own {
            let message = format!("`#{word}` belongs to no condition");
            let help = "an `#if`, `#ifdef` or `#ifndef` stands before it in the same file";
            self.findings.error("idl-bad-directive", at, message, help);
            return;
        }
        if word == "endif" {
            self.conditions.pop();
            return;
        }
        let Some(condition) = self.conditions.last_mut() else {
            return;
        };
        if condition.last {
            let message = format!("`#{word}` stands after `#else`");
            let help = "`#else` is the last branch of a condition";
            self.findings.error("idl-bad-directive", at, message, help);
            return;
        }
        let taken = condition.taken;
        condition.active = false;
        condition.last = word == "else";
        let holds = !taken && (word == "else" || self.expression(at));
        if let Some(condition) = self.conditions.last_mut() {
            condition.active = holds;
            condition.taken |= holds;
        }
    }
}
