//! Lists of a descriptor: their items may be longer than ours, when the module was built with a later SDK.

#![allow(unsafe_code)]

use rts_runtime::abi::{self, ABI_VERSION};

use super::descriptor::DescriptorError;

/// Most ports, and most parameters, of a type.
pub(super) const MAX_ITEMS: usize = 1024;
/// No struct of this version will ever be longer.
const MAX_SIZE: usize = 4096;

/// A struct that begins with its version and its size.
///
/// # Safety
/// It is `repr(C)`, its first two fields are `u32`: version and size, and all others may have any bits.
pub(super) unsafe trait Sized32: Copy {}

// SAFETY: so they are defined; pointers in them are only used by `text`, which checks.
unsafe impl Sized32 for abi::Port {}
// SAFETY: as above.
unsafe impl Sized32 for abi::Parameter {}
// SAFETY: as above.
unsafe impl Sized32 for abi::Service {}

/// Copies the items of a list, as far as this version knows them.
///
/// # Safety
/// When `items` is not null, `length` items of the size that the first one claims can be read there.
pub(super) unsafe fn list<T: Sized32>(
    what: &'static str,
    items: *const T,
    length: usize,
) -> Result<Vec<T>, DescriptorError> {
    if length == 0 {
        return Ok(Vec::new());
    }
    if length > MAX_ITEMS || items.is_null() || !items.is_aligned() {
        return Err(DescriptorError::List(what, length));
    }
    let base = items.cast::<u8>();
    // SAFETY: not null, aligned, and there is at least one item.
    let stride = unsafe { head(what, base, size_of::<T>()) }?;
    if stride > MAX_SIZE || !stride.is_multiple_of(align_of::<T>()) {
        return Err(DescriptorError::ItemSize(what, stride));
    }
    let mut copies = Vec::with_capacity(length);
    for index in 0..length {
        // SAFETY: within the list, as the caller vouches for its length and the first item for their distance.
        unsafe {
            let item = base.add(index * stride);
            if head(what, item, size_of::<T>())? != stride {
                return Err(DescriptorError::ItemSize(what, stride));
            }
            copies.push(item.cast::<T>().read());
        }
    }
    Ok(copies)
}

/// Reads the size of an item, after its version.
unsafe fn head(
    what: &'static str,
    item: *const u8,
    least: usize,
) -> Result<usize, DescriptorError> {
    // SAFETY: the caller vouches for the item, and both come first.
    let (version, size) = unsafe {
        let words = item.cast::<u32>();
        (words.read_unaligned(), words.add(1).read_unaligned())
    };
    if version != ABI_VERSION {
        return Err(DescriptorError::Version(version));
    }
    let size = size as usize;
    if size < least {
        return Err(DescriptorError::ItemSize(what, size));
    }
    Ok(size)
}
