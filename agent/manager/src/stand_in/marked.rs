//! Samples of types that this program cannot encode: CDR of a struct of their own, which says whose they are.

use rts_runtime::types::{DataType, Time};
use serde::{Deserialize, Serialize};

/// First field of each such sample.
const MARK: &str = "rtsctl stand-in";

/// `struct { string mark; string data_type; string sender; unsigned long long sequence; RTC::Time tm; }`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Marked {
    mark: String,
    /// The type that the port has.
    pub data_type: String,
    /// Port and creation of the stand-in that sent it.
    pub sender: String,
    /// Its number.
    pub sequence: u64,
    tm: Time,
}

impl DataType for Marked {
    const TYPE_ID: &'static str = "IDL:rtsctl/StandIn:1.0";
}

impl Marked {
    /// Encodes one with the time now.
    pub fn encode_into(data_type: &str, sender: String, sequence: u64, buffer: &mut Vec<u8>) {
        let marked = Self {
            mark: MARK.to_owned(),
            data_type: data_type.to_owned(),
            sender,
            sequence,
            tm: Time::now(),
        };
        // Texts and numbers always have a place in CDR; what fails would be an empty sample, which the reader counts.
        let _ = marked.encode(buffer);
    }

    /// None for a sample of somebody else.
    pub fn decode_from(bytes: &[u8]) -> Option<Self> {
        Self::decode(bytes)
            .ok()
            .filter(|marked| marked.mark == MARK)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_sent_is_read_and_nothing_else_is_taken_for_it() {
        let mut buffer = Vec::new();
        Marked::encode_into("IDL:Img/X:1.0", "A.out#1".to_owned(), 7, &mut buffer);
        let read = Marked::decode_from(&buffer).unwrap();
        assert_eq!((read.sequence, read.sender.as_str()), (7, "A.out#1"));
        assert_eq!(Marked::decode_from(b"no sample"), None);
        buffer[4] = b'x';
        assert_eq!(Marked::decode_from(&buffer), None);
    }
}
