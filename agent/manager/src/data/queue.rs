//! A bounded queue that drops its oldest items.

use std::collections::VecDeque;

/// Bounded in items and in bytes.
#[derive(Debug)]
pub struct Queue<T> {
    items: VecDeque<(T, usize)>,
    bytes: usize,
    max_items: usize,
    max_bytes: usize,
}

impl<T> Queue<T> {
    /// An empty queue.
    pub fn new(max_items: usize, max_bytes: usize) -> Self {
        Self {
            items: VecDeque::new(),
            bytes: 0,
            max_items,
            max_bytes,
        }
    }

    /// True without items.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// Appends an item of `size` bytes; what must go for it is handed to `dropped`, oldest first.
    pub fn push(&mut self, item: T, size: usize, mut dropped: impl FnMut(T)) {
        while !self.items.is_empty()
            && (self.items.len() >= self.max_items || self.bytes + size > self.max_bytes)
        {
            if let Some(oldest) = self.pop() {
                dropped(oldest);
            }
        }
        self.bytes += size;
        self.items.push_back((item, size));
    }

    /// Takes the oldest item.
    pub fn pop(&mut self) -> Option<T> {
        let (item, size) = self.items.pop_front()?;
        self.bytes -= size;
        Some(item)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_comes_out_is_what_went_in_without_the_dropped(
            steps in prop::collection::vec(prop::option::of(0_usize..40), 0..200)
        ) {
            let mut queue = Queue::new(4, 60);
            let (mut pushed, mut out, mut dropped) = (0, Vec::new(), Vec::new());
            for step in steps {
                match step {
                    Some(size) => {
                        queue.push(pushed, size, |item| dropped.push(item));
                        pushed += 1;
                        prop_assert!(queue.items.len() <= 4);
                        prop_assert!(queue.bytes <= 60);
                    }
                    None => out.extend(queue.pop()),
                }
            }
            while let Some(item) = queue.pop() {
                out.push(item);
            }
            prop_assert_eq!(queue.bytes, 0);
            prop_assert!(out.is_sorted() && dropped.is_sorted());
            let mut all: Vec<_> = out.into_iter().chain(dropped).collect();
            all.sort_unstable();
            prop_assert_eq!(all, (0..pushed).collect::<Vec<_>>());
        }
    }

    #[test]
    fn an_item_above_the_byte_bound_is_kept_alone() {
        let mut queue = Queue::new(4, 10);
        let mut dropped = 0;
        queue.push('a', 1, |_| dropped += 1);
        queue.push('b', 100, |_| dropped += 1);
        assert_eq!(
            (dropped, queue.pop(), queue.is_empty()),
            (1, Some('b'), true)
        );
    }
}
