//! Two lists of named things → one, in an order that neither list contradicts.

use std::collections::{HashMap, HashSet};

/// The things of `stored`, but those in `taken` as `new` has them, or not at all. What was stored keeps its place,
/// except that taken things stand among each other as in `new`; what was not stored follows what it follows there.
pub(super) fn merged<T: Clone>(
    stored: &[T],
    new: &[T],
    taken: &HashSet<&str>,
    name: impl Fn(&T) -> &str,
) -> Vec<T> {
    let known: HashSet<&str> = stored.iter().map(&name).collect();
    let there: HashSet<&str> = new.iter().map(&name).collect();
    let is_taken = |thing: &&T| taken.contains(name(thing));
    let mut places = new
        .iter()
        .filter(is_taken)
        .filter(|thing| known.contains(name(thing)));
    let followers = followers(stored, new, taken, &name);
    let mut all: Vec<T> = Vec::new();
    let add_followers = |all: &mut Vec<T>, of: Option<&str>| {
        let list = followers.get(&of).into_iter().flatten();
        all.extend(list.map(|&thing| thing.clone()));
    };
    add_followers(&mut all, None);
    for thing in stored {
        let placed = match is_taken(&thing) {
            true if !there.contains(name(thing)) => None,
            true => places.next(),
            false => Some(thing),
        };
        if let Some(placed) = placed {
            all.push(placed.clone());
            add_followers(&mut all, Some(name(placed)));
        }
    }
    all
}

/// Taken things that are not stored, by the nearest thing before them in `new` that stays or is taken.
fn followers<'a, T>(
    stored: &'a [T],
    new: &'a [T],
    taken: &HashSet<&str>,
    name: impl Fn(&T) -> &str,
) -> HashMap<Option<&'a str>, Vec<&'a T>> {
    let known: HashSet<&str> = stored.iter().map(&name).collect();
    let mut followers: HashMap<Option<&str>, Vec<&T>> = HashMap::new();
    let mut before = None;
    for thing in new {
        let own = name(thing);
        if known.contains(own) {
            before = Some(own);
        } else if taken.contains(own) {
            followers.entry(before).or_default().push(thing);
        }
    }
    followers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names in capitals are those of the new list.
    fn merge(stored: &str, new: &str, taken: &str) -> String {
        let list = |text: &str| {
            text.split_whitespace()
                .map(str::to_owned)
                .collect::<Vec<_>>()
        };
        let new: Vec<(String, bool)> = list(new).into_iter().map(|n| (n, true)).collect();
        let stored: Vec<(String, bool)> = list(stored).into_iter().map(|n| (n, false)).collect();
        let taken = taken.split_whitespace().collect();
        let all = merged(&stored, &new, &taken, |(name, _)| name);
        let shown = all.into_iter().map(|(name, is_new)| match is_new {
            true => name.to_uppercase(),
            false => name,
        });
        shown.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn what_is_stored_keeps_its_place() {
        assert_eq!(merge("a b c", "c x b a", ""), "a b c");
        assert_eq!(merge("a b c", "c x b a", "b"), "a B c");
        assert_eq!(merge("a b c", "a x b y c z", "x y z"), "a X b Y c Z");
        assert_eq!(merge("a b c", "x y", "x y b"), "X Y a c");
        assert_eq!(merge("", "x y z", "x z"), "X Z");
    }

    #[test]
    fn with_everything_taken_it_is_the_new_list() {
        assert_eq!(merge("a b c d", "x c y a z", "a b c d x y z"), "X C Y A Z");
    }
}
