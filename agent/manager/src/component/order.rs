//! The order in which an execution context runs its components, and the two passes of its cycle. Pure.

/// Where a component stands: lower numbers first, those with the same number by name.
pub type Standing<'a> = (i32, &'a str);

/// The place of a new one among those that stand in order.
pub fn place<'a>(standing: impl Iterator<Item = Standing<'a>>, new: Standing<'_>) -> usize {
    standing.take_while(|other| *other <= new).count()
}

/// What takes part in cycles.
pub trait TakesPart {
    /// First pass: `on_execute`, or `on_error`. Remembers whether there is a second for it.
    fn first(&mut self);
    /// Second pass: `on_state_update`, when there is one.
    fn second(&mut self);
}

/// One cycle: the first pass of all in order, then the second of all in order.
pub fn cycle(members: &mut [impl TakesPart]) {
    members.iter_mut().for_each(TakesPart::first);
    members.iter_mut().for_each(TakesPart::second);
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use proptest::prelude::*;

    use super::*;

    struct Traced<'a> {
        number: usize,
        fails: bool,
        trace: &'a RefCell<Vec<(u8, usize)>>,
    }

    impl TakesPart for Traced<'_> {
        fn first(&mut self) {
            self.trace.borrow_mut().push((1, self.number));
        }

        fn second(&mut self) {
            if !self.fails {
                self.trace.borrow_mut().push((2, self.number));
            }
        }
    }

    proptest! {
        #[test]
        fn whoever_comes_and_goes_the_rest_stand_by_number_and_name(
            steps in proptest::collection::vec((any::<bool>(), -3_i32..3, "[a-c]{1,2}"), 0..40)
        ) {
            let mut standing: Vec<(i32, String)> = Vec::new();
            for (comes, number, name) in steps {
                standing.retain(|(_, other)| *other != name);
                if comes {
                    let others = standing.iter().map(|(number, name)| (*number, name.as_str()));
                    let at = place(others, (number, &name));
                    standing.insert(at, (number, name));
                }
                prop_assert!(standing.is_sorted(), "{standing:?}");
            }
        }

        #[test]
        fn every_first_pass_comes_before_every_second_and_both_go_in_order(
            fails in proptest::collection::vec(any::<bool>(), 0..8)
        ) {
            let trace = RefCell::default();
            let all = fails.iter().enumerate();
            let mut members: Vec<_> = all
                .map(|(number, fails)| Traced { number, fails: *fails, trace: &trace })
                .collect();
            cycle(&mut members);
            let ran = trace.borrow().clone();
            prop_assert!(ran.is_sorted(), "{ran:?}");
            let both = |pass, who| ran.contains(&(pass, who));
            for (number, fails) in fails.iter().enumerate() {
                prop_assert!(both(1, number), "whatever became of the others");
                prop_assert_eq!(both(2, number), !fails);
            }
        }
    }
}
