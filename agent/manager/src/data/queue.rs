//! A bounded queue that drops its oldest items.

use std::collections::VecDeque;

use super::budget::Budget;

/// Bounded in items and in bytes, and by a budget that it shares with others.
#[derive(Debug)]
pub struct Queue<T> {
    items: VecDeque<(T, usize)>,
    bytes: usize,
    max_items: usize,
    max_bytes: usize,
    budget: &'static Budget,
}

impl<T> Queue<T> {
    /// An empty queue.
    pub fn new(max_items: usize, max_bytes: usize, budget: &'static Budget) -> Self {
        Self {
            items: VecDeque::new(),
            bytes: 0,
            max_items,
            max_bytes,
            budget,
        }
    }

    /// True without items.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// The oldest item.
    pub fn first(&self) -> Option<&T> {
        self.items.front().map(|(item, _)| item)
    }

    /// Appends an item of `size` bytes; what must go for it is handed to `dropped`, oldest first. The item itself is,
    /// when others hold the whole budget.
    pub fn push(&mut self, item: T, size: usize, mut dropped: impl FnMut(T)) {
        loop {
            let full = self.items.len() >= self.max_items
                || (self.bytes + size > self.max_bytes && !self.is_empty());
            if !full && self.budget.take(size) {
                break;
            }
            match self.pop() {
                Some(oldest) => dropped(oldest),
                None => return dropped(item),
            }
        }
        self.bytes += size;
        self.items.push_back((item, size));
    }

    /// Takes the oldest item.
    pub fn pop(&mut self) -> Option<T> {
        let (item, size) = self.items.pop_front()?;
        self.bytes -= size;
        self.budget.give(size);
        Some(item)
    }
}

impl<T> Drop for Queue<T> {
    fn drop(&mut self) {
        self.budget.give(self.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    static PLENTY: Budget = Budget::new(1 << 20);

    proptest! {
        #[test]
        fn what_comes_out_is_what_went_in_without_the_dropped(
            steps in prop::collection::vec(prop::option::of(0_usize..40), 0..200)
        ) {
            let mut queue = Queue::new(4, 60, &PLENTY);
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
        let mut queue = Queue::new(4, 10, &PLENTY);
        let mut dropped = 0;
        queue.push('a', 1, |_| dropped += 1);
        queue.push('b', 100, |_| dropped += 1);
        assert_eq!(
            (dropped, queue.pop(), queue.is_empty()),
            (1, Some('b'), true)
        );
    }

    #[test]
    fn queues_share_a_budget_and_give_it_back() {
        static SHARED: Budget = Budget::new(10);
        let (mut one, mut two) = (Queue::new(4, 10, &SHARED), Queue::new(4, 10, &SHARED));
        let mut dropped = Vec::new();
        one.push('a', 8, |item| dropped.push(item));
        two.push('b', 2, |item| dropped.push(item));
        two.push('c', 3, |item| dropped.push(item));
        assert_eq!(dropped, ['b', 'c']);
        drop(one);
        two.push('d', 10, |item| dropped.push(item));
        assert_eq!((dropped.len(), two.first()), (2, Some(&'d')));
        two.pop();
        assert!(SHARED.take(10));
    }
}
