//! Memory that is taken and never given back, as far as a limit of the whole process.

use std::sync::atomic::{AtomicU32, Ordering};

use rts_runtime::Context;

const MIB: usize = 1 << 20;

/// MiB that this process has lost. A component that is made again in it goes on from there.
static LOST: AtomicU32 = AtomicU32::new(0);

/// Loses one more MiB, unless `limit` MiB are lost already.
pub fn grow(limit: u32, ctx: &Context<'_>) {
    let one_more = |lost: u32| (lost < limit).then_some(lost + 1);
    let Ok(before) = LOST.fetch_update(Ordering::Relaxed, Ordering::Relaxed, one_more) else {
        return;
    };
    // Not zero: what is never written to takes no memory.
    Box::leak(vec![1_u8; MIB].into_boxed_slice());
    if before + 1 == limit {
        ctx.warn(format_args!("{limit} MiB have leaked: this is the limit"));
    }
}
