//! A buffer of a connector: bounded, with a policy for when it is full and one for when it is empty.
//!
//! It never waits: what `block` means beyond that is its owner's part.

use std::collections::VecDeque;

use rts_schemas::connector::{BufferSettings, EmptyPolicy, FullPolicy};

use super::budget::Budget;

/// Bounded in items and in bytes, and by a budget that it shares with others.
#[derive(Debug)]
pub struct Buffer<T> {
    items: VecDeque<(T, usize)>,
    bytes: usize,
    settings: BufferSettings,
    max_bytes: usize,
    budget: &'static Budget,
    /// What was read last, when it may be read again.
    last: Option<T>,
}

impl<T: Clone> Buffer<T> {
    /// An empty buffer.
    pub fn new(settings: BufferSettings, max_bytes: usize, budget: &'static Budget) -> Self {
        Self {
            items: VecDeque::new(),
            bytes: 0,
            settings,
            max_bytes,
            budget,
            last: None,
        }
    }

    /// Its length and policies.
    pub fn settings(&self) -> &BufferSettings {
        &self.settings
    }

    /// True without items.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Items that it holds.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// The oldest item.
    pub fn first(&self) -> Option<&T> {
        self.items.front().map(|(item, _)| item)
    }

    /// Appends an item of `size` bytes. In a full one that overwrites, the oldest go for it and are handed to `dropped`;
    /// another one gives the item back. One above the bound of bytes is kept alone. An item is dropped itself when others
    /// hold the whole budget.
    pub fn write(&mut self, item: T, size: usize, mut dropped: impl FnMut(T)) -> Result<(), T> {
        loop {
            let full = self.items.len() >= self.settings.length
                || (self.bytes + size > self.max_bytes && !self.is_empty());
            if !full && self.budget.take(size) {
                break;
            }
            if self.settings.full != FullPolicy::Overwrite {
                return Err(item);
            }
            match self.take() {
                Some(oldest) => dropped(oldest),
                None => {
                    dropped(item);
                    return Ok(());
                }
            }
        }
        self.bytes += size;
        self.items.push_back((item, size));
        Ok(())
    }

    /// Reads the oldest item.
    pub fn read(&mut self) -> Option<T> {
        let item = self.take()?;
        if self.settings.empty == EmptyPolicy::Readback {
            self.last = Some(item.clone());
        }
        Some(item)
    }

    /// What was read last, if an empty one gives that again.
    pub fn read_back(&self) -> Option<T> {
        self.last.clone()
    }

    /// Takes the oldest item out, which is no reading.
    pub fn take(&mut self) -> Option<T> {
        let (item, size) = self.items.pop_front()?;
        self.bytes -= size;
        self.budget.give(size);
        Some(item)
    }
}

impl<T> Drop for Buffer<T> {
    fn drop(&mut self) {
        self.budget.give(self.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::time::Duration;

    static PLENTY: Budget = Budget::new(1 << 20);

    fn settings(length: usize, full: FullPolicy, empty: EmptyPolicy) -> BufferSettings {
        BufferSettings {
            length,
            full,
            empty,
            ..BufferSettings::default()
        }
    }

    fn overwriting(length: usize, bytes: usize, budget: &'static Budget) -> Buffer<char> {
        let settings = settings(length, FullPolicy::Overwrite, EmptyPolicy::DoNothing);
        Buffer::new(settings, bytes, budget)
    }

    fn full_policies() -> impl Strategy<Value = FullPolicy> {
        let wait = Duration::from_secs(1);
        prop_oneof![
            Just(FullPolicy::Overwrite),
            Just(FullPolicy::DoNothing),
            Just(FullPolicy::Block(wait)),
        ]
    }

    fn empty_policies() -> impl Strategy<Value = EmptyPolicy> {
        let wait = Duration::from_secs(1);
        prop_oneof![
            Just(EmptyPolicy::Readback),
            Just(EmptyPolicy::DoNothing),
            Just(EmptyPolicy::Block(wait)),
        ]
    }

    proptest! {
        /// The model is a plain list.
        #[test]
        fn it_is_a_list_with_two_policies(
            length in 1_usize..6, full in full_policies(), empty in empty_policies(),
            steps in prop::collection::vec(prop::option::weighted(0.7, 0_usize..40), 0..200),
        ) {
            const BYTES: usize = 60;
            let mut buffer = Buffer::new(settings(length, full, empty), BYTES, &PLENTY);
            let mut model: Vec<(u32, usize)> = Vec::new();
            let mut last = None;
            for (item, step) in (0..).zip(steps) {
                match step {
                    Some(size) => {
                        let mut dropped = Vec::new();
                        let written = buffer.write(item, size, |item| dropped.push(item));
                        let mut expected = Vec::new();
                        let fits = |model: &[(u32, usize)]| {
                            let bytes: usize = model.iter().map(|(_, size)| size).sum();
                            model.len() < length && (bytes + size <= BYTES || model.is_empty())
                        };
                        while full == FullPolicy::Overwrite && !fits(&model) {
                            expected.push(model.remove(0).0);
                        }
                        if fits(&model) {
                            model.push((item, size));
                            prop_assert_eq!(written, Ok(()));
                        } else {
                            prop_assert_eq!(written, Err(item));
                        }
                        prop_assert_eq!(dropped, expected);
                    }
                    None => {
                        let expected = (!model.is_empty()).then(|| model.remove(0).0);
                        last = expected.or(last);
                        prop_assert_eq!(buffer.read(), expected);
                        let again = (empty == EmptyPolicy::Readback).then_some(last).flatten();
                        prop_assert_eq!(buffer.read_back(), again);
                    }
                }
                prop_assert_eq!(buffer.len(), model.len());
                prop_assert_eq!(buffer.is_empty(), model.is_empty());
                prop_assert_eq!(buffer.first(), model.first().map(|(item, _)| item));
                prop_assert_eq!(buffer.bytes, model.iter().map(|(_, size)| size).sum::<usize>());
            }
        }
    }

    #[test]
    fn an_item_above_the_byte_bound_is_kept_alone() {
        let mut buffer = overwriting(4, 10, &PLENTY);
        let mut dropped = 0;
        buffer.write('a', 1, |_| dropped += 1).unwrap();
        buffer.write('b', 100, |_| dropped += 1).unwrap();
        assert_eq!(
            (dropped, buffer.read(), buffer.is_empty()),
            (1, Some('b'), true)
        );
    }

    #[test]
    fn buffers_share_a_budget_and_give_it_back() {
        static SHARED: Budget = Budget::new(10);
        let (mut one, mut two) = (overwriting(4, 10, &SHARED), overwriting(4, 10, &SHARED));
        let mut dropped = Vec::new();
        one.write('a', 8, |item| dropped.push(item)).unwrap();
        two.write('b', 2, |item| dropped.push(item)).unwrap();
        two.write('c', 3, |item| dropped.push(item)).unwrap();
        assert_eq!(dropped, ['b', 'c']);
        drop(one);
        two.write('d', 10, |item| dropped.push(item)).unwrap();
        assert_eq!((dropped.len(), two.first()), (2, Some(&'d')));
        two.read();
        assert!(SHARED.take(10));
    }
}
