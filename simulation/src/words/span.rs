//! Times and shares in words: `2.5s`, `-1h`, `10%`. Read and written without loss.

use std::time::Duration;

use jiff::SignedDuration;

/// Units and their nanoseconds.
const UNITS: [(&str, u128); 6] = [
    ("ns", 1),
    ("us", 1_000),
    ("ms", 1_000_000),
    ("s", 1_000_000_000),
    ("m", 60_000_000_000),
    ("h", 3_600_000_000_000),
];
/// Longest time that can be said: a year.
const LONGEST: Duration = Duration::from_secs(366 * 24 * 3600);

/// Reads a time.
pub fn read(word: &str) -> Option<Duration> {
    let end = word.find(|c: char| c.is_ascii_alphabetic())?;
    let (number, unit) = word.split_at(end);
    let (_, nanos) = UNITS.iter().find(|(name, _)| *name == unit)?;
    let total = scaled(number, *nanos)?;
    let nanos = u32::try_from(total % 1_000_000_000).ok()?;
    let time = Duration::new(u64::try_from(total / 1_000_000_000).ok()?, nanos);
    (time <= LONGEST).then_some(time)
}

/// A decimal number times a whole one; none when that is not whole, or too large.
fn scaled(number: &str, by: u128) -> Option<u128> {
    let (whole, part) = number.split_once('.').unwrap_or((number, ""));
    let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    if whole.is_empty() || whole.len() > 18 || part.len() > 18 || !digits(whole) || !digits(part) {
        return None;
    }
    if number.ends_with('.') {
        return None;
    }
    let all: u128 = format!("{whole}{part}").parse().ok()?;
    let ten = 10_u128.checked_pow(u32::try_from(part.len()).ok()?)?;
    let product = all.checked_mul(by)?;
    (product % ten == 0).then_some(product / ten)
}

/// Writes a time.
pub fn write(time: Duration) -> String {
    let nanos = time.as_nanos();
    let whole = UNITS
        .iter()
        .rev()
        .find(|(_, size)| nanos.is_multiple_of(*size));
    match whole {
        _ if nanos == 0 => "0s".to_owned(),
        // 2.5s is easier to read than 2500ms.
        Some(("ms", _)) if nanos > 1_000_000_000 => {
            let text = format!("{}.{:03}", nanos / 1_000_000_000, nanos / 1_000_000 % 1000);
            format!("{}s", text.trim_end_matches('0'))
        }
        Some((unit, size)) => format!("{}{unit}", nanos / size),
        None => format!("{nanos}ns"),
    }
}

/// Reads a time with a sign.
pub fn read_signed(word: &str) -> Option<SignedDuration> {
    let (negative, rest) = match word.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, word.strip_prefix('+').unwrap_or(word)),
    };
    let time = SignedDuration::try_from(read(rest)?).ok()?;
    Some(if negative { -time } else { time })
}

/// Writes a time with a sign.
pub fn write_signed(time: SignedDuration) -> String {
    let sign = if time.is_negative() { '-' } else { '+' };
    format!("{sign}{}", write(time.unsigned_abs()))
}

/// Reads a share in parts of a thousand.
pub fn read_share(word: &str) -> Option<u32> {
    let thousandths = scaled(word.strip_suffix('%')?, 10)?;
    u32::try_from(thousandths).ok().filter(|n| *n <= 1000)
}

/// Writes a share.
pub fn write_share(thousandths: u32) -> String {
    match (thousandths / 10, thousandths % 10) {
        (whole, 0) => format!("{whole}%"),
        (whole, part) => format!("{whole}.{part}%"),
    }
}
