//! Structs of the ABI as the other side has them: it may know fewer of their fields than this side, or more.
//!
//! Both sides of a call come here, so what is appended within a version shortens no struct that was long enough before.

#![allow(unsafe_code)]

use std::mem::{MaybeUninit, offset_of};
use std::ptr;

use crate::abi::{ABI_VERSION, Buffer, Host, Loan, Module, Parameter, Port, Service};

/// No struct of this version will ever be longer.
pub const MAX_SIZE: usize = 4096;

/// A struct of the ABI that begins with its version and its size, and that fields may be appended to.
///
/// # Safety
/// It is `repr(C)`, its first two fields are `u32`: version and size, and every field behind `V1_SIZE` may be all zeros,
/// which means that its sender does not know it: a function there is an `Option`.
pub unsafe trait Sized32 {
    /// Size when version 1 was fixed. It never changes: who has no more than that has all that it must have.
    const V1_SIZE: usize;
}

/// `V1_SIZE` ends with the last field that the struct had when version 1 was fixed. Nobody edits these lines to append.
macro_rules! fixed {
    ($($type:ident ends with $field:ident: $kind:ty, at $size:literal;)*) => {$(
        // SAFETY: so they are defined.
        unsafe impl Sized32 for $type {
            const V1_SIZE: usize =
                (offset_of!($type, $field) + size_of::<$kind>()).next_multiple_of(align_of::<$type>());
        }

        #[cfg(target_pointer_width = "64")]
        const _: () = assert!(<$type as Sized32>::V1_SIZE == $size);
        const _: () = assert!(size_of::<$type>() <= MAX_SIZE);
    )*};
}

fixed! {
    Buffer ends with len: usize, at 48;
    Loan ends with len: usize, at 32;
    Port ends with reserved: u32, at 48;
    Service ends with reserved: u32, at 64;
    Parameter ends with description: crate::abi::Text, at 104;
    Module ends with configure: usize, at 208;
    Host ends with discard: usize, at 104;
}

/// Why a struct of the other side cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Misfit {
    /// It is not there.
    Null,
    /// It is where no struct can be.
    Unaligned(usize),
    /// It is of another version.
    Version(u32),
    /// It lacks what this version always had, or claims more than any struct has.
    Size(usize),
}

/// The size that a struct claims, when it can be used.
///
/// # Safety
/// It is null or begins with its version and its size.
pub unsafe fn size<T: Sized32>(it: *const T) -> Result<usize, Misfit> {
    if it.is_null() {
        return Err(Misfit::Null);
    }
    if !it.is_aligned() {
        return Err(Misfit::Unaligned(it.addr()));
    }
    // SAFETY: not null and aligned, and both come first.
    let (version, size) = unsafe {
        let words = it.cast::<u32>();
        (words.read(), words.add(1).read() as usize)
    };
    match size {
        _ if version != ABI_VERSION => Err(Misfit::Version(version)),
        size if (T::V1_SIZE..=MAX_SIZE).contains(&size) => Ok(size),
        size => Err(Misfit::Size(size)),
    }
}

/// Copies a struct, as far as both sides know it; the rest is zero.
///
/// # Safety
/// It is null, or begins with its version and its size and is as long as that says; what is in it up to `V1_SIZE` is valid.
pub unsafe fn read<T: Sized32>(it: *const T) -> Result<T, Misfit> {
    // SAFETY: the caller vouches for the beginning.
    let size = unsafe { size(it) }?;
    let mut copy = MaybeUninit::<T>::zeroed();
    // SAFETY: no more than either has; what is not copied may be zero.
    unsafe {
        let known = size.min(size_of::<T>());
        ptr::copy_nonoverlapping(it.cast::<u8>(), copy.as_mut_ptr().cast(), known);
        Ok(copy.assume_init())
    }
}

/// Fills a struct, as far as both sides know it; the rest is zeroed. Its version and its size stay as they are.
///
/// # Safety
/// It is null, or begins with its version and its size and may be written as far as that says.
pub unsafe fn fill<T: Sized32>(place: *mut T, value: &T) -> Result<(), Misfit> {
    const HEAD: usize = 2 * size_of::<u32>();
    // SAFETY: the caller vouches for the beginning.
    let size = unsafe { size(place.cast_const()) }?;
    let known = size.min(size_of::<T>());
    // SAFETY: no more than either has, and then as far as the place goes.
    unsafe {
        let (from, to) = (ptr::from_ref(value).cast::<u8>(), place.cast::<u8>());
        ptr::copy_nonoverlapping(from.add(HEAD), to.add(HEAD), known - HEAD);
        ptr::write_bytes(to.add(known), 0, size - known);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::lend;

    /// A port of a later SDK or manager, which has appended a field.
    #[repr(C)]
    #[derive(Debug, Clone, Copy)]
    struct Longer {
        port: Port,
        appended: u64,
    }

    // SAFETY: the appended field may be zero.
    unsafe impl Sized32 for Longer {
        const V1_SIZE: usize = Port::V1_SIZE;
    }

    fn port(size: usize) -> Port {
        Port {
            abi_version: ABI_VERSION,
            size: size as u32,
            name: lend("in"),
            type_id: lend("IDL:A:1.0"),
            direction: 1,
            reserved: 0,
        }
    }

    fn longer(size: usize, appended: u64) -> Longer {
        Longer {
            port: port(size),
            appended,
        }
    }

    #[test]
    fn what_the_other_side_does_not_know_is_zero() {
        let older = longer(Port::V1_SIZE, u64::MAX);
        let newer = longer(size_of::<Longer>(), 7);
        // SAFETY: each is as long as it says.
        unsafe {
            let copy = read::<Longer>(&raw const older).unwrap();
            assert_eq!((copy.port.direction, copy.appended), (1, 0));
            assert_eq!(read::<Longer>(&raw const newer).unwrap().appended, 7);
            let copy = read::<Port>((&raw const newer).cast()).unwrap();
            assert_eq!(copy.name.len, 2);
        }
    }

    #[test]
    fn a_place_is_filled_as_far_as_it_goes() {
        let mut older = longer(Port::V1_SIZE, u64::MAX);
        let mut newer = longer(size_of::<Longer>(), u64::MAX);
        let mut ours = longer(size_of::<Longer>(), u64::MAX);
        (older.port.direction, newer.port.direction) = (9, 9);
        // SAFETY: each may be written as far as it says.
        unsafe {
            fill::<Longer>(&raw mut older, &longer(0, 5)).unwrap();
            fill::<Port>((&raw mut newer).cast(), &port(0)).unwrap();
            fill::<Longer>(&raw mut ours, &longer(0, 5)).unwrap();
        }
        assert_eq!(older.appended, u64::MAX, "not touched");
        assert_eq!((older.port.direction, older.port.size), (1, 48));
        assert_eq!(newer.appended, 0);
        assert_eq!((newer.port.direction, newer.port.size), (1, 56));
        assert_eq!(ours.appended, 5);
    }

    #[test]
    fn what_cannot_be_used_is_told_apart() {
        let told = |it: Longer| {
            // SAFETY: only version and size are read.
            unsafe { size::<Longer>(&raw const it) }
        };
        assert_eq!(told(longer(47, 0)), Err(Misfit::Size(47)));
        assert_eq!(told(longer(48, 0)), Ok(48));
        assert_eq!(told(longer(4096, 0)), Ok(4096));
        assert_eq!(told(longer(4097, 0)), Err(Misfit::Size(4097)));
        let mut other = longer(56, 0);
        other.port.abi_version = 2;
        assert_eq!(told(other), Err(Misfit::Version(2)));
        // SAFETY: neither is looked at.
        unsafe {
            assert_eq!(size::<Port>(ptr::null()), Err(Misfit::Null));
            let odd = ptr::without_provenance::<Port>(0x1001);
            assert_eq!(size(odd), Err(Misfit::Unaligned(0x1001)));
        }
    }
}
