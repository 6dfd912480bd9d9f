//! The same value with its bytes in the other order, in place.

use super::decode::value_at;
use super::shape::{Shape, chosen, shape, size};
use super::walk::DISCRIMINATOR;
use super::{DEEPEST, Endian, Error, Reason};
use crate::idl::{Primitive, Type, Union, Unit};

/// Turns the bytes of a value from this order into the other one. Both are as long, and what lies between values stays.
/// After an error, some of the bytes are turned.
///
/// # Errors
/// The bytes are no value of the type, as far as that is seen on the way: texts are not looked into.
pub fn swap(unit: &Unit, r#type: &Type, bytes: &mut [u8], from: Endian) -> Result<(), Error> {
    let mut swapper = Swapper {
        unit,
        from,
        bytes,
        at: 0,
    };
    swapper
        .value(r#type, 0)
        .and_then(|()| match swapper.left() {
            0 => Ok(()),
            left => Err(swapper.error(Reason::Leftover(left))),
        })
        .map_err(|error| error.in_type(unit, r#type))
}

struct Swapper<'a> {
    unit: &'a Unit,
    from: Endian,
    bytes: &'a mut [u8],
    at: usize,
}

impl Swapper<'_> {
    fn value(&mut self, r#type: &Type, depth: u32) -> Result<(), Error> {
        if depth > DEEPEST {
            return Err(self.error(Reason::Deep));
        }
        match shape(self.unit, r#type).map_err(|reason| self.error(reason))? {
            Shape::Primitive(primitive) => self.primitives(primitive, 1),
            // The text itself has no order, or says which.
            Shape::String(_) | Shape::WString(_) => {
                let length = self.ulong()?;
                self.take(length as usize).map(|_| ())
            }
            Shape::Sequence(element, _) => {
                let count = self.ulong()?;
                let left = self.left();
                // Every element has one byte at least.
                if count as usize > left {
                    return Err(self.error(Reason::Claim { count, left }));
                }
                self.elements(element, &[], count, depth)
            }
            Shape::Array(element, dimensions) => self.array(element, dimensions, depth),
            Shape::Enum(_) => self.ulong().map(|_| ()),
            Shape::Struct(it) => it.members.iter().try_for_each(|member| {
                self.value(&member.r#type, depth + 1)
                    .map_err(|error| error.in_member(&member.name))
            }),
            Shape::Union(it) => self.union(it, depth),
        }
    }

    fn union(&mut self, union: &Union, depth: u32) -> Result<(), Error> {
        let r#type = &union.discriminator;
        let discriminator = value_at(self.unit, r#type, self.bytes, self.at, self.from)
            .map_err(|error| error.in_member(DISCRIMINATOR))?;
        self.value(r#type, depth + 1)?;
        match chosen(union, &discriminator) {
            Some(case) => self
                .value(&case.r#type, depth + 1)
                .map_err(|error| error.in_member(&case.name)),
            None => Ok(()),
        }
    }

    fn array(&mut self, element: &Type, dimensions: &[u32], depth: u32) -> Result<(), Error> {
        match dimensions.split_first() {
            None => self.value(element, depth),
            Some(_) if depth > DEEPEST => Err(self.error(Reason::Deep)),
            Some((count, inner)) => self.elements(element, inner, *count, depth),
        }
    }

    fn elements(
        &mut self,
        element: &Type,
        inner: &[u32],
        count: u32,
        depth: u32,
    ) -> Result<(), Error> {
        if inner.is_empty()
            && let Ok(Shape::Primitive(primitive)) = shape(self.unit, element)
            && primitive != Primitive::WChar
        {
            return self.primitives(primitive, count as usize);
        }
        (0..count as usize).try_for_each(|index| {
            self.array(element, inner, depth + 1)
                .map_err(|error| error.in_element(index))
        })
    }

    /// So many, one behind the other.
    fn primitives(&mut self, primitive: Primitive, count: usize) -> Result<(), Error> {
        if primitive == Primitive::WChar {
            let length = self.take(1)?[0];
            return self.take(length.into()).map(|_| ());
        }
        if count == 0 {
            return Ok(());
        }
        let size = size(primitive);
        self.align(size)?;
        let bytes = self.take(count.saturating_mul(size))?;
        if size > 1 {
            bytes.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
        Ok(())
    }

    fn ulong(&mut self) -> Result<u32, Error> {
        self.align(4)?;
        let from = self.from;
        let bytes = self.take(4)?;
        let number: [u8; 4] = std::array::from_fn(|i| bytes[i]);
        bytes.reverse();
        Ok(match from {
            Endian::Little => u32::from_le_bytes(number),
            Endian::Big => u32::from_be_bytes(number),
        })
    }

    fn align(&mut self, size: usize) -> Result<(), Error> {
        let padding = self.at.next_multiple_of(size.min(8)) - self.at;
        self.take(padding).map(|_| ())
    }

    fn take(&mut self, needed: usize) -> Result<&mut [u8], Error> {
        let (left, at) = (self.left(), self.at);
        let rest = self.bytes.get_mut(at..).unwrap_or_default();
        let Some((bytes, _)) = rest.split_at_mut_checked(needed) else {
            return Err(Error::at(Reason::Ends { needed, left }, at));
        };
        self.at += needed;
        Ok(bytes)
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn error(&self, reason: Reason) -> Error {
        Error::at(reason, self.at)
    }
}
