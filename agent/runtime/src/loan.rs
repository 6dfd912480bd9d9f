//! Memory of the manager for a sample that is written in place.

#![allow(unsafe_code)]

use std::ops::{Deref, DerefMut};

use crate::RtcResult;
use crate::abi::{self, Host};
use crate::port_status::PortStatus;

/// Memory of the manager that a sample is encoded into, so that it is not copied. Made by
/// [`OutPort::loan`](crate::OutPort::loan); dropped unused, it is given back.
#[derive(Debug)]
pub struct Loan<'h> {
    host: &'h Host,
    loan: abi::Loan,
}

impl<'h> Loan<'h> {
    pub(crate) fn new(host: &'h Host, loan: abi::Loan) -> Self {
        Self { host, loan }
    }

    /// Sends its first `len` bytes, which must be a sample of the port's type in little endian CDR.
    ///
    /// # Panics
    /// When there are fewer.
    pub fn publish(self, len: usize) -> RtcResult<PortStatus> {
        assert!(len <= self.len(), "{len} bytes of a loan of {}", self.len());
        // The memory is the host's from now on.
        let this = std::mem::ManuallyDrop::new(self);
        // SAFETY: the token came from this host and is given back once.
        let code = unsafe { (this.host.publish)(this.host.context, this.loan.token, len) };
        PortStatus::of("publish", code)
    }
}

impl Deref for Loan<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        if self.loan.len == 0 {
            return &[];
        }
        // SAFETY: the host lends this memory, with all its bytes set, until the token is given back.
        unsafe { std::slice::from_raw_parts(self.loan.data, self.loan.len) }
    }
}

impl DerefMut for Loan<'_> {
    fn deref_mut(&mut self) -> &mut [u8] {
        if self.loan.len == 0 {
            return &mut [];
        }
        // SAFETY: as above, and it is lent to this value alone.
        unsafe { std::slice::from_raw_parts_mut(self.loan.data, self.loan.len) }
    }
}

impl Drop for Loan<'_> {
    fn drop(&mut self) {
        // SAFETY: the token came from this host and is given back once.
        unsafe { (self.host.discard)(self.host.context, self.loan.token) }
    }
}
