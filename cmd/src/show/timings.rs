//! Where the time of a command went: the critical path, and what is on it.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use rts_agent_api::messages::TimedSpan;

use super::table::Table;

/// Shorter stretches of the path are only counted.
const SHOWN: u64 = 100;

/// The program whose laps begin and end one after the other.
pub const OWN: &str = "rtsctl";
/// The lap in which the controller plans.
pub const PLAN: &str = "plan";
/// The lap in which the controller stores what is to run.
pub const APPLY: &str = "apply";
/// The lap in which the controller stores that nothing is to run any more.
pub const TEARDOWN: &str = "teardown";
/// The lap in which the controller carries out what it has stored.
pub const FOLLOW: &str = "follow";
const ASKING: [&str; 3] = [PLAN, APPLY, TEARDOWN];
const ALL: [&str; 4] = [PLAN, APPLY, TEARDOWN, FOLLOW];

/// A stretch of time, and what was waited for in it: nothing that is known, or the innermost span.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stretch<'a> {
    span: Option<&'a TimedSpan>,
    start: u64,
    end: u64,
}

/// How far inside a span is: what a program asks of another is inside of the asking. A disk is waited for where nothing
/// else is done meanwhile.
fn inside(span: &TimedSpan) -> (u8, u32) {
    let rank = match (span.program.as_str(), span.what.as_str()) {
        (OWN, _) => 0,
        ("controller", "node specs" | "send") => 1,
        (_, "store" | "ledger") => 2,
        ("controller", _) => 3,
        _ => 4,
    };
    (rank, span.depth)
}

/// The parts of a span that may have been waited for. The controller answers a request with some spans, and carries out
/// what was stored with others, which begin while it is being stored; both go on for earlier commands too, while `rtsctl`
/// does something else.
fn waited<'a>(
    span: &TimedSpan,
    laps: impl Iterator<Item = &'a TimedSpan>,
    counts: Option<u64>,
) -> Vec<TimedSpan> {
    if span.program == OWN {
        return vec![span.clone()];
    }
    let carries_out = || counts.is_some_and(|counts| span.start >= counts);
    let answers = match span.what.as_str() {
        "modules" | "decide" => &ASKING[..],
        "store" if span.of.starts_with("system/") => &ASKING[..],
        "look" => &ALL[..],
        _ if carries_out() => &ALL[..],
        _ => &[FOLLOW],
    };
    laps.filter(|lap| answers.contains(&lap.what.as_str()))
        .map(|lap| TimedSpan {
            start: span.start.max(lap.start),
            end: span.end.min(lap.end),
            ..span.clone()
        })
        .filter(|part| part.start < part.end)
        .collect()
}

/// When what is asked for began to count: it was decided, and began to be stored.
fn counts(spans: &[TimedSpan]) -> Option<u64> {
    let mut laps = spans.iter().filter(|span| span.program == OWN);
    let asked = laps.find(|lap| lap.what == APPLY || lap.what == TEARDOWN)?;
    let stores = |span: &&TimedSpan| span.what == "store" && span.of.starts_with("system/");
    let within = |span: &&TimedSpan| asked.start <= span.start && span.start < asked.end;
    let stores = spans.iter().filter(stores).filter(within);
    stores.map(|span| span.start).min()
}

/// Goes back from the end: what ended last was waited for, and before it began whatever ended last then.
fn critical_path(spans: &[TimedSpan], begin: u64, end: u64) -> Vec<Stretch<'_>> {
    let mut path = Vec::new();
    let mut at = end;
    while at > begin {
        let open = spans
            .iter()
            .filter(|span| span.start < at && at <= span.end);
        // Of several at once the one that took longest.
        let innermost = open.max_by_key(|span| (inside(span), Reverse(span.start)));
        let from = innermost.map_or(begin, |span| span.start.max(begin));
        let deeper = spans
            .iter()
            .filter(|span| innermost.is_none_or(|outer| inside(span) > inside(outer)));
        let ends = deeper.map(|span| span.end).filter(|end| *end < at);
        let start = ends.fold(from, u64::max);
        path.push(Stretch {
            span: innermost,
            start,
            end: at,
        });
        at = start;
    }
    path.reverse();
    path
}

/// The path and the sums, times in milliseconds since `begin`.
pub fn text(spans: &[TimedSpan], begin: u64, end: u64) -> String {
    let laps = || spans.iter().filter(|span| span.program == OWN);
    let counts = counts(spans);
    let parts = spans.iter().flat_map(|span| waited(span, laps(), counts));
    let parts: Vec<TimedSpan> = parts.collect();
    let path = critical_path(&parts, begin, end);
    let mut on_path = Table::new(&["START", "TOOK", "WHO", "WHAT"]);
    let (mut short, mut left_out) = (0, 0);
    for stretch in &path {
        let took = stretch.end - stretch.start;
        if took < SHOWN {
            short += 1;
            left_out += took;
            continue;
        }
        let (who, what) = stretch
            .span
            .map_or((String::new(), "not known".to_owned()), words);
        on_path.row([ms(stretch.start - begin), ms(took), who, what]);
    }
    format!(
        "critical path: {} ms from the start of rtsctl, {} ms of it in stretches shorter than {} ms ({short})\n{}\n\
         all spans (ms)\n{}",
        ms(end - begin),
        ms(left_out),
        ms(SHOWN),
        on_path.render(true, false),
        sums(spans, &path).render(true, false),
    )
}

fn words(span: &TimedSpan) -> (String, String) {
    let of = match span.of.as_str() {
        "" => String::new(),
        of => format!(" {of}"),
    };
    (span.program.clone(), format!("{}{of}", span.what))
}

/// What was done how often, for how long together and at most, and how long it was waited for.
#[derive(Default)]
struct Sum {
    first: u64,
    count: usize,
    total: u64,
    longest: u64,
    waited: u64,
}

fn sums(spans: &[TimedSpan], path: &[Stretch<'_>]) -> Table {
    let mut sums: BTreeMap<(&str, &str), Sum> = BTreeMap::new();
    for span in spans {
        let sum = sums.entry((&span.program, &span.what)).or_default();
        let took = span.end - span.start;
        sum.first = if sum.count == 0 {
            span.start
        } else {
            sum.first.min(span.start)
        };
        sum.count += 1;
        sum.total += took;
        sum.longest = sum.longest.max(took);
    }
    for stretch in path {
        let Some(span) = stretch.span else { continue };
        if let Some(sum) = sums.get_mut(&(span.program.as_str(), span.what.as_str())) {
            sum.waited += stretch.end - stretch.start;
        }
    }
    let mut rows: Vec<_> = sums.into_iter().collect();
    rows.sort_by_key(|(_, sum)| sum.first);
    let mut table = Table::new(&["WHO", "WHAT", "COUNT", "TOTAL", "LONGEST", "ON-PATH"]);
    for ((who, what), sum) in rows {
        table.row([
            who.to_owned(),
            what.to_owned(),
            sum.count.to_string(),
            ms(sum.total),
            ms(sum.longest),
            ms(sum.waited),
        ]);
    }
    table
}

fn ms(micros: u64) -> String {
    format!("{:.2}", micros as f64 / 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn span(program: &str, what: &str, depth: u32, start: u64, end: u64) -> TimedSpan {
        TimedSpan {
            program: program.to_owned(),
            what: what.to_owned(),
            of: String::new(),
            depth,
            start,
            end,
        }
    }

    #[test]
    fn what_ended_last_was_waited_for() {
        let spans = [
            span("rtsctl", "read files", 0, 0, 1_000),
            span("rtsctl", "apply", 0, 1_000, 3_000),
            // Of the command before: nobody waits for it.
            span("controller", "send", 1, 200, 2_900),
            span("agent a", "ledger", 0, 300, 2_800),
            span("controller", "decide", 0, 1_500, 2_500),
            span("rtsctl", "follow", 0, 3_000, 20_000),
            span("controller", "batch", 0, 4_000, 18_000),
            span("agent a", "StartManager", 0, 5_000, 15_000),
            span("agent a", "ready", 1, 6_000, 14_950),
            span("agent a", "StartManager", 0, 5_100, 9_000),
            span("agent a", "Create", 0, 15_000, 17_000),
        ];
        insta::assert_snapshot!(text(&spans, 0, 20_000));
    }

    #[test]
    fn what_is_carried_out_while_it_is_stored_was_waited_for() {
        let of = |of: &str, span: TimedSpan| TimedSpan {
            of: of.to_owned(),
            ..span
        };
        let spans = [
            span("rtsctl", "connect", 0, 0, 1_000),
            span("rtsctl", "teardown", 0, 1_000, 6_000),
            // For another one: it began before ours counted.
            span("controller", "run", 0, 1_200, 5_000),
            of("system/x", span("controller", "store", 0, 2_000, 3_500)),
            span("controller", "node specs", 0, 2_100, 3_000),
            span("controller", "run", 0, 3_000, 8_000),
            span("agent a", "StopManager", 0, 4_000, 7_500),
            // Nothing waits for its disk, but at the end.
            span("agent a", "ledger", 0, 2_900, 8_500),
            span("rtsctl", "follow", 0, 6_000, 9_000),
        ];
        insta::assert_snapshot!(text(&spans, 0, 9_000));
    }

    proptest! {
        /// The stretches lie one behind the other, and cover all of the time.
        #[test]
        fn a_path_has_no_holes(
            spans in proptest::collection::vec((0u8..3, 0u32..3, 0u64..50, 0u64..50), 0..20),
        ) {
            let spans: Vec<_> = spans
                .into_iter()
                .map(|(program, depth, start, took)| {
                    let program = ["rtsctl", "controller", "agent a"][usize::from(program)];
                    span(program, "x", depth, start, start + took)
                })
                .collect();
            let mut at = 10;
            for stretch in critical_path(&spans, 10, 80) {
                prop_assert_eq!(stretch.start, at);
                prop_assert!(stretch.end > at);
                at = stretch.end;
            }
            prop_assert_eq!(at, 80);
        }
    }
}
