//! What hangs: a callback that has not returned for longer than its component's policy allows, and a manager that does
//! not answer; and whether the process is to be replaced for it.

use std::time::Duration;

use rts_manager_api::control::{Busy, ComponentInfo};
use rts_schemas::system::Policy;

use super::merge::{View, system_ref};
use crate::policies::{Policies, liveness_timeout, replaces, start_timeout};

/// How long a callback may take, and the key that says so.
fn limit(policy: Option<&Policy>, callback: &str) -> (Duration, &'static str) {
    match callback {
        "create" | "on_initialize" | "on_startup" | "on_activated" => {
            (start_timeout(policy), "rtsctl.startTimeout")
        }
        _ => (liveness_timeout(policy), "rtsctl.livenessTimeout"),
    }
}

fn policy<'a>(policies: &'a Policies, info: &ComponentInfo) -> Option<&'a Policy> {
    let system = info.system.as_ref().map(system_ref)?;
    policies.of_present(&system, &info.instance)
}

/// The callback of a component that hangs.
pub(super) fn hangs<'a>(policies: &Policies, info: &'a ComponentInfo) -> Option<&'a Busy> {
    let busy = info.busy.as_ref()?;
    let (limit, _) = limit(policy(policies, info), &busy.callback);
    (Duration::from_millis(busy.milliseconds) >= limit).then_some(busy)
}

/// Why a step on a component is no longer waited for; none where its process is not to be replaced for it.
pub(crate) fn why_hanging(policies: &Policies, info: &ComponentInfo) -> Option<String> {
    let policy = policy(policies, info);
    let busy = hangs(policies, info).filter(|_| replaces(policy))?;
    Some(told(policy, info, busy))
}

/// Which callback hangs. The words do not change while that goes on.
fn told(policy: Option<&Policy>, info: &ComponentInfo, busy: &Busy) -> String {
    let (instance, callback) = (&info.instance, &busy.callback);
    let (limit, key) = limit(policy, callback);
    let limit = words(limit);
    format!("{instance} has been in {callback} for longer than {limit} ({key})")
}

/// Why a manager's process must be replaced. The words do not change while that goes on.
pub(super) fn expired(policies: &Policies, view: &View) -> Option<String> {
    let components = || view.inventory.components.iter();
    let hanging = components().filter(|info| replaces(policy(policies, info)));
    let reasons = hanging.filter_map(|info| {
        let busy = hangs(policies, info)?;
        Some(told(policy(policies, info), info, busy))
    });
    reasons.min().or_else(|| {
        let silent = view.silent?;
        let (limit, instance) = patience(policies, view)?;
        (silent > limit).then(|| {
            let limit = words(limit);
            format!(
                "its process has not answered for longer than {limit} (rtsctl.livenessTimeout of {instance})"
            )
        })
    })
}

/// How long a manager may be silent before its process is replaced, and the component that says so. Where nobody knows
/// what it holds, those have a say that belong there.
fn patience<'a>(policies: &'a Policies, view: &'a View) -> Option<(Duration, &'a String)> {
    let inside = view.inventory.components.iter();
    let inside = inside.map(|info| (&info.instance, policy(policies, info)));
    let belong = policies.belong_in(&view.key).filter(|_| view.unseen);
    let belong = belong.map(|(instance, policy)| (instance, Some(policy)));
    let asks = inside.chain(belong).filter(|(_, policy)| replaces(*policy));
    asks.map(|(instance, policy)| (liveness_timeout(policy), instance))
        .min()
}

fn words(limit: Duration) -> String {
    match limit.as_millis() {
        ms if ms.is_multiple_of(1000) => format!("{} s", ms / 1000),
        ms => format!("{ms} ms"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inventory::difference::{differences, without_counters};
    use crate::inventory::fixtures::{bare, view};
    use crate::inventory::merge::merge;
    use rts_manager_api::control::{ExecutionContextInfo, SystemId};
    use rts_plan::desired::{NodeSpec, NodeSystem, PlacedComponent, SystemRef};
    use rts_plan::observed::Inventory;
    use rts_schemas::system::{ComponentSpec, OnHang};

    fn policies(policy: Policy) -> Policies {
        let spec = ComponentSpec {
            instance: "A".to_owned(),
            type_name: "A".to_owned(),
            full_id: String::new(),
            required: true,
            ports: Vec::new(),
            configuration: Default::default(),
            execution_context: Default::default(),
            placement: Default::default(),
            policy,
            ..ComponentSpec::default()
        };
        let placed = PlacedComponent {
            spec,
            manager: "main".to_owned(),
            module_digest: None,
            stand_in: None,
            recreate_hash: String::new(),
        };
        let system = NodeSystem {
            system: SystemRef {
                name: "hello".to_owned(),
                uid: "1".to_owned(),
            },
            components: vec![placed],
            connectors: Vec::new(),
            orders: Default::default(),
            elsewhere: Default::default(),
            generation: 0,
        };
        Policies::of_spec(&NodeSpec {
            node: "local".to_owned(),
            systems: vec![system],
        })
    }

    fn seen(
        policy: Policy,
        busy: Option<(&str, u64)>,
        silent: Option<u64>,
    ) -> (Option<String>, Option<String>, Inventory) {
        let mut info = bare("A");
        info.system = Some(SystemId {
            name: "hello".to_owned(),
            uid: "1".to_owned(),
        });
        info.busy = busy.map(|(callback, milliseconds)| Busy {
            callback: callback.to_owned(),
            milliseconds,
        });
        let mut view = view(vec![info]);
        view.silent = silent.map(Duration::from_millis);
        view.responsive = silent.is_none();
        let inventory = merge("local", vec![view], &policies(policy));
        let manager = &inventory.managers[0];
        let hangs = manager.components[0].hangs.clone();
        (hangs, manager.expired.clone(), inventory.clone())
    }

    fn restart(ms: u64) -> Policy {
        Policy {
            on_hang: OnHang::Restart,
            liveness_timeout_ms: Some(ms),
            ..Policy::default()
        }
    }

    #[test]
    fn it_hangs_after_its_own_time_and_is_replaced_only_where_that_is_wanted() {
        let hangs = |policy, busy| seen(policy, Some(busy), None).0;
        let expired = |policy, busy| seen(policy, Some(busy), None).1;
        assert_eq!(hangs(Policy::default(), ("on_execute", 4_900)), None);
        assert_eq!(
            hangs(Policy::default(), ("on_execute", 11_900)).as_deref(),
            Some("has been in on_execute for 11 s")
        );
        assert_eq!(expired(Policy::default(), ("on_execute", 11_900)), None);
        assert_eq!(expired(restart(2_500), ("on_execute", 2_400)), None);
        assert_eq!(
            expired(restart(2_500), ("on_execute", 2_500)).as_deref(),
            Some("A has been in on_execute for longer than 2500 ms (rtsctl.livenessTimeout)")
        );
        for callback in ["create", "on_initialize", "on_startup", "on_activated"] {
            assert_eq!(hangs(restart(2_500), (callback, 9_000)), None);
        }
        assert_eq!(
            expired(restart(2_500), ("on_initialize", 10_000)).as_deref(),
            Some("A has been in on_initialize for longer than 10 s (rtsctl.startTimeout)")
        );
    }

    #[test]
    fn who_hangs_is_told_with_the_execution_context_and_those_that_it_holds_up() {
        let mut info = bare("A");
        info.busy = Some(Busy {
            callback: "on_execute".to_owned(),
            milliseconds: 11_900,
        });
        info.execution_context = Some(ExecutionContextInfo {
            name: "control".to_owned(),
            order: 1,
            shared_state: None,
            members: ["A", "B", "C"].map(str::to_owned).to_vec(),
        });
        let inventory = merge("local", vec![view(vec![info])], &Policies::default());
        let component = &inventory.managers[0].components[0];
        assert_eq!(
            component.hangs.as_deref(),
            Some(
                "has been in on_execute and holds up execution context control with B, C for 11 s"
            )
        );
        assert_eq!(component.runs_with, ["A", "B", "C"]);
    }

    #[test]
    fn a_silent_process_is_replaced_when_one_in_it_asks_for_that() {
        let expired = |policy, silent| seen(policy, None, Some(silent)).1;
        assert_eq!(expired(Policy::default(), 99_000), None);
        assert_eq!(expired(restart(3_000), 2_900), None);
        assert_eq!(
            expired(restart(3_000), 3_100).as_deref(),
            Some("its process has not answered for longer than 3 s (rtsctl.livenessTimeout of A)")
        );
    }

    #[test]
    fn a_silent_process_of_which_nothing_is_known_is_replaced_when_what_belongs_there_asks_for_that()
     {
        let why = expired;
        let expired = |policy, name: &str, silent| {
            let mut view = view(Vec::new());
            view.key.system = Some(SystemRef {
                name: "hello".to_owned(),
                uid: "1".to_owned(),
            });
            view.key.name = name.to_owned();
            view.silent = Some(Duration::from_millis(silent));
            (view.responsive, view.unseen) = (false, true);
            let inventory = merge("local", vec![view.clone()], &policies(policy));
            assert!(inventory.managers[0].unseen);
            view.unseen = false;
            let (known, now) = (policies(restart(1)), &inventory.managers[0].expired);
            assert_eq!(why(&known, &view), None, "known to be empty");
            now.clone()
        };
        assert_eq!(expired(Policy::default(), "main", 99_000), None);
        assert_eq!(expired(restart(3_000), "main", 2_900), None);
        assert_eq!(expired(restart(3_000), "other", 3_100), None);
        assert_eq!(
            expired(restart(3_000), "main", 3_100).as_deref(),
            Some("its process has not answered for longer than 3 s (rtsctl.livenessTimeout of A)")
        );
    }

    #[test]
    fn that_it_hangs_is_told_once_and_that_it_is_over_too() {
        let at = |busy: Option<u64>| {
            let busy = busy.map(|ms| ("on_execute", ms));
            seen(restart(5_000), busy, None).2
        };
        let (well, begun, later) = (at(None), at(Some(5_200)), at(Some(11_900)));
        assert_eq!(without_counters(&begun), without_counters(&later));
        assert_ne!(without_counters(&begun), without_counters(&well));
        let told = |old: &Inventory, new: &Inventory| {
            let events = differences(old, new).into_iter();
            let line = |e: rts_agent_api::session::AgentEvent| {
                format!("{} {} {}: {}", e.kind, e.reason, e.object, e.message)
            };
            events.map(line).collect::<Vec<_>>().join("\n")
        };
        insta::assert_snapshot!(told(&well, &begun), @r"
        Warning ManagerExpired manager/main: A has been in on_execute for longer than 5 s (rtsctl.livenessTimeout): process 1 is to be replaced
        Warning Hangs component/A: has been in on_execute for 5 s
        ");
        assert_eq!(told(&begun, &later), "");
        insta::assert_snapshot!(told(&later, &well), @"Normal Hangs component/A: hangs no longer");
    }
}
