//! Ages as kubectl writes them.

use jiff::{SignedDuration, Timestamp};

/// Age of a moment: `5s`, `2m30s`, `3h`, `4d`; `-` when the moment is not known.
pub fn age(since: Option<Timestamp>, now: Timestamp) -> String {
    since.map_or_else(
        || "-".to_owned(),
        |since| duration(now.duration_since(since)),
    )
}

/// The rules of kubectl's `HumanDuration`: two units while the second still matters.
fn duration(age: SignedDuration) -> String {
    let seconds = age.as_secs().max(0);
    let (minutes, hours, days) = (seconds / 60, seconds / 3600, seconds / 86_400);
    match seconds {
        0..120 => format!("{seconds}s"),
        120..600 => two(minutes, 'm', seconds % 60, 's'),
        600..10_800 => format!("{minutes}m"),
        10_800..28_800 => two(hours, 'h', minutes % 60, 'm'),
        28_800..172_800 => format!("{hours}h"),
        172_800..691_200 => two(days, 'd', hours % 24, 'h'),
        _ if days < 730 => format!("{days}d"),
        _ => two(days / 365, 'y', days % 365, 'd'),
    }
}

fn two(first: i64, unit: char, second: i64, second_unit: char) -> String {
    if second == 0 {
        format!("{first}{unit}")
    } else {
        format!("{first}{unit}{second}{second_unit}")
    }
}

/// A time of less than minutes: `950ns`, `16us`, `2.5ms`, `1.2s`.
pub fn short_time(nanoseconds: u64) -> String {
    let tenths = |unit: u64| (nanoseconds / unit, nanoseconds % unit / (unit / 10));
    let (unit, name) = match nanoseconds {
        0..1_000 => return format!("{nanoseconds}ns"),
        1_000..1_000_000 => (1_000, "us"),
        1_000_000..1_000_000_000 => (1_000_000, "ms"),
        _ => (1_000_000_000, "s"),
    };
    match tenths(unit) {
        (whole, tenth) if whole < 10 && tenth > 0 => format!("{whole}.{tenth}{name}"),
        (whole, _) => format!("{whole}{name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_times_have_two_digits_that_matter() {
        let shown = [
            0,
            999,
            1_000,
            1_200,
            16_383,
            131_071,
            2_500_000,
            1_999_999_999,
        ];
        let expected = [
            "0ns", "999ns", "1us", "1.2us", "16us", "131us", "2.5ms", "1.9s",
        ];
        assert_eq!(shown.map(short_time), expected);
    }

    #[test]
    fn ages_look_as_in_kubectl() {
        let of = |seconds| duration(SignedDuration::from_secs(seconds));
        let (minute, hour, day) = (60, 3600, 86_400);
        assert_eq!(of(-3), "0s");
        assert_eq!(of(5), "5s");
        assert_eq!(of(119), "119s");
        assert_eq!(of(2 * minute), "2m");
        assert_eq!(of(2 * minute + 30), "2m30s");
        assert_eq!(of(10 * minute + 5), "10m");
        assert_eq!(of(3 * hour), "3h");
        assert_eq!(of(3 * hour + 4 * minute), "3h4m");
        assert_eq!(of(9 * hour), "9h");
        assert_eq!(of(2 * day + 3 * hour), "2d3h");
        assert_eq!(of(10 * day), "10d");
        assert_eq!(of(800 * day), "2y70d");
        assert_eq!(age(None, Timestamp::UNIX_EPOCH), "-");
    }
}
