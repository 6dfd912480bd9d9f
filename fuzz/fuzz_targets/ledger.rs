//! Any bytes in the place of the two files of a ledger, and files of which a loss of power left a part.
#![no_main]

use libfuzzer_sys::fuzz_target;
use serde_json::Value;
use serde_json::value::RawValue;

#[path = "../../agent/src/ledger/text.rs"]
mod text;
#[path = "../counting.rs"]
mod counting;

use text::{BLOCK, Text};

fuzz_target!(|bytes: &[u8]| {
    if let Ok((number, read)) = counting::bounded(bytes, text::read::<Value>) {
        let again = text::written(number, &read, bytes.len()).expect("it is written");
        assert!(again.len() >= bytes.len());
        let (same, other) = text::read::<Value>(&again).expect("what is written is read");
        assert_eq!((number, &read.digest), (same, &other.digest));
    }
    // Two bytes say where it is cut; the rest is a spec, if it is one.
    let Some((cut, spec)) = bytes.split_at_checked(2) else {
        return;
    };
    let Ok(spec) = serde_json::from_slice::<Box<RawValue>>(spec) else {
        return;
    };
    let (old, new) = (file(1, spec.clone(), 0), file(2, spec, 0));
    let cut = usize::from(u16::from_le_bytes([cut[0], cut[1]])) % new.len();
    assert_eq!((old.len() % BLOCK, old.len()), (0, new.len()));
    let torn = [&new[..cut], &old[cut..]].concat();
    // Whichever it is, it is one of the two, whole.
    if let Ok((number, read)) = text::read::<Value>(&torn) {
        assert!(number == read.generation && (number == 1 || number == 2), "{number}");
    }
});

fn file(number: u64, spec: Box<RawValue>, least: usize) -> Vec<u8> {
    let envelope = Text::<Value> {
        cluster_uid: "a".to_owned(),
        epoch: 1,
        generation: number,
        digest: text::digest(&spec),
        take_over: None,
        spec,
    };
    text::written(number, &envelope, least).expect("it is written")
}
