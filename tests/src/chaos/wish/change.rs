//! What must change when one wish takes the place of another, and what must not.

use std::collections::BTreeSet;

use super::{Part, Wish};

/// Instances that must not go on as they are when one wish takes the place of another.
pub fn touched(before: Option<&Wish>, after: Option<&Wish>) -> BTreeSet<String> {
    let all = [before, after].into_iter().flatten().flat_map(|w| &w.parts);
    let stays = |part: &Part| {
        let of = |wish: Option<&Wish>| wish.and_then(|w| w.part(&part.instance)).cloned();
        matches!((of(before), of(after)), (Some(b), Some(a)) if b.is_same(&a))
    };
    all.filter(|part| !stays(part))
        .map(|part| part.instance.clone())
        .collect()
}

/// Connectors that must not go on as they are: other ones, and those with an end that does not.
pub fn rewired(before: Option<&Wish>, after: Option<&Wish>) -> BTreeSet<String> {
    let touched = touched(before, after);
    let of = |wish: Option<&Wish>| wish.map(Wish::connectors).unwrap_or_default();
    let (before, after) = (of(before), of(after));
    let instance = |end: &str| end.split('.').next().unwrap_or_default().to_owned();
    let stays = |connector: &(String, String, String)| {
        before.contains(connector)
            && after.contains(connector)
            && !touched.contains(&instance(&connector.1))
            && !touched.contains(&instance(&connector.2))
    };
    let all = before.iter().chain(&after);
    all.filter(|connector| !stays(connector))
        .map(|connector| connector.0.clone())
        .collect()
}
