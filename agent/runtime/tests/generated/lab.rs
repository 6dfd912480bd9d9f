// Generated from IDL by rtsctl: change the IDL file, not this one.

/// `ANSWER`.
#[allow(dead_code, missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals, clippy::all)]
pub const ANSWER: i32 = 42;

/// `module Lab`.
#[allow(dead_code, missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals, clippy::all)]
pub mod Lab {
    /// `Lab::Mode`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub enum Mode {
        #[default]
        /// 0.
        IDLE,
        /// 1.
        MOVING,
        /// 2.
        Self_,
    }

    /// `Lab::State`.
    pub type State = Mode;

    /// `Lab::FIRST`.
    pub const FIRST: Mode = Mode::MOVING;

    /// `Lab::MASK`.
    pub const MASK: u8 = 240;

    /// `Lab::RATIO`.
    pub const RATIO: ::core::primitive::f64 = 0.25;

    /// `Lab::NAME`.
    pub const NAME: &str = "lab \"1\"";

    /// `Lab::ROBOT`.
    pub const ROBOT: &str = "ロボ";

    /// `Lab::LETTER`.
    pub const LETTER: u8 = 97;

    /// `Lab::YES`.
    pub const YES: bool = true;

    /// `Lab::label`.
    pub const label: i32 = 1;

    /// `Lab::value`.
    pub const value: i32 = 2;

    /// `Lab::Ok`.
    pub const Ok: i32 = 3;

    /// `Lab::f64`.
    pub const f64: i32 = 4;

    /// `Lab::MANY`.
    pub const MANY: u64 = 18446744073709551615;

    /// `Lab::Matrix`.
    pub type Matrix = [[::core::primitive::f64; 3]; 2];

    /// `Lab::Path`. At most 100 elements.
    pub type Path = Vec<::rts_runtime::types::Point3D>;

    /// `Lab::Reading`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Reading {
        pub tm: ::rts_runtime::types::Time,
        pub state: Mode,
        pub letter: u8,
        pub count: u64,
        pub pose: Matrix,
        pub raw: ::rts_runtime::types::Array<u8, 40>,
        /// At most 8 bytes.
        pub r#type: ::std::string::String,
        pub way: Path,
        pub flags: [bool; 2],
    }

    impl ::rts_runtime::types::DataType for Reading {
        const TYPE_ID: &'static str = "IDL:Lab/Reading:1.0";
    }

    /// `Lab::SIGN`.
    pub const SIGN: char = 'あ';

    /// `Lab::Octets`.
    pub type Octets = Vec<u8>;

    /// `Lab::Wide`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Wide {
        pub letter: ::rts_runtime::types::WChar,
        pub text: ::rts_runtime::types::WString,
        #[serde(serialize_with = "::rts_runtime::types::octets")]
        pub raw: Octets,
        /// At most 4 elements.
        #[serde(serialize_with = "::rts_runtime::types::octets")]
        pub letters: Vec<u8>,
    }

    impl ::rts_runtime::types::DataType for Wide {
        const TYPE_ID: &'static str = "IDL:Lab/Wide:1.0";
    }

    /// `Lab::Outer`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Outer {
        pub part: Outer_Inner,
        pub which: Outer_Kind,
    }

    impl ::rts_runtime::types::DataType for Outer {
        const TYPE_ID: &'static str = "IDL:Lab/Outer:1.0";
    }

    /// `Lab::Outer::Inner`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Outer_Inner {
        pub r#fn: i16,
    }

    impl ::rts_runtime::types::DataType for Outer_Inner {
        const TYPE_ID: &'static str = "IDL:Lab/Outer/Inner:1.0";
    }

    /// `Lab::Outer::Kind`.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub enum Outer_Kind {
        #[default]
        /// 0.
        A,
        /// 1.
        B,
    }

    /// `Lab::Again`.
    pub type Again = Outer_Inner;

    /// `Lab::Node`.
    #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
    #[serde(crate = "::rts_runtime::serde")]
    pub struct Node {
        pub count: i32,
        #[serde(deserialize_with = "::rts_runtime::types::nested")]
        pub children: Nodes,
    }

    impl ::rts_runtime::types::DataType for Node {
        const TYPE_ID: &'static str = "IDL:Lab/Node:1.0";
    }

    /// `Lab::Nodes`.
    pub type Nodes = Vec<Node>;

    /// `Lab::Choice`.
    #[derive(Debug, Clone, PartialEq)]
    pub enum Choice {
        /// `case Mode::IDLE`.
        number(i32),
        /// `case Mode::MOVING`, `case Mode::Self_`.
        text(Mode, ::std::string::String),
    }

    impl ::core::default::Default for Choice {
        fn default() -> Self {
            Self::number(::core::default::Default::default())
        }
    }

    impl ::rts_runtime::serde::Serialize for Choice {
        fn serialize<__S: ::rts_runtime::serde::Serializer>(&self, __to: __S) -> ::core::result::Result<__S::Ok, __S::Error> {
            use ::rts_runtime::serde::ser::SerializeTuple as _;
            let mut __to = __to.serialize_tuple(2)?;
            match self {
                Self::number(__value) => {
                    let __label: Mode = Mode::IDLE;
                    __to.serialize_element(&__label)?;
                    __to.serialize_element(__value)?;
                }
                Self::text(__label, __value) => {
                    if !matches!(__label, Mode::MOVING | Mode::Self_) {
                        return ::core::result::Result::Err(::rts_runtime::serde::ser::Error::custom("the value does not choose this case"));
                    }
                    __to.serialize_element(__label)?;
                    __to.serialize_element(__value)?;
                }
            }
            __to.end()
        }
    }

    impl<'de> ::rts_runtime::serde::Deserialize<'de> for Choice {
        fn deserialize<__D: ::rts_runtime::serde::Deserializer<'de>>(__from: __D) -> ::core::result::Result<Self, __D::Error> {
            struct __Parts;

            impl<'de> ::rts_runtime::serde::de::Visitor<'de> for __Parts {
                type Value = Choice;

                fn expecting(&self, __to: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                    __to.write_str("a union")
                }

                fn visit_seq<__A: ::rts_runtime::serde::de::SeqAccess<'de>>(self, mut __from: __A) -> ::core::result::Result<Choice, __A::Error> {
                    use ::rts_runtime::serde::de::Error as _;
                    let __short = || __A::Error::custom("the union ends too early");
                    let __label: Mode = __from.next_element()?.ok_or_else(__short)?;
                    ::core::result::Result::Ok(match __label {
                        Mode::IDLE => Choice::number(__from.next_element()?.ok_or_else(__short)?),
                        Mode::MOVING | Mode::Self_ => Choice::text(__label, __from.next_element()?.ok_or_else(__short)?),
                    })
                }
            }

            __from.deserialize_tuple(2, __Parts)
        }
    }

    impl ::rts_runtime::types::DataType for Choice {
        const TYPE_ID: &'static str = "IDL:Lab/Choice:1.0";
    }

    /// `Lab::Number`.
    #[derive(Debug, Clone, PartialEq)]
    pub enum Number {
        /// `case -1`, `case 1`.
        real(i16, ::core::primitive::f64),
        /// `case 7`.
        small(u8),
        /// Any other value: nothing is with it.
        otherwise(i16),
    }

    impl ::core::default::Default for Number {
        fn default() -> Self {
            Self::real(-1, ::core::default::Default::default())
        }
    }

    impl ::rts_runtime::serde::Serialize for Number {
        fn serialize<__S: ::rts_runtime::serde::Serializer>(&self, __to: __S) -> ::core::result::Result<__S::Ok, __S::Error> {
            use ::rts_runtime::serde::ser::SerializeTuple as _;
            let mut __to = __to.serialize_tuple(2)?;
            match self {
                Self::real(__label, __value) => {
                    if !matches!(__label, -1 | 1) {
                        return ::core::result::Result::Err(::rts_runtime::serde::ser::Error::custom("the value does not choose this case"));
                    }
                    __to.serialize_element(__label)?;
                    __to.serialize_element(__value)?;
                }
                Self::small(__value) => {
                    let __label: i16 = 7;
                    __to.serialize_element(&__label)?;
                    __to.serialize_element(__value)?;
                }
                Self::otherwise(__label) => {
                    if matches!(__label, -1 | 1 | 7) {
                        return ::core::result::Result::Err(::rts_runtime::serde::ser::Error::custom("the value does not choose this case"));
                    }
                    __to.serialize_element(__label)?;
                }
            }
            __to.end()
        }
    }

    impl<'de> ::rts_runtime::serde::Deserialize<'de> for Number {
        fn deserialize<__D: ::rts_runtime::serde::Deserializer<'de>>(__from: __D) -> ::core::result::Result<Self, __D::Error> {
            struct __Parts;

            impl<'de> ::rts_runtime::serde::de::Visitor<'de> for __Parts {
                type Value = Number;

                fn expecting(&self, __to: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                    __to.write_str("a union")
                }

                fn visit_seq<__A: ::rts_runtime::serde::de::SeqAccess<'de>>(self, mut __from: __A) -> ::core::result::Result<Number, __A::Error> {
                    use ::rts_runtime::serde::de::Error as _;
                    let __short = || __A::Error::custom("the union ends too early");
                    let __label: i16 = __from.next_element()?.ok_or_else(__short)?;
                    ::core::result::Result::Ok(match __label {
                        -1 | 1 => Number::real(__label, __from.next_element()?.ok_or_else(__short)?),
                        7 => Number::small(__from.next_element()?.ok_or_else(__short)?),
                        _ => Number::otherwise(__label),
                    })
                }
            }

            __from.deserialize_tuple(2, __Parts)
        }
    }

    impl ::rts_runtime::types::DataType for Number {
        const TYPE_ID: &'static str = "IDL:Lab/Number:1.0";
    }

    /// `Lab::Other`.
    #[derive(Debug, Clone, PartialEq)]
    pub enum Other {
        /// `case true`.
        yes(i64),
        /// `default`.
        no(bool, Choice),
    }

    impl ::core::default::Default for Other {
        fn default() -> Self {
            Self::yes(::core::default::Default::default())
        }
    }

    impl ::rts_runtime::serde::Serialize for Other {
        fn serialize<__S: ::rts_runtime::serde::Serializer>(&self, __to: __S) -> ::core::result::Result<__S::Ok, __S::Error> {
            use ::rts_runtime::serde::ser::SerializeTuple as _;
            let mut __to = __to.serialize_tuple(2)?;
            match self {
                Self::yes(__value) => {
                    let __label: bool = true;
                    __to.serialize_element(&__label)?;
                    __to.serialize_element(__value)?;
                }
                Self::no(__label, __value) => {
                    if matches!(__label, true) {
                        return ::core::result::Result::Err(::rts_runtime::serde::ser::Error::custom("the value does not choose this case"));
                    }
                    __to.serialize_element(__label)?;
                    __to.serialize_element(__value)?;
                }
            }
            __to.end()
        }
    }

    impl<'de> ::rts_runtime::serde::Deserialize<'de> for Other {
        fn deserialize<__D: ::rts_runtime::serde::Deserializer<'de>>(__from: __D) -> ::core::result::Result<Self, __D::Error> {
            struct __Parts;

            impl<'de> ::rts_runtime::serde::de::Visitor<'de> for __Parts {
                type Value = Other;

                fn expecting(&self, __to: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                    __to.write_str("a union")
                }

                fn visit_seq<__A: ::rts_runtime::serde::de::SeqAccess<'de>>(self, mut __from: __A) -> ::core::result::Result<Other, __A::Error> {
                    use ::rts_runtime::serde::de::Error as _;
                    let __short = || __A::Error::custom("the union ends too early");
                    let __label: bool = __from.next_element()?.ok_or_else(__short)?;
                    ::core::result::Result::Ok(match __label {
                        true => Other::yes(__from.next_element()?.ok_or_else(__short)?),
                        _ => Other::no(__label, __from.next_element()?.ok_or_else(__short)?),
                    })
                }
            }

            __from.deserialize_tuple(2, __Parts)
        }
    }

    impl ::rts_runtime::types::DataType for Other {
        const TYPE_ID: &'static str = "IDL:Lab/Other:1.0";
    }

    /// `Lab::Tree`.
    #[derive(Debug, Clone, PartialEq)]
    pub enum Tree {
        /// `case 108`.
        leaf(i32),
        /// `case 116`.
        branches(Trees),
        /// Any other value: nothing is with it.
        otherwise(u8),
    }

    impl ::core::default::Default for Tree {
        fn default() -> Self {
            Self::leaf(::core::default::Default::default())
        }
    }

    impl ::rts_runtime::serde::Serialize for Tree {
        fn serialize<__S: ::rts_runtime::serde::Serializer>(&self, __to: __S) -> ::core::result::Result<__S::Ok, __S::Error> {
            use ::rts_runtime::serde::ser::SerializeTuple as _;
            let mut __to = __to.serialize_tuple(2)?;
            match self {
                Self::leaf(__value) => {
                    let __label: u8 = 108;
                    __to.serialize_element(&__label)?;
                    __to.serialize_element(__value)?;
                }
                Self::branches(__value) => {
                    let __label: u8 = 116;
                    __to.serialize_element(&__label)?;
                    __to.serialize_element(__value)?;
                }
                Self::otherwise(__label) => {
                    if matches!(__label, 108 | 116) {
                        return ::core::result::Result::Err(::rts_runtime::serde::ser::Error::custom("the value does not choose this case"));
                    }
                    __to.serialize_element(__label)?;
                }
            }
            __to.end()
        }
    }

    impl<'de> ::rts_runtime::serde::Deserialize<'de> for Tree {
        fn deserialize<__D: ::rts_runtime::serde::Deserializer<'de>>(__from: __D) -> ::core::result::Result<Self, __D::Error> {
            struct __Parts;

            impl<'de> ::rts_runtime::serde::de::Visitor<'de> for __Parts {
                type Value = Tree;

                fn expecting(&self, __to: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                    __to.write_str("a union")
                }

                fn visit_seq<__A: ::rts_runtime::serde::de::SeqAccess<'de>>(self, mut __from: __A) -> ::core::result::Result<Tree, __A::Error> {
                    use ::rts_runtime::serde::de::Error as _;
                    let __short = || __A::Error::custom("the union ends too early");
                    let __label: u8 = __from.next_element()?.ok_or_else(__short)?;
                    ::core::result::Result::Ok(match __label {
                        108 => Tree::leaf(__from.next_element()?.ok_or_else(__short)?),
                        116 => Tree::branches(__from.next_element::<::rts_runtime::types::Nested<_>>()?.ok_or_else(__short)?.0),
                        _ => Tree::otherwise(__label),
                    })
                }
            }

            __from.deserialize_tuple(2, __Parts)
        }
    }

    impl ::rts_runtime::types::DataType for Tree {
        const TYPE_ID: &'static str = "IDL:Lab/Tree:1.0";
    }

    /// `Lab::Trees`.
    pub type Trees = Vec<Tree>;

    /// `module Inner`.
    pub mod Inner {
        /// `Lab::Inner::String`.
        #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
        #[serde(crate = "::rts_runtime::serde")]
        pub struct String {
            pub value: ::std::string::String,
        }

        impl ::rts_runtime::types::DataType for String {
            const TYPE_ID: &'static str = "IDL:Lab/Inner/String:1.0";
        }

        /// `Lab::Inner::Box`.
        #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
        #[serde(crate = "::rts_runtime::serde")]
        pub struct Box {
            pub last: ::rts_runtime::types::TimedLong,
            pub name: String,
            pub names: ::rts_runtime::types::Array<String, 33>,
            pub mode: super::super::Lab::State,
        }

        impl ::rts_runtime::types::DataType for Box {
            const TYPE_ID: &'static str = "IDL:Lab/Inner/Box:1.0";
        }
    }

    /// `module Primitives`.
    pub mod Primitives {
        /// `Lab::Primitives::str`.
        #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
        #[serde(crate = "::rts_runtime::serde")]
        pub struct str_ {
            pub value: ::std::string::String,
        }

        impl ::rts_runtime::types::DataType for str_ {
            const TYPE_ID: &'static str = "IDL:Lab/Primitives/str:1.0";
        }

        /// `Lab::Primitives::u8`.
        #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
        #[serde(crate = "::rts_runtime::serde")]
        pub struct u8_ {
            pub value: u8,
            pub text: str_,
        }

        impl ::rts_runtime::types::DataType for u8_ {
            const TYPE_ID: &'static str = "IDL:Lab/Primitives/u8:1.0";
        }

        /// `Lab::Primitives::u64`.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
        #[serde(crate = "::rts_runtime::serde")]
        pub enum u64_ {
            #[default]
            /// 0.
            A,
            /// 1.
            B,
        }

        /// `Lab::Primitives::usize`.
        pub type usize_ = Vec<u8_>;

        /// `Lab::Primitives::i32`.
        #[derive(Debug, Clone, PartialEq)]
        pub enum i32_ {
            /// `case u64_::A`.
            text(str_),
            /// `case u64_::B`.
            list(usize_),
        }

        impl ::core::default::Default for i32_ {
            fn default() -> Self {
                Self::text(::core::default::Default::default())
            }
        }

        impl ::rts_runtime::serde::Serialize for i32_ {
            fn serialize<__S: ::rts_runtime::serde::Serializer>(&self, __to: __S) -> ::core::result::Result<__S::Ok, __S::Error> {
                use ::rts_runtime::serde::ser::SerializeTuple as _;
                let mut __to = __to.serialize_tuple(2)?;
                match self {
                    Self::text(__value) => {
                        let __label: u64_ = u64_::A;
                        __to.serialize_element(&__label)?;
                        __to.serialize_element(__value)?;
                    }
                    Self::list(__value) => {
                        let __label: u64_ = u64_::B;
                        __to.serialize_element(&__label)?;
                        __to.serialize_element(__value)?;
                    }
                }
                __to.end()
            }
        }

        impl<'de> ::rts_runtime::serde::Deserialize<'de> for i32_ {
            fn deserialize<__D: ::rts_runtime::serde::Deserializer<'de>>(__from: __D) -> ::core::result::Result<Self, __D::Error> {
                struct __Parts;

                impl<'de> ::rts_runtime::serde::de::Visitor<'de> for __Parts {
                    type Value = i32_;

                    fn expecting(&self, __to: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                        __to.write_str("a union")
                    }

                    fn visit_seq<__A: ::rts_runtime::serde::de::SeqAccess<'de>>(self, mut __from: __A) -> ::core::result::Result<i32_, __A::Error> {
                        use ::rts_runtime::serde::de::Error as _;
                        let __short = || __A::Error::custom("the union ends too early");
                        let __label: u64_ = __from.next_element()?.ok_or_else(__short)?;
                        ::core::result::Result::Ok(match __label {
                            u64_::A => i32_::text(__from.next_element()?.ok_or_else(__short)?),
                            u64_::B => i32_::list(__from.next_element()?.ok_or_else(__short)?),
                        })
                    }
                }

                __from.deserialize_tuple(2, __Parts)
            }
        }

        impl ::rts_runtime::types::DataType for i32_ {
            const TYPE_ID: &'static str = "IDL:Lab/Primitives/i32:1.0";
        }

        /// `Lab::Primitives::str_`.
        pub const str__: i32 = 1;

        /// `module bool_`.
        pub mod bool_ {
            /// `Lab::Primitives::bool::isize`.
            #[derive(Debug, Clone, Default, PartialEq, ::rts_runtime::serde::Serialize, ::rts_runtime::serde::Deserialize)]
            #[serde(crate = "::rts_runtime::serde")]
            pub struct isize_ {
                pub it: super::super::super::Lab::Primitives::i32_,
                pub yes: bool,
            }

            impl ::rts_runtime::types::DataType for isize_ {
                const TYPE_ID: &'static str = "IDL:Lab/Primitives/bool/isize:1.0";
            }
        }
    }
}
