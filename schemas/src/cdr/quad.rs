//! IEEE 754 binary128, which Rust has no stable type for: only what has the same value as a binary64.

const MANTISSA: u128 = (1 << 112) - 1;

/// The same number with 113 instead of 53 bits. Always exact; a NaN keeps its bits in front.
pub(super) fn widen(number: f64) -> u128 {
    let bits = u128::from(number.to_bits());
    let sign = bits >> 63 << 127;
    let exponent = bits >> 52 & 0x7ff;
    let mantissa = bits & ((1 << 52) - 1);
    match exponent {
        0x7ff => sign | 0x7fff << 112 | mantissa << 60,
        0 if mantissa == 0 => sign,
        // Below the normal numbers of binary64, not of binary128: the first bit that is set becomes the hidden one.
        0 => {
            let first = 127 - mantissa.leading_zeros();
            let exponent = u128::from(first + 16383 - 1074);
            sign | exponent << 112 | mantissa << (112 - first) & MANTISSA
        }
        _ => sign | (exponent + 16383 - 1023) << 112 | mantissa << 60,
    }
}

/// The binary64 of the same value, where there is one.
pub(super) fn narrow(bits: u128) -> Option<f64> {
    let sign = (bits >> 127) as u64;
    let exponent = (bits >> 112 & 0x7fff) as i32 - 16383;
    let mantissa = (bits >> 60 & ((1 << 52) - 1)) as u64;
    let magnitude = match exponent {
        16384 => 0x7ff << 52 | mantissa,
        -1022..=1023 => ((exponent + 1023) as u64) << 52 | mantissa,
        -1074..=-1023 => (1 << 52 | mantissa) >> (-1022 - exponent),
        _ => 0,
    };
    let number = f64::from_bits(sign << 63 | magnitude);
    (widen(number) == bits).then_some(number)
}

/// Whether it is no number.
pub(super) fn is_nan(bits: u128) -> bool {
    bits >> 112 & 0x7fff == 0x7fff && bits & MANTISSA != 0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn known_numbers() {
        assert_eq!(widen(0.0), 0);
        assert_eq!(widen(-0.0), 1 << 127);
        assert_eq!(widen(1.0), 0x3fff << 112);
        assert_eq!(widen(-1.5), 0xbfff_8000 << 96);
        assert_eq!(widen(f64::INFINITY), 0x7fff << 112);
        // The least of all binary64: 2^-1074.
        assert_eq!(widen(f64::from_bits(1)), (16383 - 1074) << 112);
        assert!(is_nan(widen(f64::NAN)) && !is_nan(widen(f64::INFINITY)));
        // 1 + 2^-112 and 2^1024 have no binary64.
        assert_eq!(narrow((0x3fff << 112) + 1), None);
        assert_eq!(narrow((16383 + 1024) << 112), None);
    }

    proptest! {
        #[test]
        fn what_is_widened_is_narrowed_to_the_same(bits: u64) {
            let back = narrow(widen(f64::from_bits(bits)));
            prop_assert_eq!(back.map(f64::to_bits), Some(bits));
        }

        #[test]
        fn only_equal_numbers_are_narrowed(bits: u128) {
            if let Some(number) = narrow(bits) {
                prop_assert_eq!(widen(number), bits);
            }
        }
    }
}
