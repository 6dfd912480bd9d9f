//! A date as text and as the parts that YAML files have: `{year, month, day, hour, minute, second}` and sometimes more.

/// Names of the parts, in the order in which they are written.
pub(super) const PARTS: [&str; 9] = [
    "year",
    "month",
    "day",
    "hour",
    "minute",
    "second",
    "millisecond",
    "timezone",
    "fractionalSecond",
];

/// The text of parts, as XML Schema writes it. It is only shown, so it need not be valid.
pub(super) fn text(part: impl Fn(&str) -> Option<String>) -> String {
    let whole = |name: &str| part(name).unwrap_or_else(|| "0".to_owned());
    let fraction = part("millisecond")
        .and_then(|text| text.parse::<u16>().ok())
        .filter(|milliseconds| (1..1000).contains(milliseconds))
        .map_or(String::new(), |milliseconds| format!(".{milliseconds:03}"));
    let zone = part("timezone")
        .and_then(|text| text.parse::<i16>().ok())
        .map_or(String::new(), |minutes| {
            let sign = if minutes < 0 { '-' } else { '+' };
            let minutes = minutes.unsigned_abs();
            format!("{sign}{:02}:{:02}", minutes / 60, minutes % 60)
        });
    format!(
        "{}-{:0>2}-{:0>2}T{:0>2}:{:0>2}:{:0>2}{fraction}{zone}",
        whole("year"),
        whole("month"),
        whole("day"),
        whole("hour"),
        whole("minute"),
        whole("second")
    )
}

/// The parts of a text, when they say all of it.
pub(super) fn parts(value: &str) -> Option<Vec<(&'static str, String)>> {
    let (day, time) = value.split_once('T')?;
    let (time, zone) = match time.find(['+', '-']) {
        Some(at) => (&time[..at], Some(&time[at..])),
        None => (time, None),
    };
    let (time, fraction) = match time.split_once('.') {
        Some((time, fraction)) => (time, Some(fraction)),
        None => (time, None),
    };
    let (day, time): (Vec<&str>, Vec<&str>) = (day.split('-').collect(), time.split(':').collect());
    let ([year, month, day], [hour, minute, second]) = (day.as_slice(), time.as_slice()) else {
        return None;
    };
    let mut parts = Vec::new();
    for (name, text) in PARTS
        .into_iter()
        .zip([year, month, day, hour, minute, second])
    {
        parts.push((name, text.parse::<u16>().ok()?.to_string()));
    }
    if let Some(fraction) = fraction {
        parts.push(("millisecond", fraction.parse::<u16>().ok()?.to_string()));
    }
    if let Some(zone) = zone {
        let (hours, minutes) = zone.get(1..)?.split_once(':')?;
        let minutes = hours.parse::<i16>().ok()?.checked_mul(60)? + minutes.parse::<i16>().ok()?;
        let minutes = if zone.starts_with('-') {
            -minutes
        } else {
            minutes
        };
        parts.push(("timezone", minutes.to_string()));
    }
    let part = |name: &str| {
        let found = parts.iter().find(|(known, _)| *known == name);
        found.map(|(_, value)| value.clone())
    };
    (year.len() == 4 && text(part) == value).then_some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_say_all_or_nothing() {
        for whole in [
            "2013-08-01T15:23:27",
            "2013-08-01T15:23:27+09:00",
            "2013-08-01T15:23:27.120-03:30",
        ] {
            let parts = parts(whole).unwrap();
            let part = |name: &str| parts.iter().find(|p| p.0 == name).map(|p| p.1.clone());
            assert_eq!(text(part), whole);
        }
        for other in [
            "",
            "today",
            "2013-8-1T15:23:27",
            "2013-08-01T15:23:27Z",
            "2013-08-01T15:23:27.000",
            "2013-08-01T15:23:27+900:00",
            "2013-08-01T15:23:27+99999:00",
            "0001-01-01T00:00:00",
            "2013-08-01T15:23:27-00:00",
            "2013-08-01T15:23:+7",
        ] {
            assert_eq!(parts(other), None, "{other}");
        }
    }
}
