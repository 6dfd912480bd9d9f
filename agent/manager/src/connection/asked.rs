//! Requests that were asked at once: one thread begins them all, waits for all, and answers together what ends together.
//! Each is answered as soon as it has ended, whatever becomes of the others.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::Instant;

use rts_manager_api::control::{Failure, RequestBody, ResponseBody};

use super::Connection;
use crate::failure::internal;
use crate::requests::{self, Begun, Waits};
use crate::server::Shared;

/// A request.
pub(super) struct Asked {
    /// Its number.
    pub id: u64,
    /// What is to be done.
    pub body: RequestBody,
    /// Until when it is to be answered.
    pub deadline: Instant,
}

type Answer = (u64, Result<ResponseBody, Failure>);

/// Carries them out in their order, as far as each is begun before the next, and answers.
pub(super) fn answer(asked: Vec<Asked>, connection: &Connection, shared: &Shared) {
    let ends = asked
        .iter()
        .any(|asked| asked.body == RequestBody::Shutdown);
    let (mut waiting, mut answers) = (Vec::new(), Vec::new());
    for asked in asked {
        let id = asked.id;
        match begin(asked, shared) {
            Ok(Begun::Done(answer)) => answers.push((id, Ok(answer))),
            Ok(Begun::Waits(waits)) => waiting.push((id, waits)),
            Err(failure) => answers.push((id, Err(failure))),
        }
    }
    loop {
        take_ended(&mut waiting, &mut answers);
        if !answers.is_empty() {
            connection.respond_all(std::mem::take(&mut answers));
        }
        let next = waiting.iter().map(|(_, waits)| waits.deadline()).min();
        let Some(next) = next else { break };
        // Also woken for nothing now and then, and by what was looked at already.
        thread::park_timeout(next.saturating_duration_since(Instant::now()));
    }
    if ends {
        shared.end();
    }
}

/// Carries them out one after the other, and answers each before the next.
pub(super) fn answer_each(asked: Vec<Asked>, connection: &Connection, shared: &Shared) {
    for one in asked {
        answer(vec![one], connection, shared);
    }
}

/// Begins one; a fault of ours is answered.
fn begin(asked: Asked, shared: &Shared) -> Result<Begun, Failure> {
    let Asked { body, deadline, .. } = asked;
    let waker = Some(thread::current());
    let begun = catch_unwind(AssertUnwindSafe(|| {
        requests::begin(&shared.manager, body, deadline, waker)
    }));
    begun.unwrap_or_else(|_| {
        Err(internal(
            "the manager failed at this request; its log says where",
        ))
    })
}

/// Moves the answers out that are there.
fn take_ended(waiting: &mut Vec<(u64, Waits)>, answers: &mut Vec<Answer>) {
    waiting.retain(|(id, waits)| match waits.look() {
        Some(result) => {
            answers.push((*id, result));
            false
        }
        None => true,
    });
}
