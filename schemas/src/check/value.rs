//! Whether a text is a value of a data type, as components read it.

use super::constraint::items;

/// `None` when the type is not known here, or the text is empty: then the component keeps its default.
pub(super) fn fits_type(data_type: &str, value: &str) -> Option<bool> {
    let value = value.trim();
    if value.is_empty() {
        return None;
    }
    let plain = plain(data_type);
    if let Some(inner) = plain
        .strip_prefix("vector<")
        .and_then(|rest| rest.strip_suffix('>'))
    {
        let mut all = true;
        for item in items(value) {
            all &= scalar(inner, item)?;
        }
        return Some(all);
    }
    scalar(&plain, value)
}

/// Without blanks around, namespaces, and capital letters.
fn plain(data_type: &str) -> String {
    let lower = data_type.to_lowercase();
    let words: Vec<&str> = lower.split_whitespace().collect();
    let joined = words.join(" ");
    joined.replace("std::", "").replace("coil::", "")
}

fn scalar(data_type: &str, value: &str) -> Option<bool> {
    let whole = |low: i128, high: i128| {
        let parsed = integer(value);
        Some(parsed.is_some_and(|n| (low..=high).contains(&n)))
    };
    match data_type.trim() {
        "int8_t" => whole(i8::MIN.into(), i8::MAX.into()),
        "uint8_t" | "unsigned char" => whole(0, u8::MAX.into()),
        "short" | "short int" | "int16_t" => whole(i16::MIN.into(), i16::MAX.into()),
        "int" | "integer" | "int32_t" => whole(i32::MIN.into(), i32::MAX.into()),
        "long" | "long int" | "long long" | "int64_t" => whole(i64::MIN.into(), i64::MAX.into()),
        "unsigned short" | "unsigned short int" | "uint16_t" => whole(0, u16::MAX.into()),
        "unsigned" | "unsigned int" | "uint32_t" => whole(0, u32::MAX.into()),
        "unsigned long" | "unsigned long int" | "unsigned long long" | "uint64_t" | "size_t" => {
            whole(0, u64::MAX.into())
        }
        "float" | "double" | "long double" => Some(value.parse::<f64>().is_ok()),
        "bool" | "boolean" => {
            let words = ["true", "false", "1", "0", "yes", "no", "on", "off"];
            Some(words.iter().any(|word| word.eq_ignore_ascii_case(value)))
        }
        "string" => Some(true),
        _ => None,
    }
}

/// True when an empty text is no value of a type, so that it stands for the component's default, as in OpenRTM-aist.
pub(super) fn needs_text(data_type: &str) -> bool {
    scalar(&plain(data_type), "") == Some(false)
}

/// Decimal, or hexadecimal after `0x`, as the SDK reads it.
pub(super) fn integer(value: &str) -> Option<i128> {
    let (sign, digits) = match value.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, value.strip_prefix('+').unwrap_or(value)),
    };
    let hex = digits.strip_prefix("0x").or(digits.strip_prefix("0X"));
    let (digits, radix) = hex.map_or((digits, 10), |hex| (hex, 16));
    // A second sign is none.
    let begins = digits.starts_with(|c: char| c.is_digit(radix));
    let number = begins.then(|| i128::from_str_radix(digits, radix).ok())??;
    Some(sign * number)
}

#[cfg(test)]
mod tests {
    use super::{fits_type, needs_text};

    #[test]
    fn types_that_have_no_empty_text() {
        for kind in ["int", "double", "bool", "unsigned long"] {
            assert!(needs_text(kind), "{kind}");
        }
        for kind in ["string", "std::vector<double>", "", "Mine::Own"] {
            assert!(!needs_text(kind), "{kind}");
        }
    }

    #[test]
    fn values_of_types() {
        let right = [
            ("int", "-5"),
            ("unsigned int ", "80"),
            ("short", "0x7f"),
            ("uint8_t", "0xFF"),
            ("double", "1e-3"),
            ("String", "Val01"),
            ("std::string", "anything"),
            ("std::vector<double>", "1.0,0.0"),
            ("bool", "TRUE"),
        ];
        for (kind, value) in right {
            assert_eq!(fits_type(kind, value), Some(true), "{kind} {value}");
        }
        let wrong = [
            ("int", "Val02"),
            ("int", "1.5"),
            ("int", "0x-5"),
            ("uint8_t", "256"),
            ("int", "3000000000"),
            ("unsigned int", "-1"),
            ("short", "40000"),
            ("float", "fast"),
            ("bool", "perhaps"),
            ("std::vector<int>", "1,x"),
        ];
        for (kind, value) in wrong {
            assert_eq!(fits_type(kind, value), Some(false), "{kind} {value}");
        }
        for (kind, value) in [("int", ""), ("Mine::Own", "x"), ("text", "x"), ("", "x")] {
            assert_eq!(fits_type(kind, value), None, "{kind} {value}");
        }
    }
}
