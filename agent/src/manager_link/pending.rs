//! Requests on their way: numbered when they are sent, and answered by their number.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use rts_manager_api::control::{
    Failure, FailureCode, Request, RequestBody, Response, ResponseBody,
};
use rts_manager_api::frame;
use tokio::sync::oneshot;
use tokio::time::Instant;

use super::LinkError;
use crate::events::lock;

/// A request and the one who waits for its answer.
pub(super) struct Call {
    pub body: RequestBody,
    pub deadline: Instant,
    pub answer: oneshot::Sender<Result<ResponseBody, LinkError>>,
}

/// Those who wait for an answer, by request id.
pub(super) type Waiting = Mutex<BTreeMap<u64, oneshot::Sender<Result<ResponseBody, LinkError>>>>;

/// Requests that were sent and not answered.
#[derive(Default)]
pub(super) struct Pending {
    next_id: u64,
    pub waiting: Arc<Waiting>,
}

impl Pending {
    /// Fails all calls that wait.
    pub fn fail(&self, error: &LinkError) {
        let waiting = std::mem::take(&mut *lock(&self.waiting));
        for answer in waiting.into_values() {
            // The caller may have given up.
            let _ = answer.send(Err(error.clone()));
        }
    }

    /// Remembers a call and encodes its request in a version of the protocol; none when nobody waits for it any more or it cannot be encoded.
    pub fn note(&mut self, call: Call, version: u32) -> Option<Vec<u8>> {
        // What waited for the connection has less time left; without any it could only come too late.
        let left = call.deadline.saturating_duration_since(Instant::now());
        if call.answer.is_closed() || left.is_zero() {
            return None;
        }
        let id = self.next_id;
        self.next_id += 1;
        let request = Request {
            id,
            deadline_ms: left.as_millis().max(1).try_into().unwrap_or(u64::MAX),
            body: call.body.for_version(version),
        };
        match frame::encode(&request) {
            Ok(bytes) => {
                let mut waiting = lock(&self.waiting);
                waiting.retain(|_, answer| !answer.is_closed());
                waiting.insert(id, call.answer);
                Some(bytes)
            }
            Err(e) => {
                let failure = Failure {
                    code: FailureCode::Invalid,
                    message: format!("the request cannot be sent: {e}"),
                };
                let _ = call.answer.send(Err(failure.into()));
                None
            }
        }
    }
}

/// Gives an answer to whoever waits for it.
pub(super) fn settle(waiting: &Waiting, response: Response) {
    if let Some(answer) = lock(waiting).remove(&response.id) {
        // The caller may have given up.
        let _ = answer.send(response.result.map_err(LinkError::from));
    }
}
