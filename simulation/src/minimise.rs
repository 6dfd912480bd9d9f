//! Makes a schedule that fails smaller, as long as the same invariant still fails: by leaving out, first faults and deeds,
//! then components (delta debugging, Zeller and Hildebrandt).

use std::collections::BTreeSet;

use crate::schedule::Schedule;

/// A smaller schedule and what was left out of the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimised {
    /// What is left.
    pub schedule: Schedule,
    /// Names of all that was left out.
    pub without: BTreeSet<String>,
    /// Schedules that were tried.
    pub tries: u32,
}

/// Leaves out what can be left out. `fails` runs a schedule; `most` bounds how often.
pub fn minimise(schedule: &Schedule, most: u32, fails: impl FnMut(&Schedule) -> bool) -> Minimised {
    let mut search = Search {
        whole: schedule,
        without: BTreeSet::new(),
        tries: 0,
        most,
        fails,
    };
    let deeds = schedule.deeds.iter().map(|d| d.name.clone());
    let faults = schedule.faults.iter().map(|f| f.name.clone());
    search.narrow(faults.chain(deeds).collect());
    search.narrow(schedule.components().collect());
    Minimised {
        schedule: schedule.without(&search.without),
        without: search.without,
        tries: search.tries,
    }
}

struct Search<'a, F> {
    whole: &'a Schedule,
    without: BTreeSet<String>,
    tries: u32,
    most: u32,
    fails: F,
}

impl<F: FnMut(&Schedule) -> bool> Search<'_, F> {
    /// Leaves out as many of these as can be: in large parts first, at last one by one.
    fn narrow(&mut self, mut left: Vec<String>) {
        let mut size = left.len();
        while size > 0 {
            let mut again = false;
            let mut at = 0;
            while at < left.len() {
                let part: Vec<String> = left.iter().skip(at).take(size).cloned().collect();
                if self.can_go(&part) {
                    left.retain(|name| !part.contains(name));
                    again = true;
                } else {
                    at += size;
                }
            }
            // What could not go alone may go now that others have gone.
            if !(again && size == 1) {
                size /= 2;
            }
        }
    }

    fn can_go(&mut self, part: &[String]) -> bool {
        if self.tries >= self.most {
            return false;
        }
        self.tries += 1;
        let mut without = self.without.clone();
        without.extend(part.iter().cloned());
        let less = self.whole.without(&without);
        // A system keeps one component: without it, nothing would be another.
        if less == self.whole.without(&self.without) || !(self.fails)(&less) {
            return false;
        }
        self.without = without;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;

    fn schedule() -> Schedule {
        let all = (0..).map(|seed| Schedule::of(Seed(seed)));
        let mut large = all.filter(|s| s.faults.len() > 4 && s.deeds.len() > 4);
        large.next().unwrap()
    }

    #[test]
    fn what_it_takes_is_left_and_nothing_else() {
        let schedule = schedule();
        let needed = [
            &schedule.faults[1].name,
            &schedule.faults[4].name,
            &schedule.deeds[3].name,
        ];
        let takes = |s: &Schedule| needed.iter().all(|name| s.names().contains(name));
        let found = minimise(&schedule, 1000, takes);
        let mut left: Vec<String> = found
            .schedule
            .faults
            .iter()
            .map(|f| f.name.clone())
            .collect();
        left.extend(found.schedule.deeds.iter().map(|d| d.name.clone()));
        assert_eq!(left, needed.map(String::as_str));
        assert_eq!(
            found.schedule.components().count(),
            found.schedule.systems.len()
        );
        assert_eq!(found.schedule, schedule.without(&found.without));
    }

    #[test]
    fn it_ends_after_so_many_tries() {
        let found = minimise(&schedule(), 5, |_| true);
        assert!(found.tries <= 5);
    }
}
