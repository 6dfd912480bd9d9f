//! Typed data ports.

use std::marker::PhantomData;

use crate::types::DataType;
use crate::{Context, Loan, PortStatus, RtcResult};

/// An in-port. Made by [`Declaration::in_port`](crate::Declaration::in_port).
#[derive(Debug)]
pub struct InPort<T> {
    index: u32,
    name: &'static str,
    kind: PhantomData<fn() -> T>,
}

impl<T: DataType> InPort<T> {
    pub(crate) fn new(index: u32, name: &'static str) -> Self {
        Self {
            index,
            name,
            kind: PhantomData,
        }
    }

    /// Takes the oldest sample; `None` when there is none. Waits only where a connector says so, and once a callback.
    ///
    /// A callback sees what had arrived when it began, and the queues are bounded, so
    /// `while let Some(s) = port.read(ctx)?` ends, however fast the producers are.
    pub fn read(&mut self, ctx: &mut Context<'_>) -> RtcResult<Option<T>> {
        ctx.read(self.index, T::TYPE_ID, T::decode)
            .map_err(|error| error.context(format_args!("in-port `{}`", self.name)))
    }

    /// Whether `read` would give a sample.
    pub fn is_new(&self, ctx: &Context<'_>) -> bool {
        ctx.is_new(self.index)
    }

    /// Takes all samples and keeps the newest.
    pub fn read_newest(&mut self, ctx: &mut Context<'_>) -> RtcResult<Option<T>> {
        let mut newest = None;
        while let Some(sample) = self.read(ctx)? {
            newest = Some(sample);
        }
        Ok(newest)
    }
}

/// An out-port. Made by [`Declaration::out_port`](crate::Declaration::out_port).
#[derive(Debug)]
pub struct OutPort<T> {
    index: u32,
    name: &'static str,
    buffer: Vec<u8>,
    kind: PhantomData<fn(T)>,
}

impl<T: DataType> OutPort<T> {
    pub(crate) fn new(index: u32, name: &'static str) -> Self {
        Self {
            index,
            name,
            buffer: Vec::new(),
            kind: PhantomData,
        }
    }

    /// Sends a sample to every connector of the port; without a connector it is dropped. What a connector could not take
    /// is a status, not an error.
    pub fn write(&mut self, ctx: &mut Context<'_>, sample: &T) -> RtcResult<PortStatus> {
        sample.encode(&mut self.buffer)?;
        ctx.write(self.index, T::TYPE_ID, &self.buffer)
            .map_err(|error| error.context(format_args!("out-port `{}`", self.name)))
    }

    /// Borrows memory of the manager for a sample of at most `len` bytes, which is encoded in place and sent without a
    /// copy. For large samples whose bytes come from elsewhere.
    pub fn loan<'c>(&mut self, ctx: &'c mut Context<'_>, len: usize) -> RtcResult<Loan<'c>> {
        ctx.loan(self.index, len)
            .map_err(|error| error.context(format_args!("out-port `{}`", self.name)))
    }
}
