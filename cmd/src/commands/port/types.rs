//! The types of samples: those of OpenRTM-aist, and those of the user's own IDL files.

use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use rts_schemas::cdr::{self, Endian, decode, encode, from_json, to_json};
use rts_schemas::diagnostic::{Report, Severity};
use rts_schemas::idl::{self, Kind, Standard, Type, Unit, standard};
use rts_schemas::suggest;
use serde_json::{Value, json};

use crate::commands::idl::Folders;
use crate::error::CliError;
use crate::exit::Exit;
use crate::input::{read, shown};
use crate::local::plural;
use crate::output::Output;
use crate::show::findings;

/// Repository id of `RTC::Time`.
const TIME: &str = "IDL:RTC/Time:1.0";

/// Where the types of samples are defined.
#[derive(Debug, Clone, clap::Args)]
pub struct TypeArgs {
    /// IDL file with types that are not OpenRTM-aist's (may be repeated)
    #[arg(long = "idl", value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Where included ones are.
    #[command(flatten)]
    folders: Folders,
}

/// The types that are known.
pub struct Types {
    /// The user's own, which win.
    own: Unit,
    standard: Unit,
}

impl Types {
    /// Reads the files. What is found in them is printed; with errors among it this fails.
    pub fn read(args: &TypeArgs, out: &Output) -> Result<Self, CliError> {
        let names: Vec<String> = args.files.iter().map(|path| shown(path)).collect();
        let bytes = args.files.iter().map(|path| read(path));
        let bytes: Vec<Vec<u8>> = bytes.collect::<Result<_, _>>()?;
        let names = names.iter().map(String::as_str);
        let files: Vec<_> = names.zip(bytes.iter().map(Vec::as_slice)).collect();
        let refused = |report: Report| {
            findings::print(&report, out);
            let errors = report.findings.iter();
            let errors = errors.filter(|found| found.severity == Severity::Error);
            CliError::Port {
                message: format!(
                    "the types are not known: {}",
                    plural("error", errors.count())
                ),
                help: None,
                exit: Exit::Invalid,
            }
        };
        let own = idl::read_all(&files, &args.folders).map_err(refused)?;
        findings::print(&own.findings, out);
        let files: Vec<_> = Standard::files()
            .map(|(name, text)| (name, text.as_bytes()))
            .collect();
        let standard = idl::read_all(&files, &standard()).map_err(refused)?;
        Ok(Self {
            own: own.unit,
            standard: standard.unit,
        })
    }

    /// Reads and writes the samples of a port.
    pub fn codec(&self, data_type: &str, port: &str) -> Result<Codec<'_>, CliError> {
        let units = [&self.own, &self.standard].into_iter();
        let mut found = units.filter_map(|unit| Some((unit, unit.find(data_type)?)));
        if let Some((unit, index)) = found.next() {
            return Ok(Codec {
                unit,
                index,
                r#type: Type::Named(index),
            });
        }
        let all = [&self.own, &self.standard].into_iter();
        let ids = all.flat_map(|unit| &unit.definitions);
        let ids = ids.map(|definition| definition.repository_id.as_str());
        let near = suggest::nearest(data_type, ids);
        let near = near.map_or_else(String::new, |near| format!(" (near it is `{near}`)"));
        Err(CliError::usage_help(
            format!("the type {data_type} of {port} is not known{near}"),
            "name the IDL file that defines it: `--idl FILE`",
        ))
    }
}

/// Reads and writes samples of one type.
#[derive(Clone)]
pub struct Codec<'a> {
    unit: &'a Unit,
    index: usize,
    r#type: Type,
}

/// Why bytes or a value are no sample.
#[derive(Debug, thiserror::Error)]
pub enum NotASample {
    /// The bytes are not base64.
    #[error("its bytes are no base64: {0}")]
    Base64(#[from] base64::DecodeError),
    /// They do not fit the type.
    #[error(transparent)]
    Cdr(#[from] cdr::Error),
}

impl Codec<'_> {
    /// One line of JSON for the bytes of a sample, as the API has them.
    pub fn json(&self, data: &str) -> Result<String, NotASample> {
        let bytes = BASE64_STANDARD.decode(data)?;
        let value = decode(self.unit, &self.r#type, &bytes, Endian::Little)?;
        Ok(to_json(self.unit, &self.r#type, &value)?)
    }

    /// The bytes of a sample, as the API takes them.
    pub fn data(&self, value: &Value) -> Result<String, NotASample> {
        let value = from_json(self.unit, &self.r#type, value)?;
        let bytes = encode(self.unit, &self.r#type, &value, Endian::Little)?;
        Ok(BASE64_STANDARD.encode(bytes))
    }

    /// Fills the time of a sample that says none, when its type begins with one as those of OpenRTM-aist do.
    pub fn stamp(&self, value: &mut Value) {
        let Some(definition) = self.unit.definitions.get(self.index) else {
            return;
        };
        let Kind::Struct(it) = &definition.kind else {
            return;
        };
        let is_time = |r#type: &Type| match r#type {
            Type::Named(index) => {
                let of = self.unit.definitions.get(*index);
                of.is_some_and(|of| of.repository_id == TIME)
            }
            _ => false,
        };
        let first = it.members.first();
        let Some(first) = first.filter(|first| first.name == "tm" && is_time(&first.r#type)) else {
            return;
        };
        if let Value::Object(members) = value
            && !members.contains_key(&first.name)
            && let Ok(now) = SystemTime::now().duration_since(UNIX_EPOCH)
        {
            // The type has 32 bits for them.
            let seconds = u32::try_from(now.as_secs()).unwrap_or(u32::MAX);
            let now = json!({"sec": seconds, "nsec": now.subsec_nanos()});
            members.insert(first.name.clone(), now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn types(own: &str) -> Types {
        let read = |files: &[(&str, &[u8])]| idl::read_all(files, &standard()).unwrap().unit;
        let files: Vec<_> = Standard::files()
            .map(|(name, text)| (name, text.as_bytes()))
            .collect();
        Types {
            own: read(&[("own.idl", own.as_bytes())]),
            standard: read(&files),
        }
    }

    #[test]
    fn a_value_comes_back_as_it_went() {
        let types = types("module Lab { struct Mark { string name; sequence<double> at; }; };");
        for (id, text) in [
            (
                "IDL:RTC/TimedDouble:1.0",
                r#"{"tm":{"sec":1,"nsec":2},"data":0.1}"#,
            ),
            ("IDL:Lab/Mark:1.0", r#"{"name":"a","at":[1.0,2.5]}"#),
        ] {
            let codec = types.codec(id, "A.out").unwrap();
            let value: Value = serde_json::from_str(text).unwrap();
            let json = codec.json(&codec.data(&value).unwrap()).unwrap();
            assert_eq!(serde_json::from_str::<Value>(&json).unwrap(), value);
        }
    }

    #[test]
    fn a_time_that_is_not_said_is_that_of_now() {
        let types = types("");
        let codec = types.codec("IDL:RTC/TimedLong:1.0", "A.in").unwrap();
        let mut value = json!({"data": 3});
        codec.stamp(&mut value);
        assert!(value["tm"]["sec"].as_u64() > Some(1_000_000_000), "{value}");
        let said = json!({"tm": {"sec": 0, "nsec": 0}, "data": 3});
        let mut same = said.clone();
        codec.stamp(&mut same);
        assert_eq!(same, said);
        let codec = types.codec("IDL:RTC/Point2D:1.0", "A.in").unwrap();
        let mut untimed = json!({"x": 1.0});
        codec.stamp(&mut untimed);
        assert_eq!(untimed, json!({"x": 1.0}));
    }

    #[test]
    fn what_does_not_fit_tells_its_place() {
        let types = types("");
        let codec = types.codec("IDL:RTC/TimedLong:1.0", "A.in").unwrap();
        let error = codec
            .data(&json!({"data": "three"}))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("TimedLong.data: "), "{error}");
        let error = codec.data(&json!({"date": 3})).unwrap_err().to_string();
        assert!(error.contains("data"), "{error}");
    }

    #[test]
    fn a_type_that_is_not_known_asks_for_its_file() {
        let types = types("");
        let error = match types.codec("IDL:RTC/TimedDoubel:1.0", "Sine0.out") {
            Ok(_) => panic!("it is not there"),
            Err(error) => error,
        };
        assert_eq!(
            error.line(),
            "the type IDL:RTC/TimedDoubel:1.0 of Sine0.out is not known (near it is `IDL:RTC/TimedDouble:1.0`)"
        );
        assert_eq!(error.exit(), Exit::Usage);
        assert!(error.help().unwrap().contains("--idl FILE"));
    }
}
