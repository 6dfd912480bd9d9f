//! Versions of the protocol, and which side is to be upgraded when two do not meet.

/// Version of the protocol.
pub const PROTOCOL_VERSION: u32 = 2;
/// The oldest version that is still spoken.
pub const OLDEST_PROTOCOL_VERSION: u32 = 1;

/// The other side speaks no version of ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the other side speaks version {theirs} of the manager protocol, this side {OLDEST_PROTOCOL_VERSION} to \
     {PROTOCOL_VERSION}: upgrade {side}", side = self.side()
)]
pub struct VersionMismatch {
    /// What the other side speaks.
    pub theirs: u32,
}

impl VersionMismatch {
    fn side(self) -> &'static str {
        if self.theirs > PROTOCOL_VERSION {
            "this side"
        } else {
            "the other side"
        }
    }
}

/// Whether this side speaks a version; if not, the error names the side to upgrade.
pub fn speaks(version: u32) -> Result<(), VersionMismatch> {
    if (OLDEST_PROTOCOL_VERSION..=PROTOCOL_VERSION).contains(&version) {
        Ok(())
    } else {
        Err(VersionMismatch { theirs: version })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_meet_names_the_side_to_upgrade() {
        assert_eq!(speaks(1), Ok(()));
        assert_eq!(speaks(2), Ok(()));
        assert_eq!(
            speaks(0).unwrap_err().to_string(),
            "the other side speaks version 0 of the manager protocol, this side 1 to 2: upgrade the other side"
        );
        assert_eq!(
            speaks(3).unwrap_err().to_string(),
            "the other side speaks version 3 of the manager protocol, this side 1 to 2: upgrade this side"
        );
    }
}
