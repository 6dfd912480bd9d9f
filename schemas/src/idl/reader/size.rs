//! How large values are at least, and how deep types are: bounded, so that nobody who walks them is surprised.

use super::super::limits;
use super::super::model::{Kind, Type};
use super::super::token::At;
use super::{Reader, State};

impl Reader<'_> {
    /// Values without parts that a value has at least, and how many types are within each other.
    fn weight(&self, r#type: &Type) -> (u64, usize) {
        match r#type {
            Type::Sequence { element, .. } => (1, self.weight(element).1 + 1),
            Type::Array {
                element,
                dimensions,
            } => {
                let (values, depth) = self.weight(element);
                let count = dimensions.iter().map(|count| u64::from(*count));
                (count.fold(values, u64::saturating_mul), depth + 1)
            }
            Type::Named(index) => match self.facts[*index].state {
                State::Complete => (self.facts[*index].values, self.facts[*index].depth + 1),
                _ => (1, 0),
            },
            _ => (1, 0),
        }
    }

    /// False, and told, when values of the type would be too large.
    pub(super) fn fits_memory(&mut self, r#type: &Type, at: At) -> bool {
        let (values, depth) = self.weight(r#type);
        self.fits(values, depth, at)
    }

    fn fits(&mut self, values: u64, depth: usize, at: At) -> bool {
        if values > limits::VALUES {
            let message = format!(
                "a value of this type has more than {} numbers",
                limits::VALUES
            );
            let help = "use a sequence: it is as long as what it holds";
            self.error("idl-too-large", at, message, help);
            return false;
        }
        if depth > limits::DEPTH {
            let message = format!(
                "more than {} types are within each other here",
                limits::DEPTH
            );
            self.error("idl-too-large", at, message, "take a level out");
            return false;
        }
        true
    }

    /// Notes how large a definition is that was read.
    pub(super) fn weigh(&mut self, index: usize) {
        let weights: Vec<(u64, usize)> = match &self.definitions[index].kind {
            Kind::Struct(found) => found
                .members
                .iter()
                .map(|m| self.weight(&m.r#type))
                .collect(),
            Kind::Exception(found) => found
                .members
                .iter()
                .map(|m| self.weight(&m.r#type))
                .collect(),
            Kind::Union(found) => found.cases.iter().map(|c| self.weight(&c.r#type)).collect(),
            Kind::Typedef(found) => vec![self.weight(&found.r#type)],
            _ => return,
        };
        let is_union = matches!(self.definitions[index].kind, Kind::Union(_));
        let values = weights.iter().map(|(values, _)| *values);
        let values = match is_union {
            true => values.max().unwrap_or_default().saturating_add(1),
            false => values.fold(0, u64::saturating_add).max(1),
        };
        let depth = weights
            .iter()
            .map(|(_, depth)| *depth)
            .max()
            .unwrap_or_default();
        let at = self.facts[index].at;
        if self.fits(values, depth, at) {
            self.facts[index].values = values;
            self.facts[index].depth = depth;
        }
    }
}
