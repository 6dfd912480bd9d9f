//! Recorded data: values that an out-port of a stand-in plays. They are kept as they are spelled; the data type of the port
//! says what they mean.

use super::Shape;
use crate::placement::parse_bool;
use crate::suggest;
use crate::system::{Direction, PortKind};

/// Most values of a port.
pub const MAX_VALUES: usize = 10_000;

/// Most bytes that the values of all ports of a component may have together, each with three more.
pub const MAX_BYTES: usize = 1024 * 1024;

/// What the texts of a value can be read as.
pub trait Value: Sized {
    /// The value that the texts spell.
    fn of(texts: &[String]) -> Option<Self>;
}

/// A value of one text.
trait Element: Sized {
    fn of(text: &str) -> Option<Self>;
}

impl Element for bool {
    fn of(text: &str) -> Option<Self> {
        parse_bool(text)
    }
}

impl Element for String {
    /// A string of CORBA ends at the first NUL.
    fn of(text: &str) -> Option<Self> {
        (!text.contains('\0')).then(|| text.to_owned())
    }
}

macro_rules! numbers {
    (whole: $($whole:ty),*; floating: $($floating:ident),*) => {
        $(
            impl Element for $whole {
                fn of(text: &str) -> Option<Self> {
                    text.trim().parse().ok()
                }
            }
        )*
        $(
            impl Element for $floating {
                /// As YAML spells them; a number that is too large is none.
                fn of(text: &str) -> Option<Self> {
                    match text.trim() {
                        ".nan" | ".NaN" => Some($floating::NAN),
                        ".inf" => Some($floating::INFINITY),
                        "-.inf" => Some($floating::NEG_INFINITY),
                        text => text.parse().ok().filter(|number: &$floating| number.is_finite()),
                    }
                }
            }
        )*
    };
}

numbers! { whole: u8, i16, i32; floating: f32, f64 }

macro_rules! values {
    ($($element:ty),*) => {$(
        impl Value for $element {
            fn of(texts: &[String]) -> Option<Self> {
                match texts {
                    [one] => Element::of(one),
                    _ => None,
                }
            }
        }
    )*};
}

values! { bool, u8, i16, i32, f32, f64, String }

impl<T: Element> Value for Vec<T> {
    fn of(texts: &[String]) -> Option<Self> {
        texts.iter().map(|text| Element::of(text)).collect()
    }
}

/// Whether texts spell a value.
type Fits = fn(&[String]) -> bool;

fn fits<T: Value>(texts: &[String]) -> bool {
    T::of(texts).is_some()
}

/// The data types that can be played, and what each of their values is.
const TYPES: &[(&str, Fits, &str)] = &[
    (
        "IDL:RTC/TimedBoolean:1.0",
        fits::<bool>,
        "`true` or `false`",
    ),
    (
        "IDL:RTC/TimedOctet:1.0",
        fits::<u8>,
        "a whole number from 0 to 255",
    ),
    (
        "IDL:RTC/TimedShort:1.0",
        fits::<i16>,
        "a whole number from -32768 to 32767",
    ),
    (
        "IDL:RTC/TimedLong:1.0",
        fits::<i32>,
        "a whole number from -2147483648 to 2147483647",
    ),
    ("IDL:RTC/TimedFloat:1.0", fits::<f32>, "a number of 32 bits"),
    ("IDL:RTC/TimedDouble:1.0", fits::<f64>, "a number"),
    ("IDL:RTC/TimedString:1.0", fits::<String>, "a text"),
    (
        "IDL:RTC/TimedOctetSeq:1.0",
        fits::<Vec<u8>>,
        "a list of whole numbers from 0 to 255",
    ),
    (
        "IDL:RTC/TimedShortSeq:1.0",
        fits::<Vec<i16>>,
        "a list of whole numbers from -32768 to 32767",
    ),
    (
        "IDL:RTC/TimedLongSeq:1.0",
        fits::<Vec<i32>>,
        "a list of whole numbers from -2147483648 to 2147483647",
    ),
    (
        "IDL:RTC/TimedFloatSeq:1.0",
        fits::<Vec<f32>>,
        "a list of numbers of 32 bits",
    ),
    (
        "IDL:RTC/TimedDoubleSeq:1.0",
        fits::<Vec<f64>>,
        "a list of numbers",
    ),
];

/// What is wrong with values for a port of a data type, and what would be right.
pub fn problem(data_type: &str, values: &[Vec<String>]) -> Option<(String, String)> {
    let Some((_, fits, expected)) = TYPES.iter().find(|(known, _, _)| *known == data_type) else {
        let known: Vec<&str> = TYPES.iter().map(|(known, _, _)| short(known)).collect();
        return Some((
            format!("recorded data cannot be played as {data_type}"),
            format!("types that can: {}", known.join(", ")),
        ));
    };
    if values.is_empty() || values.len() > MAX_VALUES {
        let message = format!("there are {} values", values.len());
        return Some((message, format!("write 1 to {MAX_VALUES}")));
    }
    let (index, wrong) = values.iter().enumerate().find(|(_, texts)| !fits(texts))?;
    let message = format!(
        "value {} of {}, {}, is no {}",
        index + 1,
        values.len(),
        shown(wrong),
        short(data_type)
    );
    Some((message, format!("expected: {expected}")))
}

/// `TimedLong`.
fn short(data_type: &str) -> &str {
    let name = data_type.strip_prefix("IDL:RTC/");
    name.and_then(|name| name.strip_suffix(":1.0"))
        .unwrap_or(data_type)
}

/// A value in messages, within a bound.
fn shown(texts: &[String]) -> String {
    const LONGEST: usize = 40;
    let text = match texts {
        [one] => one.clone(),
        more => format!("[{}]", more.join(", ")),
    };
    match text.char_indices().nth(LONGEST) {
        None => format!("`{text}`"),
        Some((end, _)) => format!("`{}…`", text.get(..end).unwrap_or_default()),
    }
}

/// What is wrong with the recorded data of a stand-in: the port, the problem, and what would be right. Without a port it is
/// about all of them.
pub fn problems(shape: &Shape) -> Vec<(Option<&str>, String, String)> {
    let texts = shape.data.values().flatten().flatten();
    let bytes: usize = texts.map(|text| text.len() + 3).sum();
    if bytes > MAX_BYTES {
        let message = format!("its recorded data has {bytes} bytes");
        return vec![(None, message, format!("at most {MAX_BYTES}, play less"))];
    }
    let data = shape.data.iter();
    data.filter_map(|(port, values)| {
        let (message, help) = at_port(shape, port, values)?;
        Some((Some(port.as_str()), message, help))
    })
    .collect()
}

fn at_port(shape: &Shape, name: &str, values: &[Vec<String>]) -> Option<(String, String)> {
    let out = |port: &&crate::system::PortSpec| {
        port.kind == PortKind::Data && port.direction != Some(Direction::In)
    };
    let Some(port) = shape.ports.iter().find(|port| port.name == name) else {
        let outs = shape.ports.iter().filter(out);
        let outs: Vec<&str> = outs.map(|port| port.name.as_str()).collect();
        let message = "the component has no such port".to_owned();
        return Some((message, suggest::advice(name, "out-ports", &outs)));
    };
    if !out(&port) {
        let kind = match port.kind {
            PortKind::Service => "a service port",
            PortKind::Data => "an in-port",
        };
        let help = "recorded data is sent: name an out-port".to_owned();
        return Some((format!("it is {kind}"), help));
    }
    match (shape.undetermined(name), &port.data_type) {
        (None, Some(data_type)) => problem(data_type, values),
        (why, _) => Some((
            why.unwrap_or("its data type is not known").to_owned(),
            "name the RTC Profile of its type (--rtc), or declare the port in the profile"
                .to_owned(),
        )),
    }
}
