//! Memory that is lent to a component, which writes a sample into it.

#![allow(unsafe_code)]

use std::collections::BTreeMap;

use crate::data::Payload;

/// Loans of one component that may be out at once.
const MAX_LOANS: usize = 64;

/// What is out.
#[derive(Debug, Default)]
pub(super) struct Loans {
    last: u64,
    out: BTreeMap<u64, (u32, Words)>,
}

/// Bytes that begin at a multiple of 8.
#[derive(Debug)]
struct Words(Vec<u64>);

impl AsRef<[u8]> for Words {
    fn as_ref(&self) -> &[u8] {
        let len = size_of_val(self.0.as_slice());
        // SAFETY: words have no padding, and bytes may have any value.
        unsafe { std::slice::from_raw_parts(self.0.as_ptr().cast(), len) }
    }
}

impl Loans {
    /// Lends `len` bytes for a port: their token and address. None when too many are out.
    pub(super) fn lend(&mut self, port: u32, len: usize) -> Option<(u64, *mut u8)> {
        if self.out.len() >= MAX_LOANS {
            return None;
        }
        self.last += 1;
        let mut words = Words(vec![0; len.div_ceil(8)]);
        // The words stay where they are when their owner moves.
        let data = words.0.as_mut_ptr().cast();
        self.out.insert(self.last, (port, words));
        Some((self.last, data))
    }

    /// Takes the first `len` bytes of a loan back, with its port. None when there is no such loan, or it is shorter.
    pub(super) fn take(&mut self, token: u64, len: usize) -> Option<(u32, Payload)> {
        let (port, words) = self.out.remove(&token)?;
        let sample = Payload::from_owner(words);
        (len <= sample.len()).then(|| (port, sample.slice(..len)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_given_back_once_without_a_copy() {
        let mut loans = Loans::default();
        let (token, data) = loans.lend(3, 5).unwrap();
        // SAFETY: five bytes were lent.
        unsafe { data.copy_from(b"hello".as_ptr(), 5) };
        let (other, _) = loans.lend(4, 0).unwrap();
        let (port, sample) = loans.take(token, 4).unwrap();
        assert_eq!((port, &sample[..]), (3, &b"hell"[..]));
        assert_eq!(sample.as_ptr(), data.cast_const());
        assert!(loans.take(token, 4).is_none());
        assert!(loans.take(other, 9).is_none(), "it is shorter");
    }

    #[test]
    fn loans_are_zero_aligned_and_bounded() {
        let mut loans = Loans::default();
        let (token, data) = loans.lend(0, 9).unwrap();
        assert_eq!(data.addr() % 8, 0);
        assert_eq!(&loans.take(token, 9).unwrap().1[..], [0; 9]);
        for _ in 0..MAX_LOANS {
            loans.lend(0, 1).unwrap();
        }
        assert!(loans.lend(0, 1).is_none());
    }
}
