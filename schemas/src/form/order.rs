//! In which order the parts of an element are written: as read, without what is gone, and with what is new or was moved.

use super::{FieldKind, Form, Place, Value};

/// The order of an element's attributes.
pub(super) fn attribute_order(form: &dyn Form, read: &[Place], others: usize) -> Vec<Place> {
    let values = |kind: FieldKind| kind.is_attribute();
    merged(form, read, others, values, |at, read| {
        let mut left = form.value(at).count();
        let keep = |_: &usize| {
            let keeps = left > 0;
            left -= usize::from(keeps);
            keeps
        };
        let kept: Vec<_> = read.iter().copied().filter(keep).map(Some).collect();
        Own::all(kept, form.value(at).count())
    })
}

/// The order of an element's nodes. A value is told by where it started in the file, so that comments stay beside what
/// they were written beside; what is new stands after the value before it.
pub(super) fn node_order(form: &dyn Form, read: &[Place], others: usize) -> Vec<Place> {
    let values = |kind: FieldKind| !kind.is_attribute();
    merged(form, read, others, values, |at, own| {
        let starts = starts(&form.value(at));
        let known = starts.iter().any(Option::is_some);
        if !known {
            let count = starts.len().min(own.len());
            let kept = own[..count].iter().copied().map(Some).collect();
            return Own::all(kept, starts.len());
        }
        let mut by_start: Vec<(u32, usize)> = own
            .iter()
            .filter_map(|index| Some((read[*index].start()?, *index)))
            .collect();
        by_start.sort_unstable();
        let find = |start: &Option<u32>| {
            let at = by_start.binary_search_by_key(&(*start)?, |(start, _)| *start);
            Some(by_start[at.ok()?].1)
        };
        let known: Vec<_> = starts.iter().map(find).collect();
        Own {
            stay: staying(&known),
            known,
        }
    })
}

/// Of each value of a field.
struct Own {
    /// The place where it was read and where it stays.
    stay: Vec<Option<usize>>,
    /// The place where it was read.
    known: Vec<Option<usize>>,
}

impl Own {
    /// The first values stay, the others are new.
    fn all(mut kept: Vec<Option<usize>>, count: usize) -> Self {
        kept.resize(count, None);
        Self {
            known: kept.clone(),
            stay: kept,
        }
    }
}

/// Where each value of a field started in the file; nothing for a new one.
fn starts(value: &Value<'_>) -> Vec<Option<u32>> {
    let start = |span: crate::span::Span| (!span.is_unknown()).then_some(span.start);
    match value {
        Value::Text(text) => text.iter().map(|text| start(text.span)).collect(),
        Value::Texts(texts) => texts.iter().map(|text| start(text.span)).collect(),
        Value::Forms(forms) => (0..forms.count())
            .map(|index| forms.form(index).and_then(|form| start(form.span())))
            .collect(),
    }
}

/// `own` says for each value of a field where it was read, and whether it stays there.
fn merged(
    form: &dyn Form,
    read: &[Place],
    others: usize,
    values: impl Fn(FieldKind) -> bool,
    own: impl Fn(usize, &[usize]) -> Own,
) -> Vec<Place> {
    let fields = form.form_type().fields;
    let mut places: Vec<Vec<usize>> = vec![Vec::new(); fields.len()];
    for (index, place) in read.iter().enumerate() {
        if let Some(places) = place.field().and_then(|at| places.get_mut(at)) {
            places.push(index);
        }
    }
    // What stands before and after each place that is kept; nothing for a place that is not.
    let mut around: Vec<Option<[Vec<Place>; 2]>> = vec![None; read.len()];
    let mut free = Vec::new();
    let elements = fields.iter().enumerate();
    for (at, _) in elements.filter(|(_, field)| values(field.kind)) {
        let own = own(at, &places[at]);
        let mut before = Vec::new();
        let mut last: Option<usize> = None;
        for (stay, known) in own.stay.into_iter().zip(own.known) {
            if let Some(index) = stay {
                around[index] = Some([std::mem::take(&mut before), Vec::new()]);
                last = Some(index);
                continue;
            }
            // What was moved keeps its spelling.
            let place = known.map_or(Place::fresh(at), |index| read[index]);
            match last.and_then(|last| around[last].as_mut()) {
                Some([_, after]) => after.push(place),
                None => before.push(place),
            }
        }
        if !before.is_empty() {
            free.push((at, before));
        }
    }
    let mut order = Vec::with_capacity(read.len());
    let mut left = others;
    for (place, around) in read.iter().zip(around) {
        match (place.field(), around) {
            (None, _) if left > 0 => {
                left -= 1;
                order.push(Place::Other);
            }
            (Some(_), Some([before, after])) => {
                order.extend(before);
                order.push(*place);
                order.extend(after);
            }
            _ => {}
        }
    }
    for (at, places) in free {
        let earlier = |place: &Place| place.field().is_some_and(|other| other <= at);
        let first = || order.iter().position(|place| place.field().is_some());
        let last = order.iter().rposition(earlier).map(|last| last + 1);
        let from = last.or_else(first).unwrap_or(0);
        order.splice(from..from, places);
    }
    order.extend(std::iter::repeat_n(Place::Other, left));
    order
}

/// Of items that have a place in an old list, as many as can stay where they are: a longest run of growing places. The
/// others, and those without a place, give nothing.
pub(super) fn staying(places: &[Option<usize>]) -> Vec<Option<usize>> {
    // `ends[n]`: the item that ends the best run of n + 1 items; `before`: the item before each in its run.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = vec![None; places.len()];
    for (item, place) in places.iter().enumerate() {
        let Some(place) = place else { continue };
        let length = ends.partition_point(|end| places[*end].is_some_and(|other| other < *place));
        before[item] = length.checked_sub(1).map(|last| ends[last]);
        match ends.get_mut(length) {
            Some(end) => *end = item,
            None => ends.push(item),
        }
    }
    let mut stay = vec![None; places.len()];
    let mut next = ends.last().copied();
    while let Some(item) = next {
        stay[item] = places[item];
        next = before[item];
    }
    stay
}

#[cfg(test)]
mod tests {
    use super::staying;

    #[test]
    fn as_many_as_can_stay_do() {
        let all = |places: &[usize]| {
            let places: Vec<_> = places.iter().copied().map(Some).collect();
            staying(&places).into_iter().flatten().collect::<Vec<_>>()
        };
        assert_eq!(all(&[0, 1, 2]), [0, 1, 2]);
        assert_eq!(all(&[2, 0, 1]), [0, 1]);
        assert_eq!(all(&[1, 2, 0]), [1, 2]);
        assert_eq!(all(&[]), [] as [usize; 0]);
        // One place is kept once.
        assert_eq!(all(&[0, 0, 1]), [0, 1]);
        assert_eq!(staying(&[None, Some(3), None]), [None, Some(3), None]);
    }
}
