//! Modules in a real manager process: those that hang in dlopen, and those that change on disk.

#[path = "modules/in_c.rs"]
mod in_c;
mod support;

use std::time::{Duration, Instant};

use rts_manager_api::control::*;
use support::*;

#[test]
fn a_module_that_hangs_in_dlopen_costs_one_thread_and_does_not_keep_the_manager_from_ending() {
    let mut manager = start_with("m", &[("TESTMOD_INIT_MS", "600000")]);
    let mut client = manager.client();
    let threads = || {
        let tasks = format!("/proc/{}/task", manager.child.id());
        std::fs::read_dir(tasks).unwrap().count()
    };
    for _ in 0..100 {
        let failure = refused(&mut client, load_testmod(), Duration::from_millis(10));
        assert_eq!(failure.code, FailureCode::Deadline);
        assert!(
            failure
                .message
                .contains("libtestmod.so has been in dlopen for"),
            "{failure}"
        );
    }
    assert!(threads() < 16, "{}", threads());
    // Others are served, new ones too: threads are ready for them, which could not be started now.
    let mut client = manager.client();
    assert_eq!(
        refused(&mut client, manager.testmod("A", &[]), SOON).code,
        FailureCode::NotFound
    );
    let begin = Instant::now();
    ok(&mut client, RequestBody::Shutdown);
    assert_eq!(manager.wait().code(), Some(0));
    assert!(begin.elapsed() < SOON);
}

#[test]
fn another_file_at_the_path_of_a_module_is_refused_instead_of_giving_its_old_code() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("libtestmod.so");
    std::fs::copy(built("libtestmod.so"), &path).unwrap();
    let manager = start("m");
    let mut client = manager.client();
    let load = || RequestBody::LoadModule {
        type_name: "Testmod".to_owned(),
        path: path.display().to_string(),
        digest: None,
    };
    let unload = || RequestBody::UnloadModule {
        type_name: "Testmod".to_owned(),
    };
    ok(&mut client, load());
    ok(&mut client, unload());
    ok(&mut client, load());
    std::fs::remove_file(&path).unwrap();
    std::fs::copy(built("libtestmod.so"), &path).unwrap();
    for _ in 0..2 {
        let failure = refused(&mut client, load(), SOON);
        assert_eq!(failure.code, FailureCode::LoadFailed);
        assert!(
            failure.message.ends_with("restart this manager"),
            "{failure}"
        );
        ok(&mut client, unload());
    }
}

#[test]
fn an_instance_that_is_a_null_pointer_is_refused() {
    let manager = start_with("m", &[("TESTMOD_NULL_INSTANCE", "1")]);
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let failure = refused(&mut client, manager.testmod("A", &[]), SOON);
    assert_eq!(failure.code, FailureCode::ComponentFailed);
    assert_eq!(
        failure.message,
        "A: create returned RTC_OK without an instance"
    );
}
