//! What a machine that is reached by SSH answers: it may say anything.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rts_ssh::{Collected, Survey};
use rts_ssh::bootstrap::Found;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(survey) = Survey::parse(bytes) {
        let home = survey.rtsctl_home();
        assert!(home.starts_with('/') && home.ends_with("/rtsctl"), "{home:?}");
        assert!(!home.contains("/../") && !home.chars().any(char::is_control), "{home:?}");
        assert!(!survey.node.chars().any(char::is_control));
    }
    if let Ok(found) = Found::parse(bytes) {
        let records = found.record.iter().flat_map(|record| record.digests());
        for digest in records {
            assert!(digest.len() == 64 && digest.bytes().all(|b| b.is_ascii_hexdigit()), "{digest:?}");
        }
        assert!(found.managers.iter().all(|pid| *pid > 1));
    }
    if let Some(collected) = Collected::parse(bytes) {
        assert!(collected.told.len() <= 4 && !collected.told.concat().chars().any(char::is_control));
    }
});
