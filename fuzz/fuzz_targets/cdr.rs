//! Any bytes as a value of any type: first the choices that make the type, then a byte for the order, then the value.
#![no_main]

#[path = "../counting.rs"]
mod counting;
#[path = "../../schemas/src/cdr/tests/any.rs"]
#[allow(dead_code)] // The values are drawn by others.
mod any;

use any::Choices;
use libfuzzer_sys::fuzz_target;
use rts_schemas::cdr::{self, Endian, Value};
use rts_schemas::idl::model::*;
use rts_schemas::span::Span;

/// Bytes that choose the type.
const CHOICES: usize = 24;

/// Definitions within each other; each is a value of its own.
const DEPTH: u32 = 3;

fuzz_target!(|bytes: &[u8]| {
    let Some((choices, [order, bytes @ ..])) = bytes.split_at_checked(CHOICES) else {
        return;
    };
    let mut unit = Unit::default();
    let r#type = Choices { bytes: choices, plain: false }.r#type(&mut unit, DEPTH);
    let endian = [Endian::Little, Endian::Big][usize::from(*order % 2)];
    let read = counting::bounded(bytes, |bytes| cdr::decode(&unit, &r#type, bytes, endian));
    let mut turned = bytes.to_vec();
    let turning = cdr::swap(&unit, &r#type, &mut turned, endian);
    let Ok(value) = read else {
        return;
    };
    turning.expect("what was read can be turned");
    let other = [Endian::Big, Endian::Little][usize::from(*order % 2)];
    cdr::swap(&unit, &r#type, &mut turned, other).expect("what was turned can be turned back");
    assert_eq!(turned, bytes);
    let encode = |value: &Value| cdr::encode(&unit, &r#type, value, endian).expect("what was read can be written");
    let written = encode(&value);
    let back = cdr::decode(&unit, &r#type, &written, endian).expect("its own bytes are read");
    // By their bytes: a NaN is not equal to itself.
    assert_eq!(encode(&back), written);
    let text = cdr::to_json(&unit, &r#type, &value).expect("what was read can be shown");
    let json = serde_json::from_str(&text).expect("what is shown is JSON");
    let back = cdr::from_json(&unit, &r#type, &json).expect("what is shown is read");
    assert_eq!(cdr::to_json(&unit, &r#type, &back).expect("what was read can be shown"), text);
});
