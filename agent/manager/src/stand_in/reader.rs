//! What came to an in-port of a stand-in: counted, and looked at as far as its type is known.

use std::collections::BTreeMap;
use std::fmt;

use super::marked::Marked;
use super::typed;

/// Senders whose numbers are followed.
const MAX_SENDERS: usize = 64;

/// Counts of one in-port.
#[derive(Debug, Default)]
pub struct Reader {
    samples: u64,
    gaps: u64,
    out_of_order: u64,
    faulty: u64,
    /// Sender → the number that it sends next.
    next: BTreeMap<String, u64>,
}

impl Reader {
    /// Counts a sample. The first one that is no value of the port's type is told.
    pub fn take(&mut self, data_type: &str, bytes: &[u8]) -> Result<(), String> {
        self.samples += 1;
        if typed::is_value(data_type, bytes) == Some(false) {
            self.faulty += 1;
            if self.faulty == 1 {
                return Err(format!("got bytes that are no {data_type}"));
            }
        } else if let Some(marked) = Marked::decode_from(bytes) {
            self.follow(marked);
        }
        Ok(())
    }

    fn follow(&mut self, marked: Marked) {
        let after = marked.sequence.saturating_add(1);
        if let Some(next) = self.next.get_mut(&marked.sender) {
            match marked.sequence.cmp(next) {
                std::cmp::Ordering::Less => self.out_of_order += 1,
                std::cmp::Ordering::Equal => {}
                std::cmp::Ordering::Greater => self.gaps += 1,
            }
            *next = after.max(*next);
            return;
        }
        if self.next.len() >= MAX_SENDERS {
            // Most likely senders that are long gone.
            self.next.clear();
        }
        self.next.insert(marked.sender, after);
    }
}

impl fmt::Display for Reader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} samples, {} gaps, {} out of order, {} faulty",
            self.samples, self.gaps, self.out_of_order, self.faulty
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: &str = "IDL:Img/TimedCameraImage:1.0";

    fn marked(sender: &str, sequence: u64) -> Vec<u8> {
        let mut buffer = Vec::new();
        Marked::encode_into(IMAGE, sender.to_owned(), sequence, &mut buffer);
        buffer
    }

    #[test]
    fn each_sender_has_its_own_numbers() {
        let mut reader = Reader::default();
        for (sender, number) in [("a", 5), ("b", 1), ("a", 6), ("b", 4), ("a", 6), ("a", 7)] {
            reader.take(IMAGE, &marked(sender, number)).unwrap();
        }
        assert_eq!(
            reader.to_string(),
            "6 samples, 1 gaps, 1 out of order, 0 faulty"
        );
    }

    #[test]
    fn senders_are_followed_within_a_bound() {
        let mut reader = Reader::default();
        for sender in 0..1000 {
            reader.take(IMAGE, &marked(&sender.to_string(), 1)).unwrap();
        }
        assert!(reader.next.len() <= MAX_SENDERS);
    }

    #[test]
    fn what_is_no_value_is_told_once_and_counted() {
        let mut reader = Reader::default();
        let double = "IDL:RTC/TimedDouble:1.0";
        assert!(
            reader
                .take(double, b"x")
                .unwrap_err()
                .contains("TimedDouble")
        );
        reader.take(double, b"x").unwrap();
        assert_eq!(
            reader.to_string(),
            "2 samples, 0 gaps, 0 out of order, 2 faulty"
        );
    }
}
