//! Processes over the lives of agents, and their ends.

use rts_agent::machine::{Signal, Tenant};

use super::*;

#[tokio::test(start_paused = true)]
async fn a_manager_outlives_its_agent_and_is_found_by_the_next() {
    let mut bench = bench();
    let (caller, _) = bench.start_with("m", &["A"]).await;
    bench.next_life();
    sleep(Duration::from_secs(1)).await;
    let folders = bench.grip.run_folders().await;
    assert_eq!(folders, [folder("m")]);
    let Tenant::Lives(file) = bench.grip.look(&folders[0]).await.unwrap() else {
        panic!("it lives");
    };
    assert_eq!(
        (file.incarnation.as_str(), file.pid),
        ("m", caller.hello.pid)
    );
    assert_eq!(Some(&file.boot_id), bench.grip.boot_id().as_ref());
    let found = bench.grip.find(&folders[0], &file).await.unwrap();
    let control = bench.grip.connect(&folders[0]).await.unwrap();
    let mut next = Caller::greet(control).await.unwrap();
    assert_eq!(next.hello, caller.hello);
    assert_eq!(next.component("A").await.state, "Active");
    // What the dead one still holds says nothing any more.
    let mut dead = caller;
    assert_eq!(dead.call_within(RequestBody::Inventory, 1).await, None);
    found.family.signal(Signal::Term).await;
    let exit = timeout(LONG, found.exit).await.unwrap();
    assert_eq!(exit, Exit::Unknown);
    assert!(found.family.has_ended());
}

#[tokio::test(start_paused = true)]
async fn a_crash_in_the_middle_leaves_a_manager_or_none() {
    for calls in 1..=6 {
        let mut bench = bench();
        let start = start("m", "m");
        bench.grip.make_folder(&start.folder).await.unwrap();
        bench.life.burn(calls);
        let launch = async {
            let launched = bench.grip.launch(&start).await;
            let launched = launched.map_err(|e| e.to_string()).unwrap();
            Caller::greet(launched.control).await
        };
        let greeted = timeout(LONG, launch).await.ok().flatten();
        bench.next_life();
        let tenant = bench.grip.look(&start.folder).await.unwrap();
        let expected = match calls {
            1 => Tenant::Gone(None),
            _ => {
                let Tenant::Lives(file) = &tenant else {
                    panic!("{calls}: {tenant:?}");
                };
                assert_eq!(file.incarnation, "m");
                tenant.clone()
            }
        };
        assert_eq!(tenant, expected, "{calls}");
        assert_eq!(greeted.is_some(), calls > 5, "{calls}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_folder_is_nameless_while_it_is_young() {
    let bench = bench();
    let path = folder("m");
    let look = async || bench.grip.look(&path).await.unwrap();
    assert_eq!(look().await, Tenant::None);
    bench.grip.make_folder(&path).await.unwrap();
    assert_eq!(look().await, Tenant::Nameless);
    sleep(Duration::from_secs(2)).await;
    assert_eq!(look().await, Tenant::Gone(None));
    assert!(bench.grip.connect(&path).await.is_err());
    // Without its folder, nothing is started.
    let elsewhere = start("n", "n");
    assert!(bench.grip.launch(&elsewhere).await.is_err());
    // A manager makes its files anew when somebody removes them.
    let (mut caller, _) = bench.start("m").await;
    bench.grip.remove_folder(&path).await;
    assert_eq!(look().await, Tenant::None);
    sleep(Duration::from_secs(2)).await;
    assert!(matches!(look().await, Tenant::Lives(_)));
    caller.inventory().await;
}

#[tokio::test(start_paused = true)]
async fn who_is_killed_leaves_a_folder_and_grandchildren_until_it_is_buried() {
    let mut bench = bench();
    bench.machine.grandchildren(1.0);
    let (mut caller, _) = bench.start_with("m", &["A"]).await;
    assert_eq!(bench.machine.kill(None).as_deref(), Some("hello.m"));
    assert_eq!(caller.call_within(RequestBody::Inventory, 1).await, None);
    bench.next_life();
    let tenant = bench.grip.look(&folder("m")).await.unwrap();
    let Tenant::Gone(Some(file)) = tenant else {
        panic!("{tenant:?}");
    };
    assert!(bench.grip.find(&folder("m"), &file).await.is_err());
    let left = bench.machine.left_over();
    assert_eq!((left.processes.len(), left.grandchildren.len()), (0, 1));
    bench.grip.bury(&folder("m"), Some(file)).await.unwrap();
    assert!(bench.machine.left_over().is_empty());
    insta::assert_snapshot!(bench.story(), @r"
    m started
    A created
    A Inactive -> Active: Asked
    m/- blemished: it is killed
    A deleted: Died
    m ended: Fault
    ");
}

#[tokio::test(start_paused = true)]
async fn orphans_are_buried_and_others_are_not() {
    let mut bench = bench();
    bench.machine.grandchildren(1.0);
    let _ = (bench.start("m").await, bench.start("n").await);
    bench.next_life();
    bench.machine.kill(Some("hello.m"));
    bench.grip.remove_folder(&folder("m")).await;
    bench.grip.bury_orphans(vec![folder("n")]).await;
    let left = bench.machine.left_over();
    assert_eq!((left.processes.len(), left.grandchildren.len()), (1, 1));
    assert_eq!(left.folders, [folder("n")]);
}

#[tokio::test(start_paused = true)]
async fn who_hangs_answers_nobody_and_dies_of_sigkill_alone() {
    let bench = bench();
    let (mut caller, family) = bench.start_with("m", &["A"]).await;
    assert_eq!(bench.machine.hang(Some("hello.n")), None);
    bench.machine.hang(Some("hello.m")).unwrap();
    assert_eq!(caller.call_within(RequestBody::Inventory, 1).await, None);
    let control = bench.grip.connect(&folder("m")).await.unwrap();
    assert!(Caller::greet(control).await.is_none());
    family.signal(Signal::Term).await;
    family.signal(Signal::Cont).await;
    sleep(LONG).await;
    assert!(!family.has_ended());
    let tenant = bench.grip.look(&folder("m")).await.unwrap();
    assert!(matches!(tenant, Tenant::Lives(_)));
    family.signal(Signal::Kill).await;
    assert!(family.has_ended());
    insta::assert_snapshot!(bench.story(), @r"
    m started
    A created
    A Inactive -> Active: Asked
    m/- blemished: it hangs
    A deleted: Died
    m ended: Asked
    ");
}

#[tokio::test(start_paused = true)]
async fn a_reboot_ends_all_and_keeps_the_folders() {
    let mut bench = bench();
    bench.machine.grandchildren(1.0);
    let _ = bench.start_with("m", &["A"]).await;
    let before = bench.grip.boot_id();
    bench.next_life();
    bench.machine.reboot();
    assert_ne!(bench.grip.boot_id(), before);
    let left = bench.machine.left_over();
    assert_eq!(left.folders, [folder("m")]);
    assert_eq!((left.processes.len(), left.grandchildren.len()), (0, 0));
    // The next process has the number of the one before, and is not taken for it.
    let (caller, _) = bench.start("n").await;
    let tenant = bench.grip.look(&folder("m")).await.unwrap();
    let Tenant::Gone(Some(file)) = tenant else {
        panic!("{tenant:?}");
    };
    assert_eq!(file.pid, caller.hello.pid);
    assert!(bench.grip.find(&folder("m"), &file).await.is_err());
}
