//! Files that are no overlay at all: what they are, and what was wanted.

use crate::diagnostic::{Finding, Source};
use crate::span::Span;
use crate::yaml::{Node, Value};
use crate::{rtc_profile, rts_profile, xml};

/// What was wanted.
const WANTED: &str = "an overlay starts with `apiVersion: rtsctl.dev/v1` and `kind: Deployment`";

const SYSTEM: &str = "this is an RTS Profile, which describes a system: name it first, then the overlays (`rtsctl check PROFILE -f OVERLAY`)";

const COMPONENT: &str = "this is an RTC Profile, which describes one type of component: name it with `rtsctl check PROFILE --rtc FILE`";

/// Says what a file without a mapping is.
pub(super) fn other(source: &Source) -> Option<Finding> {
    let start = source.text().trim_start();
    if start.is_empty() {
        return Some(empty(source));
    }
    if !start.starts_with('<') {
        return None;
    }
    let root = xml::parse_tree(source.text()).ok().map(|tree| tree.root);
    let local = root.as_ref().map_or("", |root| root.local());
    let help = match local {
        name if rts_profile::forms::WORDS.roots.contains(&name) => SYSTEM,
        name if rtc_profile::forms::WORDS.roots.contains(&name) => COMPONENT,
        _ => WANTED,
    };
    let message = format!("{} is XML, but an overlay is YAML", source.name());
    let at = source.text().len() - start.len();
    let span = root.map_or(Span::new(at, at + 1), |root| root.span);
    let place = source.place(span.start, span.end);
    Some(
        Finding::error("wrong-root", message)
            .at(Some(place))
            .help(help),
    )
}

/// The same for a file that is YAML.
pub(super) fn other_root(root: &Node, source: &Source) -> Option<Finding> {
    if root.value == Value::Null {
        return Some(empty(source));
    }
    let found = root.entries().iter().find_map(|(key, _)| {
        let (what, help) = match key.value.as_str() {
            name if name == rts_profile::forms::WORDS.key => ("an RTS Profile", SYSTEM),
            name if name == rtc_profile::forms::WORDS.key => ("an RTC Profile", COMPONENT),
            _ => return None,
        };
        Some((key.span, what, help))
    });
    let (span, what, help) = found?;
    let message = format!("{} is {what}, not an overlay", source.name());
    let place = (!span.is_unknown()).then(|| source.place(span.start, span.end));
    Some(Finding::error("wrong-root", message).at(place).help(help))
}

fn empty(source: &Source) -> Finding {
    let message = format!("{} is empty", source.name());
    let place = Some(source.place(0, 0));
    Finding::error("empty-file", message).at(place).help(WANTED)
}
