//! Reading connector properties; every fault is found.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::cdr::Endian;

use super::{
    BufferSettings, ConnectorSettings, DEFAULT_LENGTH, DEFAULT_TIMEOUT, Dataflow, EmptyPolicy,
    FullPolicy, HIGHEST_RATE, Interface, LONGEST_BUFFER, LONGEST_TIMEOUT, LOWEST_RATE, PushPolicy,
    Subscription,
};
use crate::suggest;

/// A value that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{property}`: {problem}")]
pub struct Fault {
    /// Code of the finding.
    pub code: &'static str,
    /// Name of the property.
    pub property: String,
    /// What is wrong with it.
    pub problem: String,
    /// How to mend it.
    pub help: String,
}

/// What the properties of a data connector say, by their OpenRTM names; all that cannot be used is said instead.
///
/// Names that are not known stand for nothing here, and so do unknown words for `dataport.interface_type`: other
/// middleware has more of them, and all mean that the samples are to arrive.
pub fn read(properties: &BTreeMap<String, String>) -> Result<ConnectorSettings, Vec<Fault>> {
    let mut reader = Reader {
        properties,
        faults: Vec::new(),
    };
    let subscription = reader.subscription();
    let settings = ConnectorSettings {
        dataflow: reader.dataflow(),
        subscription,
        interface: match reader.word("dataport.interface_type").as_str() {
            "direct" | "inproc" => Interface::Direct,
            "shared_memory" | "shm" => Interface::SharedMemory,
            "uds" => Interface::Unix,
            "tcp" => Interface::Tcp,
            _ => Interface::Best,
        },
        endian: reader.endian(),
        out_buffer: reader.buffer("outport"),
        in_buffer: reader.buffer("inport"),
    };
    if reader.faults.is_empty() {
        Ok(settings)
    } else {
        Err(reader.faults)
    }
}

struct Reader<'a> {
    properties: &'a BTreeMap<String, String>,
    faults: Vec<Fault>,
}

impl<'a> Reader<'a> {
    /// The first of these properties that says something, and its value in small letters.
    fn first(&self, names: &[String]) -> Option<(String, String)> {
        let said = |name: &String| {
            let value: &'a String = self.properties.get(name)?;
            let value = value.trim().to_ascii_lowercase();
            (!value.is_empty()).then(|| (name.clone(), value))
        };
        names.iter().find_map(said)
    }

    /// A property's value in small letters; empty when it says nothing.
    fn word(&self, name: &str) -> String {
        self.first(&[name.to_owned()])
            .map_or_else(String::new, |(_, value)| value)
    }

    /// The first that is named and known of a list: each end of OpenRTM-aist offers those that it knows, the best first.
    fn endian(&self) -> Endian {
        let words = self.word("dataport.serializer.cdr.endian");
        let known = words.split(',').find_map(|word| match word.trim() {
            "little" => Some(Endian::Little),
            "big" => Some(Endian::Big),
            _ => None,
        });
        known.unwrap_or(Endian::Little)
    }

    fn fault(&mut self, code: &'static str, property: &str, what: &str, help: impl Into<String>) {
        self.faults.push(Fault {
            code,
            property: property.to_owned(),
            problem: what.to_owned(),
            help: help.into(),
        });
    }

    /// What one of the three choices says: of a list, as ports have them, the first word that is known.
    fn choice(&mut self, name: &str, kind: &str, known: &[&'static str]) -> &'static str {
        let said = self.word(name);
        let mut words = said.split(',').map(str::trim);
        let found = words.find_map(|word| known.iter().find(|known| **known == word));
        if found.is_none() && !said.is_empty() {
            self.unknown_policy(name, &said, kind, known);
        }
        found.copied().unwrap_or_default()
    }

    fn dataflow(&mut self) -> Dataflow {
        // OpenRTM 2 has connectors of both ways, whose samples are pushed.
        let known = ["push", "pull", "duplex"];
        match self.choice("dataport.dataflow_type", "a dataflow type", &known) {
            "pull" => Dataflow::Pull,
            _ => Dataflow::Push,
        }
    }

    fn subscription(&mut self) -> Subscription {
        // As OpenRTM has it: what is said of one end alone goes before what is said of both.
        let policy = self.push_policy();
        let known = ["flush", "new", "periodic", "block", "nonblock"];
        match self.choice("dataport.subscription_type", "a subscription type", &known) {
            "new" | "nonblock" => Subscription::New(policy),
            "periodic" => Subscription::Periodic {
                period: self.period(),
                policy,
            },
            _ => Subscription::Flush,
        }
    }

    fn push_policy(&mut self) -> PushPolicy {
        let skip = self.skip_count();
        let Some((name, value)) = self.first(&publisher("push_policy")) else {
            return PushPolicy::New;
        };
        match value.as_str() {
            "all" => PushPolicy::All,
            "fifo" => PushPolicy::Fifo,
            "skip" => PushPolicy::Skip(skip),
            "new" => PushPolicy::New,
            _ => {
                let known = ["all", "fifo", "skip", "new"];
                self.unknown_policy(&name, &value, "a push policy", &known);
                PushPolicy::New
            }
        }
    }

    fn unknown_policy(&mut self, name: &str, value: &str, kind: &str, known: &[&str]) {
        let what = format!("`{value}` is not {kind}");
        let help = suggest::advice(value, "known", known);
        self.fault("unknown-policy", name, &what, help);
    }

    fn skip_count(&mut self) -> u32 {
        let Some((name, value)) = self.first(&publisher("skip_count")) else {
            return 0;
        };
        value.parse().unwrap_or_else(|_| {
            let what = format!("`{value}` is no number of samples to pass over");
            let help = "write a whole number, 0 or more";
            self.fault("bad-skip-count", &name, &what, help);
            0
        })
    }

    /// Of a periodic connector. OpenRTM refuses one without a rate, too.
    fn period(&mut self) -> Duration {
        let mut names = publisher("push_rate").to_vec();
        names.push("dataport.push_rate".to_owned());
        const FALLBACK: Duration = Duration::from_millis(10);
        let number = |value: &str| value.parse::<f64>().ok().filter(|n| n.is_finite());
        let (name, value, rate) = if let Some((name, value)) = self.first(&names) {
            let rate = number(&value);
            (name, value, rate)
        } else if let Some((name, value)) = self.first(&["dataport.push_interval".to_owned()]) {
            let rate = number(&value).map(f64::recip);
            (name, value, rate)
        } else {
            let help = "write it in hertz, such as `100.0`, or give `pushInterval` in seconds";
            let what = "a periodic connector needs a rate";
            self.fault("bad-push-rate", "dataport.publisher.push_rate", what, help);
            return FALLBACK;
        };
        let period = rate
            .filter(|rate| (LOWEST_RATE..=HIGHEST_RATE).contains(rate))
            .and_then(|rate| Duration::try_from_secs_f64(rate.recip()).ok());
        period.unwrap_or_else(|| {
            let what = format!("`{value}` is no rate of a periodic connector");
            let help = format!(
                "write a number of hertz from {LOWEST_RATE} to {HIGHEST_RATE}; `dataport.push_interval` is in seconds"
            );
            self.fault("bad-push-rate", &name, &what, help);
            FALLBACK
        })
    }

    fn buffer(&mut self, end: &str) -> BufferSettings {
        let names = |key: &str| {
            [
                format!("dataport.{end}.buffer.{key}"),
                format!("dataport.buffer.{key}"),
            ]
        };
        let length = self.length(&names("length"));
        let write_timeout = self.timeout(&names("write.timeout"));
        let read_timeout = self.timeout(&names("read.timeout"));
        let full = match self.first(&names("write.full_policy")) {
            None => FullPolicy::Overwrite,
            Some((name, value)) => match value.as_str() {
                "overwrite" => FullPolicy::Overwrite,
                "do_nothing" => FullPolicy::DoNothing,
                "block" => FullPolicy::Block(write_timeout),
                _ => {
                    let known = ["overwrite", "do_nothing", "block"];
                    self.unknown_policy(&name, &value, "a policy of a full buffer", &known);
                    FullPolicy::Overwrite
                }
            },
        };
        let empty = match self.first(&names("read.empty_policy")) {
            None => EmptyPolicy::DoNothing,
            Some((name, value)) => match value.as_str() {
                "readback" => EmptyPolicy::Readback,
                "do_nothing" => EmptyPolicy::DoNothing,
                "block" => EmptyPolicy::Block(read_timeout),
                _ => {
                    let known = ["readback", "do_nothing", "block"];
                    self.unknown_policy(&name, &value, "a policy of an empty buffer", &known);
                    EmptyPolicy::DoNothing
                }
            },
        };
        BufferSettings {
            length,
            full,
            empty,
            read_timeout,
        }
    }

    fn length(&mut self, names: &[String]) -> usize {
        let Some((name, value)) = self.first(names) else {
            return DEFAULT_LENGTH;
        };
        let length = value.parse().ok();
        length
            .filter(|length| (1..=LONGEST_BUFFER).contains(length))
            .unwrap_or_else(|| {
                let what = format!("`{value}` is no length of a buffer");
                let help = format!("write a whole number from 1 to {LONGEST_BUFFER}");
                self.fault("bad-buffer-length", &name, &what, help);
                DEFAULT_LENGTH
            })
    }

    fn timeout(&mut self, names: &[String]) -> Duration {
        let Some((name, value)) = self.first(names) else {
            return DEFAULT_TIMEOUT;
        };
        let seconds = value.parse().ok();
        let time = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        match time.filter(|time| *time <= LONGEST_TIMEOUT) {
            Some(Duration::ZERO) => LONGEST_TIMEOUT,
            Some(time) => time,
            None => {
                let what = format!("`{value}` is no time-out");
                let longest = LONGEST_TIMEOUT.as_secs();
                let help = format!(
                    "write seconds up to {longest}, such as `0.5`; `0` stands for the longest"
                );
                self.fault("bad-timeout", &name, &what, help);
                DEFAULT_TIMEOUT
            }
        }
    }
}

/// What a publisher's property may be called.
fn publisher(key: &str) -> [String; 2] {
    [
        format!("dataport.outport.publisher.{key}"),
        format!("dataport.publisher.{key}"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn properties(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
        let own = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        pairs.iter().map(own).collect()
    }

    fn settings(pairs: &[(&str, &str)]) -> ConnectorSettings {
        read(&properties(pairs)).unwrap()
    }

    fn faults(pairs: &[(&str, &str)]) -> Vec<(&'static str, String)> {
        let faults = read(&properties(pairs)).unwrap_err();
        faults
            .into_iter()
            .map(|fault| {
                assert!(fault.to_string().contains(&fault.property), "{fault}");
                (fault.code, fault.property)
            })
            .collect()
    }

    #[test]
    fn nothing_said_is_a_queue_of_64_that_drops_its_oldest() {
        assert_eq!(settings(&[]), ConnectorSettings::default());
        // What real profiles mostly say.
        let usual = settings(&[
            ("dataport.interface_type", "corba_cdr"),
            ("dataport.dataflow_type", "push"),
            ("dataport.subscription_type", "new"),
            ("dataport.serializer.cdr.endian", "little,big"),
            ("dataport.inport", ""),
        ]);
        assert_eq!(usual.subscription, Subscription::New(PushPolicy::New));
        assert_eq!(usual.endian, Endian::Little);
        let endian = |words| settings(&[("dataport.serializer.cdr.endian", words)]).endian;
        assert_eq!(endian(" Big,little"), Endian::Big);
        assert_eq!(endian("middle"), Endian::Little);
        assert_eq!(usual.out_buffer, BufferSettings::default());
    }

    #[test]
    fn words_come_in_any_case_and_other_middleware_is_passed_over() {
        let read = settings(&[
            ("dataport.interface_type", " Shared_Memory"),
            ("dataport.dataflow_type", "Pull"),
            ("dataport.subscription_type", "PERIODIC"),
            ("dataport.publisher.push_policy", "Skip"),
            ("dataport.publisher.skip_count", "3"),
            ("dataport.push_rate", "50"),
        ]);
        assert_eq!(read.interface, Interface::SharedMemory);
        assert_eq!(read.dataflow, Dataflow::Pull);
        let period = Duration::from_millis(20);
        let policy = PushPolicy::Skip(3);
        assert_eq!(read.subscription, Subscription::Periodic { period, policy });
        let other = settings(&[("dataport.interface_type", "ros2")]);
        assert_eq!(other, ConnectorSettings::default());
    }

    #[test]
    fn an_interval_in_seconds_is_a_rate_too_and_the_rate_wins() {
        let base = ("dataport.subscription_type", "periodic");
        let period = |pairs: &[(&str, &str)]| {
            let pairs = [&[base], pairs].concat();
            match settings(&pairs).subscription {
                Subscription::Periodic { period, .. } => period,
                other => panic!("{other:?}"),
            }
        };
        let interval = ("dataport.push_interval", "0.5");
        assert_eq!(period(&[interval]), Duration::from_millis(500));
        let rate = ("dataport.publisher.push_rate", "100");
        assert_eq!(period(&[interval, rate]), Duration::from_millis(10));
    }

    #[test]
    fn each_end_has_its_buffer_or_that_of_both() {
        let read = settings(&[
            ("dataport.buffer.length", "8"),
            ("dataport.buffer.write.full_policy", "block"),
            ("dataport.buffer.write.timeout", "0.25"),
            ("dataport.inport.buffer.length", "1"),
            ("dataport.inport.buffer.write.full_policy", "do_nothing"),
            ("dataport.inport.buffer.read.empty_policy", "block"),
            ("dataport.inport.buffer.read.timeout", "0"),
        ]);
        let quarter = Duration::from_millis(250);
        assert_eq!(read.out_buffer.length, 8);
        assert_eq!(read.out_buffer.full, FullPolicy::Block(quarter));
        assert_eq!(read.out_buffer.empty, EmptyPolicy::DoNothing);
        assert_eq!(read.in_buffer.length, 1);
        assert_eq!(read.in_buffer.full, FullPolicy::DoNothing);
        assert_eq!(read.in_buffer.empty, EmptyPolicy::Block(LONGEST_TIMEOUT));
    }

    #[test]
    fn every_fault_is_found_and_names_its_property() {
        let found = faults(&[
            ("dataport.subscription_type", "periodic"),
            ("dataport.dataflow_type", "pushed"),
            ("dataport.publisher.push_policy", "newest"),
            ("dataport.publisher.skip_count", "-1"),
            ("dataport.publisher.push_rate", "0"),
            ("dataport.outport.buffer.length", "0"),
            ("dataport.inport.buffer.length", "100000000"),
            ("dataport.outport.buffer.write.timeout", "-1"),
            ("dataport.inport.buffer.read.timeout", "soon"),
            ("dataport.inport.buffer.write.full_policy", "wait"),
            ("dataport.inport.buffer.read.empty_policy", "last"),
        ]);
        let codes: Vec<_> = found.iter().map(|(code, _)| *code).collect();
        let count = |code: &str| codes.iter().filter(|c| **c == code).count();
        assert_eq!(count("unknown-policy"), 4, "{found:?}");
        assert_eq!(count("bad-buffer-length"), 2, "{found:?}");
        assert_eq!(count("bad-timeout"), 2, "{found:?}");
        assert_eq!(
            (count("bad-push-rate"), count("bad-skip-count")),
            (1, 1),
            "{found:?}"
        );
        assert_eq!(
            faults(&[("dataport.subscription_type", "perodic")]),
            [("unknown-policy", "dataport.subscription_type".to_owned())]
        );
        assert_eq!(
            faults(&[("dataport.subscription_type", "periodic")]),
            [("bad-push-rate", "dataport.publisher.push_rate".to_owned())]
        );
    }

    proptest! {
        #[test]
        fn whatever_is_written_settings_are_within_their_bounds(
            length in ".{0,6}", number in prop_oneof![".{0,6}", "-?[0-9.e]{1,8}"], word in "[a-z_]{0,10}",
        ) {
            let pairs = [
                ("dataport.subscription_type", "periodic"),
                ("dataport.buffer.length", &length),
                ("dataport.buffer.write.timeout", &number),
                ("dataport.push_interval", &number),
                ("dataport.buffer.write.full_policy", &word),
            ];
            if let Ok(settings) = read(&properties(&pairs)) {
                prop_assert!((1..=LONGEST_BUFFER).contains(&settings.in_buffer.length));
                prop_assert!(settings.in_buffer.read_timeout <= LONGEST_TIMEOUT);
                let Subscription::Periodic { period, .. } = settings.subscription else {
                    return Err(TestCaseError::fail("not periodic"));
                };
                prop_assert!(period > Duration::ZERO && period <= Duration::from_hours(2));
            }
        }
    }
}
