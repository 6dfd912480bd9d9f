//! Numbers of bytes and rates with three digits.

/// Bytes as people read them: `512 B`, `7.88 MiB`.
pub fn bytes(bytes: f64) -> String {
    let (mut value, mut unit) = (bytes.max(0.0), "B");
    for larger in ["KiB", "MiB", "GiB", "TiB"] {
        // What would be shown as 1000.
        if value < 999.5 {
            break;
        }
        (value, unit) = (value / 1024.0, larger);
    }
    match unit {
        "B" => format!("{value:.0} B"),
        unit => format!("{} {unit}", digits(value)),
    }
}

/// A number of which not all digits matter: `0`, `0.25`, `99.8`, `1250`.
pub fn number(value: f64) -> String {
    if value == 0.0 || value >= 999.5 {
        return format!("{value:.0}");
    }
    digits(value)
}

fn digits(value: f64) -> String {
    let decimals = match value {
        ..9.995 => 2,
        9.995..99.95 => 1,
        _ => 0,
    };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_matter() {
        let shown = [
            0.0,
            999.0,
            1000.0,
            1024.0,
            8_257_536.0,
            99.96 * 1024.0,
            5e15,
        ]
        .map(bytes);
        assert_eq!(
            shown,
            [
                "0 B", "999 B", "0.98 KiB", "1.00 KiB", "7.88 MiB", "100 KiB", "4547 TiB"
            ]
        );
        let shown = [0.0, 0.25, 9.999, 99.84, 123.4, 1250.4].map(number);
        assert_eq!(shown, ["0", "0.25", "10.0", "99.8", "123", "1250"]);
    }
}
