//! `yaml_type!`: a mapping, its keys and what is said of them, in one place.

/// Declares a struct that is a [`YamlType`](crate::yaml_type::YamlType).
///
/// A field is `name: Type = "key";`, and `required` after the key when it must be there. `["code", "prefix"]` after the
/// name says the code of an unknown key, and what may stand before each key.
macro_rules! yaml_type {
    (
        $(#[doc = $doc:literal])*
        pub struct $name:ident $([$code:literal, $prefix:literal])? {
            $(
                $(#[doc = $fdoc:literal])*
                $field:ident: $type:ty = $key:literal $($required:ident)?;
            )*
        }
    ) => {
        $(#[doc = $doc])*
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct $name {
            $( $(#[doc = $fdoc])* pub $field: $crate::yaml_type::Setting<$type>, )*
        }

        impl $name {
            /// The keys, in the order of their declaration.
            pub const KEYS: &'static [&'static str] = &[$($key),*];
        }

        impl $crate::yaml_type::YamlType for $name {
            fn schema(definitions: &mut $crate::yaml_type::Definitions) -> serde_json::Value {
                definitions.refer(stringify!($name), |definitions| {
                    let prefix: &[&str] = &[$($prefix)?];
                    let mut object = $crate::yaml_type::Object::new(
                        concat!($($doc, "\n"),*),
                        prefix.first().copied(),
                    );
                    $(
                        let schema = <$type as $crate::yaml_type::YamlType>::schema(definitions);
                        let required: &[&str] = &[$(stringify!($required))?];
                        let doc = concat!($($fdoc, "\n"),*);
                        object.key($key, doc, schema, !required.is_empty());
                    )*
                    object
                })
            }

            fn read(
                node: &$crate::yaml::Node,
                key: &str,
                faults: &mut $crate::yaml_type::Faults,
            ) -> Option<Self> {
                if !matches!(node.value, $crate::yaml::Value::Mapping(_)) {
                    let what = match key {
                        "" => concat!("a ", stringify!($name)).to_owned(),
                        key => format!("`{key}`"),
                    };
                    let help = "write `key: value` lines";
                    faults.wrong_shape(&what, "must be a mapping", node, help);
                    return None;
                }
                let prefix: &[&str] = &[$($prefix)?];
                let codes: &[&str] = &[$($code,)? "unknown-key"];
                let mut read = Self::default();
                for (name, value) in node.entries() {
                    let bare = prefix
                        .first()
                        .and_then(|prefix| name.value.strip_prefix(prefix))
                        .unwrap_or(&name.value);
                    let name = &$crate::span::Text::new(bare, name.span);
                    match bare {
                        $(
                            $key => {
                                read.$field = $crate::yaml_type::Setting::read(name, value, faults);
                            }
                        )*
                        _ => faults.unknown_key(codes[0], bare, Self::KEYS, name.span),
                    }
                }
                $( $crate::yaml_type::yaml_type!(@required node faults $key $type $(, $required)?); )*
                Some(read)
            }

            fn write(&self) -> serde_json::Value {
                let mut object = serde_json::Map::new();
                $(
                    if let Some(value) = self.$field.write() {
                        object.insert($key.to_owned(), value);
                    }
                )*
                serde_json::Value::Object(object)
            }

            fn leaves(
                &self,
                path: &[&str],
                _: $crate::span::Span,
                leaves: &mut Vec<$crate::yaml_type::Leaf>,
            ) {
                $( self.$field.leaves(path, $key, leaves); )*
            }

            fn rows(path: &str, _: &str, rows: &mut Vec<$crate::yaml_type::Row>) {
                $(
                    let doc = $crate::yaml_type::text_of(concat!($($fdoc, "\n"),*));
                    let key = match path {
                        "" => $key.to_owned(),
                        path => format!("{path}.{}", $key),
                    };
                    <$type as $crate::yaml_type::YamlType>::rows(&key, &doc, rows);
                )*
            }
        }
    };
    (@required $node:ident $faults:ident $key:literal $type:ty, required) => {
        if $node.get($key).is_none_or(|value| value.value == $crate::yaml::Value::Null) {
            $faults.missing_key::<$type>($key, $node);
        }
    };
    (@required $node:ident $faults:ident $key:literal $type:ty) => {};
}

pub(crate) use yaml_type;
