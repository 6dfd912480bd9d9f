//! A machine that was switched off: the agent starts what it was last told to run, in order, without a controller.

use std::path::Path;

use rts_tests::{Profile, Stack, kill_9, processes_of};

/// All processes gone at once, and files that speak of another boot.
fn switch_off(stack: &Stack) {
    let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").expect("a boot id");
    processes_of(&stack.home()).into_iter().for_each(kill_9);
    let changed = replace_in(
        &stack.home(),
        boot.trim(),
        "00000000-1111-4222-8333-444444444444",
    );
    assert!(changed > 0, "no file names the boot");
}

/// Replaces a text in all small files below a folder; gives how many had it.
fn replace_in(folder: &Path, from: &str, to: &str) -> usize {
    let mut changed = 0;
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            changed += replace_in(&path, from, to);
        } else if path.extension().is_some_and(|e| e == "json") {
            let text = std::fs::read_to_string(&path).expect("a JSON file");
            if text.contains(from) {
                std::fs::write(&path, text.replace(from, to)).expect("written");
                changed += 1;
            }
        }
    }
    changed
}

/// When a component became Active last, as its log says.
fn activated(stack: &Stack, instance: &str) -> String {
    let log = stack
        .home()
        .join(format!("logs/local/components/{instance}.log"));
    let text = std::fs::read_to_string(log).expect("a log");
    let mut lines = text.lines().filter(|l| l.ends_with("Inactive -> Active"));
    let last = lines.next_back().expect("it became Active");
    last.split(' ').next().expect("a time").to_owned()
}

#[test]
fn after_a_reboot_the_agent_alone_starts_everything_in_order() {
    let stack = Stack::new();
    let file = stack.write("chain.xml", Profile::chain("chain", 20).xml());
    let file = file.to_string_lossy();
    stack.expect(0, &["apply", &file]);
    let before = stack.witness();
    switch_off(&stack);
    let mut agent = stack.agent_alone();
    let after = stack.until_seen("all run", |now| now.all_active(5));
    for name in before.names() {
        assert_ne!(
            before.of(name).info.incarnation,
            after.of(name).info.incarnation
        );
    }
    let times: Vec<String> = (0..5)
        .map(|nr| activated(&stack, &format!("chain{nr}")))
        .collect();
    // The written order is from the sink to the source, 20 ms apart.
    let mut sorted = times.clone();
    sorted.sort_unstable_by(|a, b| b.cmp(a));
    sorted.dedup();
    assert_eq!(times, sorted, "from the sink to the source");
    after.goes_on_undisturbed(&stack);
    // The controller that comes back finds nothing to do.
    stack.expect(0, &["up"]);
    stack.expect(0, &["apply", &file]);
    stack.expect(0, &["diff", &file]);
    after.goes_on_undisturbed(&stack);
    stack.leaves_nothing();
    let _ = agent.wait();
}

#[test]
fn an_agent_that_was_killed_heals_without_a_controller() {
    let stack = Stack::new();
    let file = stack.write("chain.xml", Profile::chain("chain", 0).xml());
    stack.expect(0, &["apply", &file.to_string_lossy()]);
    let before = stack.witness();
    stack.kill_9("rts-controller");
    stack.kill_9("rts-agent");
    kill_9(before.of("chain2").pid);
    let mut agent = stack.agent_alone();
    stack.until_seen("it is healed", |now| now.all_active(5));
    before.without(&["chain2"]).goes_on_undisturbed(&stack);
    // Killed again while the agent lives.
    kill_9(stack.witness().of("chain3").pid);
    stack.until_seen("it is healed", |now| now.all_active(5));
    before
        .without(&["chain2", "chain3"])
        .goes_on_undisturbed(&stack);
    stack.leaves_nothing();
    let _ = agent.wait();
}
