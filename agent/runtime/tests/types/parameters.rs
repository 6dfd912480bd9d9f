//! A value that `rtsctl check` and managers let pass is one that the SDK reads, and the other way round.

use proptest::prelude::*;
use rts_runtime::ParameterValue;
use rts_schemas::check::Limits;

fn agrees<T: ParameterValue>(text: &str) {
    let kind = T::type_name();
    let limits = Limits::read(&kind, "").expect("no constraint");
    if text.trim().is_empty() && limits.needs_text() {
        // It stands for the default, and never comes here.
        return;
    }
    let passes = limits.problem(text).is_none();
    assert_eq!(passes, T::parse(text).is_some(), "{kind} {text:?}");
}

fn by_all(text: &str) {
    macro_rules! each {
        ($($kind:ty)*) => {$( agrees::<$kind>(text); agrees::<Vec<$kind>>(text); )*};
    }
    each!(u8 u16 u32 u64 i16 i32 i64 f32 f64 bool String);
}

#[test]
fn texts_of_people() {
    for text in [
        "",
        " ",
        "0x7f",
        "0X7F",
        "0x",
        "0x-1",
        "+5",
        "--5",
        "1,,2",
        "1,",
        "7f",
        "1e3",
        ".5",
        "NaN",
        "inf",
        "TRUE",
        "on",
        "256",
        "-1",
        "65536",
        "4294967296",
        "18446744073709551615",
        "18446744073709551616",
        "1.0, 2.0",
        "0x10,2",
    ] {
        by_all(text);
    }
}

proptest! {
    #[test]
    fn texts_that_look_like_values(text in "[ +-]{0,2}(0[xX])?[0-9a-f.,]{0,12}") {
        by_all(&text);
    }

    #[test]
    fn any_text(text in ".{0,12}") {
        by_all(&text);
    }
}
