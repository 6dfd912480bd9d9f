//! What types that are generated from IDL need beside serde.

use std::cell::Cell;
use std::fmt;
use std::ops::{Deref, DerefMut};

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::ser::SerializeTuple as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// An IDL array of any length: `N` elements without a length before them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Array<T, const N: usize>(Box<[T]>);

impl<T, const N: usize> Array<T, N> {
    /// Of the elements, if there are `N` of them.
    pub fn new(elements: Vec<T>) -> Option<Self> {
        (elements.len() == N).then(|| Self(elements.into_boxed_slice()))
    }
}

impl<T: Default, const N: usize> Default for Array<T, N> {
    fn default() -> Self {
        Self((0..N).map(|_| T::default()).collect())
    }
}

impl<T, const N: usize> From<[T; N]> for Array<T, N> {
    fn from(elements: [T; N]) -> Self {
        Self(Box::new(elements))
    }
}

impl<T, const N: usize> Deref for Array<T, N> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T, const N: usize> DerefMut for Array<T, N> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

impl<T: Serialize, const N: usize> Serialize for Array<T, N> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut tuple = to.serialize_tuple(N)?;
        for element in &self.0 {
            tuple.serialize_element(element)?;
        }
        tuple.end()
    }
}

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Array<T, N> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Elements<T, const N: usize>(std::marker::PhantomData<T>);

        impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Elements<T, N> {
            type Value = Array<T, N>;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(to, "{N} elements")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<Array<T, N>, A::Error> {
                // Memory grows with what is really there.
                let mut elements = Vec::new();
                while elements.len() < N {
                    let next = from.next_element()?;
                    elements
                        .push(next.ok_or_else(|| A::Error::invalid_length(elements.len(), &self))?);
                }
                Ok(Array(elements.into_boxed_slice()))
            }
        }

        from.deserialize_tuple(N, Elements(std::marker::PhantomData))
    }
}

/// Values of one type within each other that are read.
const DEPTH: usize = 64;

thread_local! {
    static NESTED: Cell<usize> = const { Cell::new(0) };
}

/// Reads what may hold itself again, 64 deep: a sample must not end the process by a stack that is too small.
///
/// # Errors
/// It is deeper, or not of the type.
pub fn nested<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<T, D::Error> {
    struct Level;

    impl Drop for Level {
        fn drop(&mut self) {
            NESTED.set(NESTED.get() - 1);
        }
    }

    if NESTED.get() >= DEPTH {
        return Err(D::Error::custom(
            "values of one type are too deep within each other",
        ));
    }
    NESTED.set(NESTED.get() + 1);
    let _level = Level;
    T::deserialize(from)
}

/// What [`nested`] reads, where there is no field to say so.
#[derive(Debug)]
pub struct Nested<T>(pub T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Nested<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        nested(from).map(Self)
    }
}
