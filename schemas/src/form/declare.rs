//! `profile_form!`: a type, its fields and what is said of them, in one place.

/// Declares a struct that is a [`Form`](crate::form::Form).
///
/// A field is `name: kind = NAMESPACE "XmlName" "yamlKey";`. Its kind is `attribute`, `number`, `boolean` or `date` (an
/// attribute), `text` or `texts` (elements with text alone), `one<T>`, `some<T>` or `many<T>` (elements of a type).
/// Several YAML keys are parted by `|`, the one that is written first; `a/b` is the key `b` in a mapping under `a`.
#[macro_export]
macro_rules! profile_form {
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident {
            $(
                $(#[doc = $fdoc:literal])*
                $field:ident: $kind:ident $(<$of:ty>)? = $ns:ident $local:literal $key:literal;
            )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq, Eq, Default)]
        pub struct $name {
            /// Where it stands.
            pub span: $crate::span::Span,
            $( $(#[doc = $fdoc])* pub $field: $crate::profile_form!(@type $kind $(<$of>)?), )*
            /// What has no field here, and the order of all.
            pub extra: $crate::form::Extra,
        }

        impl $name {
            /// What is said of the type.
            pub fn form_type() -> &'static $crate::form::FormType {
                static TYPE: $crate::form::FormType = $crate::form::FormType {
                    name: stringify!($name),
                    doc: concat!($($doc, "\n"),*),
                    size: size_of::<$name>(),
                    fields: &[$(
                        $crate::form::FieldType {
                            name: stringify!($field),
                            namespace: $ns,
                            local: $local,
                            keys: $key,
                            kind: $crate::profile_form!(@kind $kind $(<$of>)?),
                            doc: concat!($($fdoc, "\n"),*),
                        },
                    )*],
                };
                &TYPE
            }
        }

        impl $crate::form::Form for $name {
            fn form_type(&self) -> &'static $crate::form::FormType {
                $name::form_type()
            }
            fn span(&self) -> $crate::span::Span {
                self.span
            }
            fn stand(&mut self, span: $crate::span::Span) {
                self.span = span;
            }
            fn value(&self, field: usize) -> $crate::form::Value<'_> {
                let mut index = 0;
                $(
                    if index == field {
                        return $crate::profile_form!(@value $kind self.$field);
                    }
                    index += 1;
                )*
                let _ = index;
                $crate::form::Value::Texts(&[])
            }
            fn slot(&mut self, field: usize) -> Option<$crate::form::Slot<'_>> {
                let mut index = 0;
                $(
                    if index == field {
                        return Some($crate::profile_form!(@slot $kind self.$field));
                    }
                    index += 1;
                )*
                let _ = index;
                None
            }
            fn extra(&self) -> &$crate::form::Extra {
                &self.extra
            }
            fn extra_mut(&mut self) -> &mut $crate::form::Extra {
                &mut self.extra
            }
        }
    };
    (@type text) => { Option<$crate::span::Text> };
    (@type texts) => { Vec<$crate::span::Text> };
    (@type one<$of:ty>) => { Option<Box<$of>> };
    (@type some<$of:ty>) => { Vec<$of> };
    (@type many<$of:ty>) => { Vec<$of> };
    (@type $attribute:ident) => { Option<$crate::span::Text> };
    (@kind attribute) => { $crate::form::FieldKind::Attribute($crate::form::Scalar::Text) };
    (@kind number) => { $crate::form::FieldKind::Attribute($crate::form::Scalar::Number) };
    (@kind boolean) => { $crate::form::FieldKind::Attribute($crate::form::Scalar::Boolean) };
    (@kind date) => { $crate::form::FieldKind::Attribute($crate::form::Scalar::Date) };
    (@kind text) => { $crate::form::FieldKind::Text };
    (@kind texts) => { $crate::form::FieldKind::Texts };
    (@kind one<$of:ty>) => { $crate::form::FieldKind::One(<$of>::form_type) };
    (@kind some<$of:ty>) => { $crate::form::FieldKind::Some(<$of>::form_type) };
    (@kind many<$of:ty>) => { $crate::form::FieldKind::Many(<$of>::form_type) };
    (@value texts $e:expr) => { $crate::form::Value::Texts(&$e) };
    (@value one $e:expr) => { $crate::form::Value::Forms(&$e) };
    (@value some $e:expr) => { $crate::form::Value::Forms(&$e) };
    (@value many $e:expr) => { $crate::form::Value::Forms(&$e) };
    (@value $text:ident $e:expr) => { $crate::form::Value::Text($e.as_ref()) };
    (@slot texts $e:expr) => { $crate::form::Slot::Texts(&mut $e) };
    (@slot one $e:expr) => { $crate::form::Slot::Forms(&mut $e) };
    (@slot some $e:expr) => { $crate::form::Slot::Forms(&mut $e) };
    (@slot many $e:expr) => { $crate::form::Slot::Forms(&mut $e) };
    (@slot $text:ident $e:expr) => { $crate::form::Slot::Text(&mut $e) };
}

pub use crate::profile_form;
