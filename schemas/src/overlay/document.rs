//! What an overlay can say, key by key.

use serde_json::{Value as Json, json};

use crate::diagnostic::Finding;
use crate::names::NAME_LIMIT;
use crate::placement::{NodeName, Settings, Value, milliseconds, spelled_time, time_schema};
use crate::system::{NO_SEQUENCE, SendingTiming};
use crate::yaml_type::{List, Map, Scalar, Words, yaml_type};

/// Value of `apiVersion`.
pub const API_VERSION: &str = "rtsctl.dev/v1";

/// Value of `kind`.
pub const KIND: &str = "Deployment";

yaml_type! {
    /// A deployment overlay: where and how the components of a profile run, said beside a profile that stays untouched.
    pub struct Deployment {
        /// Version of this format.
        api_version: ApiVersion = "apiVersion" required;
        /// Kind of this file.
        kind: Kind = "kind" required;
        /// About the file itself.
        metadata: Metadata = "metadata";
        /// What is said.
        spec: DeploymentSpec = "spec" required;
    }
}

yaml_type! {
    /// About the file itself.
    pub struct Metadata {
        /// Name of the overlay, for display.
        name: Value = "name";
    }
}

yaml_type! {
    /// What is said of the components of a system. Where several parts speak of one component, the nearer wins key by key:
    /// `components` by name, `types` by name, `components` by glob, `types` by glob, `hosts`, `defaults`. Of several
    /// globs the last one wins, and of several files.
    pub struct DeploymentSpec {
        /// Said of every component.
        defaults: Settings = "defaults";
        /// Node for each host that the profile names (host of `pathUri`, else of the IOR).
        hosts: Map<NodeName> = "hosts";
        /// Said of the components of a type, by its name or a glob (`*`, `?`).
        types: Map<Settings> = "types";
        /// Said of a component, by its instance name or a glob (`*`, `?`).
        components: Map<Settings> = "components";
        /// Orders beside those of the profile.
        order: Order = "order";
    }
}

yaml_type! {
    /// Orders beside those of the profile. They are obeyed as if the profile had them.
    pub struct Order {
        /// When components are created.
        start_up: List<Rule> = "startUp";
        /// When components are deleted.
        shut_down: List<Rule> = "shutDown";
        /// When components are activated.
        activation: List<Rule> = "activation";
        /// When components are deactivated.
        deactivation: List<Rule> = "deactivation";
        /// When components are reset.
        resetting: List<Rule> = "resetting";
        /// When components are initialised.
        initializing: List<Rule> = "initializing";
        /// When components are finalised.
        finalizing: List<Rule> = "finalizing";
    }
}

yaml_type! {
    /// When some components have their turn.
    pub struct Rule {
        /// The components that the rule is about.
        component: List<Selector> = "component" required;
        /// Components that go before them.
        after: List<Selector> = "after";
        /// Components that go after them.
        before: List<Selector> = "before";
        /// Whether `after` and `before` wait until the others are in the state, or only until they were told.
        timing: SendingTiming = "timing";
        /// Time after which `after` and `before` are not waited for any more; none for no time-out of its own.
        timeout: WaitTime = "timeout";
        /// Time to sleep before.
        wait: WaitTime = "wait";
        /// Place among the sequence numbers of the profile: lower ones go first.
        sequence: Sequence = "sequence";
    }
}

/// `rtsctl.dev/v1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ApiVersion;

/// `Deployment`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind;

/// Instance name or glob.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selector(pub String);

/// Milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WaitTime(pub u32);

/// Sequence number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sequence(pub u32);

macro_rules! constant {
    ($name:ident, $value:expr) => {
        impl Scalar for $name {
            const EXPECTED: &'static str = $value;

            fn parse(text: &str) -> Option<Self> {
                (text == $value).then_some(Self)
            }

            fn spelled(&self) -> String {
                $value.to_owned()
            }

            fn schema() -> Json {
                json!({"const": $value})
            }

            fn fault(key: &str, text: &str) -> Finding {
                let message = format!("`{key}` is `{text}`, this program reads `{}`", $value);
                Finding::error("wrong-kind", message).help(format!("write `{key}: {}`", $value))
            }
        }
    };
}

constant!(ApiVersion, API_VERSION);
constant!(Kind, KIND);

impl Scalar for Selector {
    const EXPECTED: &'static str = "an instance name, or a glob of `*` and `?`";

    fn parse(text: &str) -> Option<Self> {
        let fits = (1..=NAME_LIMIT).contains(&text.len()) && !text.chars().any(char::is_control);
        fits.then(|| Self(text.to_owned()))
    }

    fn spelled(&self) -> String {
        self.0.clone()
    }

    fn schema() -> Json {
        json!({"type": "string", "minLength": 1, "maxLength": NAME_LIMIT})
    }
}

impl Scalar for WaitTime {
    const EXPECTED: &'static str =
        "a time from 1 ms to 24 h with its unit, such as `500ms` or `2s`";

    fn parse(text: &str) -> Option<Self> {
        const DAY: u64 = 24 * 60 * 60 * 1000;
        let ms = milliseconds(text).filter(|ms| (1..=DAY).contains(ms));
        ms.and_then(|ms| u32::try_from(ms).ok()).map(Self)
    }

    fn spelled(&self) -> String {
        spelled_time(self.0.into())
    }

    fn schema() -> Json {
        time_schema()
    }
}

impl Scalar for Sequence {
    const EXPECTED: &'static str = "a whole number from 0 to 2147483646";

    fn parse(text: &str) -> Option<Self> {
        let number = text.parse().ok();
        number.filter(|number| *number < NO_SEQUENCE).map(Self)
    }

    fn spelled(&self) -> String {
        self.0.to_string()
    }

    fn schema() -> Json {
        json!({"type": "integer", "minimum": 0, "maximum": NO_SEQUENCE - 1})
    }

    fn write(&self) -> Json {
        self.0.into()
    }
}

impl Words for SendingTiming {
    const ALL: &'static [Self] = &[Self::Sync, Self::Async];
    const EXPECTED: &'static str = "`sync` or `async`";

    fn word(self) -> &'static str {
        match self {
            Self::Sync => "sync",
            Self::Async => "async",
        }
    }
}

impl Scalar for SendingTiming {
    const EXPECTED: &'static str = <Self as Words>::EXPECTED;

    fn parse(text: &str) -> Option<Self> {
        Self::of_word(text)
    }

    fn spelled(&self) -> String {
        self.word().to_owned()
    }

    fn schema() -> Json {
        Self::schema_of_words()
    }
}
