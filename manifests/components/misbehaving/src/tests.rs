//! The component alone, driven as a manager does.

use rts_runtime::ReturnCode;
use rts_runtime::abi::callback;
use rts_runtime::testing::TestHost;

use super::*;

fn host(fault: &str) -> TestHost {
    let mut host = TestHost::of::<Misbehaving>().unwrap();
    host.configure("fault", fault).unwrap();
    host.configure("after", "0").unwrap();
    host
}

#[test]
fn without_a_fault_it_passes_samples_on() {
    let mut host = host("none");
    host.activate().unwrap();
    host.send("in", &TimedLong::now(4));
    host.execute().unwrap();
    assert_eq!(host.take::<TimedLong>("out")[0].data, 4);
}

#[test]
fn it_fails_in_the_callback_that_it_is_told() {
    for (word, number, method) in [
        ("error-initialize", callback::ON_INITIALIZE, "on_initialize"),
        ("error-startup", callback::ON_STARTUP, "on_startup"),
        ("error-activate", callback::ON_ACTIVATED, "on_activated"),
        ("error-execute", callback::ON_EXECUTE, "on_execute"),
        (
            "ignore-deactivate",
            callback::ON_DEACTIVATED,
            "on_deactivated",
        ),
        ("error-abort", callback::ON_ABORTING, "on_aborting"),
        ("error-error", callback::ON_ERROR, "on_error"),
        ("error-reset", callback::ON_RESET, "on_reset"),
        ("error-shutdown", callback::ON_SHUTDOWN, "on_shutdown"),
        ("error-finalize", callback::ON_FINALIZE, "on_finalize"),
        (
            "error-rate-changed",
            callback::ON_RATE_CHANGED,
            "on_rate_changed",
        ),
        (
            "error-state-update",
            callback::ON_STATE_UPDATE,
            "on_state_update",
        ),
    ] {
        let mut host = host(word);
        if number != callback::ON_ACTIVATED {
            host.callback(callback::ON_ACTIVATED).unwrap();
        }
        let failure = host.callback(number).unwrap_err();
        assert_eq!(failure.code, ReturnCode::Error);
        assert_eq!(failure.reason, format!("told to fail {method}"));
    }
}

#[test]
fn what_comes_later_waits_for_its_time() {
    for (word, reason) in [
        ("error-execute", "told to fail on_execute"),
        ("panic", "told to panic in on_execute"),
        // It must come to Error first.
        ("hang-reset", "told to fail on_execute"),
    ] {
        let mut host = host(word);
        host.configure("after", "3600").unwrap();
        host.activate().unwrap();
        host.execute().unwrap();
        host.configure("after", "0").unwrap();
        let failure = host.execute().unwrap_err();
        assert_eq!(failure.code, ReturnCode::Error);
        assert!(failure.reason.ends_with(reason), "{failure}");
    }
}

#[test]
fn an_unknown_fault_names_the_known_ones() {
    let failure = host("sulk").callback(callback::ON_INITIALIZE).unwrap_err();
    assert_eq!(failure.code, ReturnCode::BadParameter);
    let begin = "parameter `fault`: there is no fault `sulk`; there are none, crash-at-once, ";
    assert!(failure.reason.starts_with(begin), "{failure}");
    assert!(failure.reason.ends_with(", grandchildren"), "{failure}");
    let failure = host("none").configure("after", "-1").unwrap_err();
    assert!(failure.reason.contains("from 0"), "{failure}");
}

#[test]
fn a_slow_activation_takes_as_long_as_it_is_told_to() {
    let mut host = host("slow-activate");
    host.configure("seconds", "0.03").unwrap();
    let begin = Instant::now();
    host.activate().unwrap();
    assert!(begin.elapsed() >= Duration::from_millis(30));
}

#[test]
fn a_flood_is_many_samples_and_one_call_of_it_ends() {
    let mut host = host("flood");
    host.activate().unwrap();
    let begin = Instant::now();
    host.execute().unwrap();
    assert!(begin.elapsed() >= FLOOD);
    let sent = host.take::<TimedLong>("out");
    assert!(sent.len() > 100, "{}", sent.len());
}

#[test]
fn a_leak_ends_at_its_limit() {
    let mut host = host("leak");
    host.configure("leak_limit", "3").unwrap();
    host.activate().unwrap();
    for _ in 0..5 {
        host.execute().unwrap();
    }
    let told = host.take_log().join("\n");
    assert_eq!(told.matches("3 MiB have leaked").count(), 1, "{told}");
}

/// Words of `/proc/PID/stat` from the state on.
fn stat(pid: &str) -> Vec<String> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let rest = text.rsplit_once(") ").unwrap().1;
    rest.split(' ').map(str::to_owned).collect()
}

/// Process ids of its children.
fn children(pid: &str) -> Vec<String> {
    let file = format!("/proc/{pid}/task/{pid}/children");
    let text = std::fs::read_to_string(file).unwrap_or_default();
    text.split_whitespace().map(str::to_owned).collect()
}

#[test]
fn grandchildren_ignore_sigterm_and_one_has_a_session_of_its_own() {
    let mut host = host("grandchildren");
    host.activate().unwrap();
    host.activate().unwrap();
    let log = host.take_log().join("\n");
    assert_eq!(log.matches("started processes").count(), 1, "{log}");
    let pids = log.rsplit_once("started processes ").unwrap().1;
    let (beside, away) = pids.trim().split_once(" and ").unwrap();
    for pid in [beside, away] {
        let begin = Instant::now();
        while children(pid).is_empty() {
            assert!(begin.elapsed() < Duration::from_secs(10));
            thread::sleep(Duration::from_millis(2));
        }
        assert_eq!(stat(pid)[3] == pid, pid == away, "its session");
        for pid in children(pid).iter().map(String::as_str).chain([pid]) {
            let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
            let ignored = status.lines().find_map(|l| l.strip_prefix("SigIgn:\t"));
            let ignored = u64::from_str_radix(ignored.unwrap(), 16).unwrap();
            assert_ne!(ignored & 1 << 14, 0, "SIGTERM is ignored");
            let kill = std::process::Command::new("kill")
                .args(["-KILL", pid])
                .status();
            assert!(kill.unwrap().success());
        }
    }
}
