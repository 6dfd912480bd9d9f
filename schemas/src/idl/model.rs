//! What an IDL specification says, after its names were resolved.
//!
//! Definitions refer to each other by their place in [`Unit::definitions`], so a sequence of a struct within itself is
//! no special case, and nothing has to be looked up by name again.

use crate::span::Span;

/// All that was read, includes too, in the order of its definition.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Unit {
    /// Definitions; a [`Type::Named`] is an index into them.
    pub definitions: Vec<Definition>,
}

/// A definition with its names.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// Modules that it lies in, and its own name (`["RTC", "TimedLong"]`).
    pub path: Vec<String>,
    /// Repository id (`IDL:RTC/TimedLong:1.0`), after `#pragma prefix`, `ID` and `version`.
    pub repository_id: String,
    /// File that it was read from, as it was named to the reader.
    pub file: String,
    /// Where its name stands there.
    pub span: Span,
    /// What it is.
    pub kind: Kind,
}

/// What a definition is.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// `struct`.
    Struct(StructType),
    /// `union … switch`.
    Union(Union),
    /// `enum`.
    Enum(EnumType),
    /// `typedef`.
    Typedef(Typedef),
    /// `const`.
    Constant(Constant),
    /// `exception`.
    Exception(Exception),
    /// `interface`.
    Interface(Interface),
    /// `struct`, `union` or `interface` that is only announced: its definition was not read.
    Forward,
}

/// A type as it is used.
#[derive(Debug, Clone, PartialEq)]
pub enum Type {
    /// A number, a character, a truth value.
    Primitive(Primitive),
    /// `string`, `string<N>`.
    String {
        /// Most characters, without the zero that CDR adds.
        bound: Option<u32>,
    },
    /// `wstring`, `wstring<N>`.
    WString {
        /// Most characters.
        bound: Option<u32>,
    },
    /// `sequence<T>`, `sequence<T, N>`.
    Sequence {
        /// Type of the elements.
        element: Box<Type>,
        /// Most elements.
        bound: Option<u32>,
    },
    /// `T name[2][3]`: dimensions `[2, 3]`, none of them 0.
    Array {
        /// Type of the elements.
        element: Box<Type>,
        /// From the outermost to the innermost.
        dimensions: Vec<u32>,
    },
    /// A definition: its index in [`Unit::definitions`].
    Named(usize),
    /// `any`.
    Any,
    /// `Object`.
    Object,
}

/// A type without parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Primitive {
    /// `boolean`, 1 byte.
    Boolean,
    /// `octet`, 1 byte.
    Octet,
    /// `char`, 1 byte.
    Char,
    /// `wchar`.
    WChar,
    /// `short`, 16 bits.
    Short,
    /// `unsigned short`, 16 bits.
    UShort,
    /// `long`, 32 bits.
    Long,
    /// `unsigned long`, 32 bits.
    ULong,
    /// `long long`, 64 bits.
    LongLong,
    /// `unsigned long long`, 64 bits.
    ULongLong,
    /// `float`, 32 bits.
    Float,
    /// `double`, 64 bits.
    Double,
    /// `long double`, 128 bits.
    LongDouble,
}

/// A struct.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StructType {
    /// In the order of the file.
    pub members: Vec<Member>,
}

/// A member of a struct or an exception.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Name, without the underscore that escapes a keyword.
    pub name: String,
    /// Type.
    pub r#type: Type,
}

/// A discriminated union.
#[derive(Debug, Clone, PartialEq)]
pub struct Union {
    /// An integer, `char`, `boolean` or enum type.
    pub discriminator: Type,
    /// In the order of the file.
    pub cases: Vec<UnionCase>,
}

/// A member of a union with all of its labels.
#[derive(Debug, Clone, PartialEq)]
pub struct UnionCase {
    /// At least one.
    pub labels: Vec<Label>,
    /// Name.
    pub name: String,
    /// Type.
    pub r#type: Type,
}

/// A label of a case.
#[derive(Debug, Clone, PartialEq)]
pub enum Label {
    /// `case value:`.
    Value(ConstantValue),
    /// `default:`.
    Default,
}

/// An enum.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EnumType {
    /// Names in their order: the first is 0.
    pub enumerators: Vec<String>,
}

/// An alias.
#[derive(Debug, Clone, PartialEq)]
pub struct Typedef {
    /// What it stands for.
    pub r#type: Type,
}

/// A constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Declared type.
    pub r#type: Type,
    /// Value, after its expression was worked out.
    pub value: ConstantValue,
}

/// Value of a constant or a label.
#[derive(Debug, Clone, PartialEq)]
pub enum ConstantValue {
    /// Of an integer type or `octet`.
    Integer(i128),
    /// Of a floating type.
    Float(f64),
    /// `TRUE`, `FALSE`.
    Boolean(bool),
    /// Of `char` or `wchar`.
    Char(char),
    /// Of `string` or `wstring`.
    Text(String),
    /// An enumerator.
    Enumerator {
        /// Index of the enum in [`Unit::definitions`].
        definition: usize,
        /// Its number.
        ordinal: u32,
    },
}

/// An exception.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exception {
    /// In the order of the file.
    pub members: Vec<Member>,
}

/// An interface. Types, constants and exceptions that it defines are definitions of their own, below its path.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Interface {
    /// Indices of the interfaces that it inherits from directly.
    pub bases: Vec<usize>,
    /// `abstract`, `local` or none.
    pub modifier: Option<String>,
    /// Attributes of its own.
    pub attributes: Vec<Attribute>,
    /// Operations of its own.
    pub operations: Vec<Operation>,
}

/// An attribute.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// Name.
    pub name: String,
    /// Type.
    pub r#type: Type,
    /// `readonly`.
    pub readonly: bool,
}

/// An operation.
#[derive(Debug, Clone, PartialEq)]
pub struct Operation {
    /// Name.
    pub name: String,
    /// `oneway`.
    pub oneway: bool,
    /// None for `void`.
    pub result: Option<Type>,
    /// In the order of the file.
    pub parameters: Vec<Parameter>,
    /// Indices of the exceptions of `raises`.
    pub raises: Vec<usize>,
}

/// A parameter of an operation.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Which way it goes.
    pub direction: Direction,
    /// Name.
    pub name: String,
    /// Type.
    pub r#type: Type,
}

/// Which way a parameter goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// `in`.
    In,
    /// `out`.
    Out,
    /// `inout`.
    InOut,
}

impl Definition {
    /// Its name with those of its modules (`RTC::TimedLong`).
    pub fn name(&self) -> String {
        self.path.join("::")
    }
}

impl Unit {
    /// Index of the definition that is meant by a repository id (`IDL:RTC/TimedLong:1.0`), by its name with its modules
    /// (`RTC::TimedLong`), or by its own name if no other definition has it (`TimedLong`).
    pub fn find(&self, name: &str) -> Option<usize> {
        let position = |is: &dyn Fn(&Definition) -> bool| self.definitions.iter().position(is);
        if let Some(found) = position(&|definition| definition.repository_id == name) {
            return Some(found);
        }
        let path: Vec<&str> = name
            .strip_prefix("::")
            .unwrap_or(name)
            .split("::")
            .collect();
        if let Some(found) = position(&|definition| definition.path == path) {
            return Some(found);
        }
        let [own] = path.as_slice() else {
            return None;
        };
        let is_own =
            |definition: &Definition| definition.path.last().is_some_and(|last| last == own);
        let mut all = self
            .definitions
            .iter()
            .enumerate()
            .filter(|(_, definition)| is_own(definition));
        match (all.next(), all.next()) {
            (Some((index, _)), None) => Some(index),
            _ => None,
        }
    }
}
