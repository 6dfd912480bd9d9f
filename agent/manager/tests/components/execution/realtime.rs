//! Priority and processors of execution contexts.

use rts_manager_api::control::*;

use super::driven;
use super::shared::{create, delete, shared};
use crate::support::*;

/// A request for a Testmod whose execution context is to have this.
fn with(manager: &Running, instance: &str, asked: RealtimeRequest) -> RequestBody {
    match driven(manager, instance, "periodic", &[]) {
        RequestBody::Create(request) => RequestBody::Create(CreateRequest {
            realtime: Some(asked),
            ..request
        }),
        other => panic!("{other:?}"),
    }
}

/// Policy and priority of the thread of a component, as the kernel has them.
fn kernel(manager: &Running, instance: &str) -> (u32, u32) {
    let tasks = format!("/proc/{}/task", manager.child.id());
    let tasks = std::fs::read_dir(tasks).expect("it is there");
    let mut stats =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok());
    let stat = stats.find(|stat| stat.contains(&format!("({instance})")));
    let stat = stat.expect("it is there");
    let fields: Vec<&str> = stat
        .rsplit_once(") ")
        .expect("it is there")
        .1
        .split(' ')
        .collect();
    // The 40th and 41st of proc_pid_stat(5), of which the name is the second.
    (
        fields[38].parse().expect("it is there"),
        fields[37].parse().expect("it is there"),
    )
}

#[test]
fn an_execution_context_is_on_sched_fifo_or_the_machine_says_why_not() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let asked = RealtimeRequest {
        priority: Some(7),
        required: true,
        ..RealtimeRequest::default()
    };
    match client.call(with(&manager, "A", asked.clone()), SOON) {
        Ok(_) => {
            let found = component(&mut client, "A").realtime.unwrap();
            assert_eq!(
                (found.scheduler.as_str(), found.priority),
                ("SCHED_FIFO", 7)
            );
            assert_eq!((found.asked, found.denied), (asked, vec![]));
            assert_eq!(kernel(&manager, "A"), (1, 7));
        }
        Err(refused) => {
            let message = refused.to_string();
            for said in [
                "A cannot have SCHED_FIFO priority 7",
                "start its agent",
                "required: false",
            ] {
                assert!(message.contains(said), "{message}");
            }
            assert_eq!(inventory(&mut client).components, []);
        }
    }
    // One beside it has nothing of its own.
    manager.create("B", &[]);
    assert_eq!(component(&mut client, "B").realtime, None);
    assert_eq!(kernel(&manager, "B"), (0, 0));
}

#[test]
fn a_processor_that_is_not_there_is_refused_or_told() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let asked = |required| RealtimeRequest {
        cpus: Some("1023".to_owned()),
        required,
        ..RealtimeRequest::default()
    };
    let failure = refused(&mut client, with(&manager, "A", asked(true)), SOON);
    let why = "cannot run on the processors 1023 (resources.cpus): none of them is there";
    assert!(
        failure.message.starts_with(&format!("A {why}")),
        "{failure}"
    );
    assert_eq!(failure.code, FailureCode::ComponentFailed);
    assert_eq!(inventory(&mut client).components, []);

    ok(&mut client, with(&manager, "A", asked(false)));
    ok(&mut client, activate("A"));
    let found = component(&mut client, "A").realtime.unwrap();
    assert!(found.denied[0].starts_with(why), "{:?}", found.denied);
    assert_ne!(found.cpus, "");
    assert!(manager.log("A").contains(why), "{}", manager.log("A"));
}

/// Components of one thread cannot have different ones; what one asked for is let go with it.
#[test]
fn those_that_share_an_execution_context_have_the_same_of_the_machine() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let first = {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let allowed = status
            .lines()
            .find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
        let allowed = allowed.unwrap().trim().to_owned();
        allowed.split(['-', ',']).next().unwrap().to_owned()
    };
    let on = |instance, cpus: &str, required| CreateRequest {
        realtime: Some(RealtimeRequest {
            cpus: Some(cpus.to_owned()),
            required,
            ..RealtimeRequest::default()
        }),
        ..shared(&manager, (instance, 0), "periodic", &[])
    };
    create(&mut client, shared(&manager, ("A", 0), "periodic", &[]));
    let all = cpus_of(&manager, "control");
    create(&mut client, on("B", &first, true));
    create(&mut client, on("C", &first, true));
    assert_eq!(component(&mut client, "C").realtime.unwrap().cpus, first);
    assert_eq!(cpus_of(&manager, "control"), first);
    let other = RequestBody::Create(on("D", "1022", true));
    let failure = refused(&mut client, other, SOON);
    assert!(failure.message.contains("that B shares"), "{failure}");
    create(&mut client, on("D", "1022", false));
    assert_eq!(component(&mut client, "D").realtime.unwrap().cpus, first);
    for instance in ["B", "C", "D"] {
        ok(&mut client, delete(instance));
    }
    let lost = RequestBody::Create(on("E", "1023", true));
    let failure = refused(&mut client, lost, SOON);
    assert!(failure.message.contains("processors 1023"), "{failure}");
    assert_eq!(cpus_of(&manager, "control"), all, "nobody asks any more");
}

/// Processors of a thread of the manager.
fn cpus_of(manager: &Running, thread: &str) -> String {
    let tasks =
        std::fs::read_dir(format!("/proc/{}/task", manager.child.id())).expect("it is there");
    let mut statuses =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("status")).ok());
    let own = statuses.find(|status| status.starts_with(&format!("Name:\t{thread}\n")));
    let own = own.expect("it is there");
    let cpus = own
        .lines()
        .find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    cpus.expect("it is there").trim().to_owned()
}
