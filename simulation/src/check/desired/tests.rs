use super::*;
use crate::check::fixtures::{desired_acked, hello, see};

/// Numbers of components of the candidates; 0 for none.
fn sizes(desired: &Desired) -> Vec<usize> {
    let size = |spec: Option<&Arc<SystemSpec>>| spec.map_or(0, |spec| spec.components.len());
    let specs = desired.candidates("hello").specs;
    specs.iter().map(|spec| size(spec.as_ref())).collect()
}

#[test]
fn what_was_asked_for_may_be_in_force_until_something_later_is_everywhere() {
    let mut desired = Desired::default();
    desired.asked(&hello(&["A"]));
    desired.converged();
    assert_eq!(sizes(&desired), [1]);
    see(&mut desired, &[desired_acked(Some(1))]);
    desired.asked(&hello(&["A", "B"]));
    desired.converged();
    assert_eq!(sizes(&desired), [1, 2], "the second may have been stored");
    desired.refused("hello");
    assert_eq!(sizes(&desired), [1]);
    desired.deletion_asked("hello");
    see(&mut desired, &[desired_acked(None)]);
    desired.converged();
    assert_eq!(sizes(&desired), [0]);
}

#[test]
fn another_module_counts_until_a_later_apply_is_everywhere() {
    let mut desired = Desired::default();
    let spec = hello(&["A"]);
    desired.asked(&spec);
    see(&mut desired, &[desired_acked(Some(1))]);
    desired.module_changed("Any");
    desired.converged();
    assert!(desired.has_other_module(&spec));
    desired.asked(&spec);
    see(&mut desired, &[desired_acked(Some(2))]);
    assert!(desired.has_other_module(&spec));
    desired.converged();
    assert!(!desired.has_other_module(&spec));
}

#[test]
fn a_store_that_went_back_may_bring_anything_again_until_its_users_have_spoken() {
    let mut desired = Desired::default();
    for names in [&["A"][..], &["A", "B"]] {
        desired.asked(&hello(names));
        see(&mut desired, &[desired_acked(Some(1))]);
        desired.converged();
    }
    assert_eq!(sizes(&desired), [2]);
    desired.restored();
    desired.converged();
    assert_eq!(sizes(&desired), [0, 1, 2]);
    desired.asked(&hello(&["A", "B", "C"]));
    see(&mut desired, &[desired_acked(Some(3))]);
    desired.converged();
    assert_eq!(sizes(&desired), [3]);
}
