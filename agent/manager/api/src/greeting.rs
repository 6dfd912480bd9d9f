//! The greeting of whoever connects, which tells the protocol versions that it speaks.

use serde::{Deserialize, Serialize};

use crate::{OLDEST_PROTOCOL_VERSION, PROTOCOL_VERSION};

/// First frame of whoever connects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "WireGreeting", into = "WireGreeting")]
pub enum Greeting {
    /// An agent or a tool that gives orders.
    Control {
        /// Sent: the newest protocol version that it speaks, besides all since [`OLDEST_PROTOCOL_VERSION`]. Received:
        /// the newest that both sides speak, or one that this side does not ([`speaks`](crate::speaks)).
        version: u32,
    },
    /// The out-port end of a connector.
    Data(Box<crate::data::DataHello>),
    /// Who looks at a port, or writes to one.
    Tap(crate::tap::TapHello),
}

/// A greeting as it travels. A manager of version 1 knows `version` alone, and serves its own one only, so that is the
/// oldest of the sender's.
#[derive(Clone, Serialize, Deserialize)]
#[serde(
    tag = "role",
    rename_all = "camelCase",
    rename_all_fields = "camelCase"
)]
enum WireGreeting {
    /// An agent or a tool that gives orders.
    Control {
        /// The oldest version that it speaks.
        version: u32,
        /// The newest, when that is another. Since version 2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        newest: Option<u32>,
    },
    /// The out-port end of a connector.
    Data(Box<crate::data::DataHello>),
    /// Who looks at a port, or writes to one.
    Tap(crate::tap::TapHello),
}

impl From<Greeting> for WireGreeting {
    fn from(greeting: Greeting) -> Self {
        match greeting {
            Greeting::Control { version } => Self::Control {
                version: version.min(OLDEST_PROTOCOL_VERSION),
                newest: (version > OLDEST_PROTOCOL_VERSION).then_some(version),
            },
            Greeting::Data(hello) => Self::Data(hello),
            Greeting::Tap(hello) => Self::Tap(hello),
        }
    }
}

impl From<WireGreeting> for Greeting {
    fn from(greeting: WireGreeting) -> Self {
        match greeting {
            WireGreeting::Control { version, newest } => Self::Control {
                version: newest.map_or(version, |newest| newest.min(PROTOCOL_VERSION).max(version)),
            },
            WireGreeting::Data(hello) => Self::Data(hello),
            WireGreeting::Tap(hello) => Self::Tap(hello),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> u32 {
        match serde_json::from_str(text).unwrap() {
            Greeting::Control { version } => version,
            other => panic!("it is a control greeting, not {other:?}"),
        }
    }

    #[test]
    fn a_greeting_tells_which_versions_its_sender_speaks() {
        let sent = |version| serde_json::to_string(&Greeting::Control { version }).unwrap();
        assert_eq!(sent(1), r#"{"role":"control","version":1}"#);
        assert_eq!(sent(2), r#"{"role":"control","version":1,"newest":2}"#);
        // Both sides speak the newest that the older one knows.
        assert_eq!(read(&sent(1)), 1);
        assert_eq!(read(&sent(2)), 2);
        assert_eq!(read(&sent(7)), PROTOCOL_VERSION);
        assert_eq!(read(r#"{"role":"control","version":2}"#), 2);
        // Nothing in common: what its sender speaks at least.
        assert_eq!(read(r#"{"role":"control","version":5,"newest":7}"#), 5);
        assert_eq!(read(r#"{"role":"control","version":0}"#), 0);
    }
}
