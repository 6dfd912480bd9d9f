//! Events: a bounded log of what happened.

use jiff::Timestamp;
use rts_agent_api::session::AgentEvent;
use rts_controller_api::API_VERSION;
use rts_controller_api::objects::{Event, EventStatus, EventView, Kind, Metadata};

/// Longest message that is kept, in bytes.
const MAX_MESSAGE: usize = 2048;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Happening {
    view: EventView,
}

impl Happening {
    /// As it should go.
    pub fn normal(reason: &str, object: &str, message: impl Into<String>) -> Self {
        Self::new("Normal", reason, object, message.into())
    }

    /// Something went wrong.
    pub fn warning(reason: &str, object: &str, message: impl Into<String>) -> Self {
        Self::new("Warning", reason, object, message.into())
    }

    /// The same, of a system.
    #[must_use]
    pub fn of(mut self, system: Option<&str>) -> Self {
        self.view.system = system.unwrap_or_default().to_owned();
        self
    }

    fn new(kind: &str, reason: &str, object: &str, mut message: String) -> Self {
        message.truncate(message.floor_char_boundary(MAX_MESSAGE));
        let view = EventView {
            system: String::new(),
            kind: kind.to_owned(),
            reason: reason.to_owned(),
            object: object.to_owned(),
            message,
        };
        Self { view }
    }

    pub(super) fn into_event(self, revision: u64, now: Timestamp) -> Event {
        let name = format!("event-{revision}");
        Event {
            api_version: API_VERSION.to_owned(),
            kind: Kind::Event,
            metadata: Metadata {
                uid: name.clone(),
                name,
                resource_version: revision.to_string(),
                creation_timestamp: Some(now),
                ..Metadata::default()
            },
            spec: self.view,
            status: EventStatus { time: Some(now) },
        }
    }
}

impl From<AgentEvent> for Happening {
    fn from(event: AgentEvent) -> Self {
        let kind = if event.kind == "Warning" {
            "Warning"
        } else {
            "Normal"
        };
        Self::new(kind, &event.reason, &event.object, event.message).of(event.system.as_deref())
    }
}
