//! Lists of a descriptor: their items may be shorter or longer than ours, when the module was built with another SDK.

#![allow(unsafe_code)]

use rts_runtime::sized::{self, Misfit, Sized32};

use super::descriptor::DescriptorError;

/// Most ports, and most parameters, of a type.
pub(super) const MAX_ITEMS: usize = 1024;
/// Copies the items of a list, as far as this version knows them.
///
/// # Safety
/// When `items` is not null, `length` items of the size that the first one claims can be read there, and each `T` may have
/// any bits behind its version and size.
pub(super) unsafe fn list<T: Sized32>(
    what: &'static str,
    items: *const T,
    length: usize,
) -> Result<Vec<T>, DescriptorError> {
    if length == 0 {
        return Ok(Vec::new());
    }
    if length > MAX_ITEMS {
        return Err(DescriptorError::List(what, length));
    }
    let misfit = |misfit| match misfit {
        Misfit::Version(version) => DescriptorError::Version(version),
        Misfit::Size(size) => DescriptorError::ItemSize(what, size),
        Misfit::Null | Misfit::Unaligned(_) => DescriptorError::List(what, length),
    };
    let base = items.cast::<u8>();
    // SAFETY: there is at least one item.
    let stride = unsafe { sized::size(items) }.map_err(misfit)?;
    if !stride.is_multiple_of(align_of::<T>()) {
        return Err(DescriptorError::ItemSize(what, stride));
    }
    let mut copies = Vec::with_capacity(length);
    for index in 0..length {
        // SAFETY: within the list, as the caller vouches for its length and the first item for their distance.
        unsafe {
            let item = base.add(index * stride).cast::<T>();
            match sized::size(item).map_err(misfit)? {
                size if size == stride => copies.push(sized::read(item).map_err(misfit)?),
                size => return Err(DescriptorError::ItemSize(what, size)),
            }
        }
    }
    Ok(copies)
}
