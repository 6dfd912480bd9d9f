//! A callback that does not return is shown by its name after a second, whichever it is and whoever waits for it.

mod support;

use std::thread;
use std::time::{Duration, Instant};

use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use support::*;

/// The request that runs a callback of a component that stands as the callback needs it.
fn prepare(manager: &Running, client: &mut Client, callback: &str) -> Option<RequestBody> {
    let hang = [("hang", callback), ("hang_ms", "60000")];
    let failing = [hang[0], hang[1], ("fail", "on_execute")];
    let instance = callback.to_owned();
    match callback {
        "on_initialize" => return Some(manager.testmod(callback, &hang)),
        "on_error" | "on_reset" => manager.create(callback, &failing),
        _ => manager.create(callback, &hang),
    };
    match callback {
        "on_activated" => return Some(activate(callback)),
        "on_finalize" => return Some(RequestBody::Delete { instance }),
        _ => ok(client, activate(callback)),
    };
    match callback {
        "on_deactivated" => Some(deactivate(callback)),
        "on_reset" => {
            until("it is in Error", || {
                component(client, callback).state == "Error"
            });
            Some(RequestBody::Reset { instance })
        }
        _ => None,
    }
}

#[test]
fn each_callback_that_hangs_is_shown_while_its_request_is_pending() {
    let manager = start("m");
    ok(&mut manager.client(), load_testmod());
    thread::scope(|scope| {
        for callback in [
            "on_initialize",
            "on_activated",
            "on_execute",
            "on_deactivated",
            "on_reset",
            "on_error",
            "on_finalize",
        ] {
            scope.spawn(|| is_shown(&manager, callback));
        }
    });
}

fn is_shown(manager: &Running, callback: &str) {
    let mut client = manager.client();
    let request = prepare(manager, &mut client, callback);
    let begin = Instant::now();
    let pending = request.map(|request| {
        let mut client = manager.client();
        thread::spawn(move || refused(&mut client, request, Duration::from_secs(5)))
    });
    let mut shown = None;
    until("it is shown", || {
        let seen = inventory(&mut client).components;
        let seen = seen.into_iter().find(|c| c.instance == callback);
        shown = seen.and_then(|c| c.busy);
        shown.is_some()
    });
    let (busy, after) = (shown.expect("it was shown"), begin.elapsed());
    assert_eq!(busy.callback, callback);
    assert!(busy.milliseconds >= 1000);
    assert!(after < Duration::from_secs(4), "{callback}: {after:?}");
    if let Some(pending) = pending {
        assert!(!pending.is_finished(), "{callback} was still waited for");
        let failure = pending.join().expect("it is refused");
        assert_eq!(failure.code, FailureCode::Deadline);
        let message = format!("{callback} has been in {callback} for");
        assert!(failure.message.starts_with(&message), "{failure}");
    }
}
