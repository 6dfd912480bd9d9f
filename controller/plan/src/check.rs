//! Finds orders that can never be obeyed, before anything is stored or stopped.

use rts_schemas::system::{Condition, SystemSpec, WaitFor};

use crate::order::{List, Member, Order, all, deleting, making};
use crate::plan::PlanError;

/// Every cycle in every order of a system. Conditions that name unknown components are the schema checks' business.
pub fn check_orders(spec: &SystemSpec) -> Vec<PlanError> {
    let mut errors = Vec::new();
    for list in all(&spec.orders) {
        errors.extend(cycles(spec, &[list]));
    }
    for pair in [making(&spec.orders), deleting(&spec.orders)] {
        let alone = pair.iter().all(|list| cycles(spec, &[*list]).is_empty());
        if alone {
            errors.extend(cycles(spec, &pair));
        }
    }
    errors
}

/// JSON pointer to the condition that closes a cycle (`/orders/activation/2`): of several the last one, which an overlay
/// added if it added any.
pub fn cycle_pointer(spec: &SystemSpec, error: &PlanError) -> String {
    let PlanError::Cycle { order, members, .. } = error;
    let is_member = |name: &String| members.contains(name);
    let closes = |condition: &Condition| {
        let before = match &condition.wait {
            Some(WaitFor::Preceding { components, .. }) => components.iter().any(is_member),
            _ => false,
        };
        before && is_member(&condition.target)
    };
    let mut lists = all(&spec.orders).into_iter();
    let found = lists.find_map(|(name, list)| {
        let spoken = order.split(" and ").any(|spoken| spoken == name.element());
        let last = list.iter().rposition(closes).filter(|_| spoken)?;
        let (first, rest) = name.element().split_at(1);
        let key = format!("{}{rest}", first.to_lowercase());
        Some(format!("/orders/{key}/{last}"))
    });
    found.unwrap_or_else(|| "/orders".to_owned())
}

fn cycles(spec: &SystemSpec, lists: &[List<'_>]) -> Vec<PlanError> {
    let members = spec.components.iter().map(|component| Member {
        name: &component.instance,
        required: component.required,
    });
    let order = Order::new(lists, members);
    let cycles = order.cycles().into_iter();
    cycles
        .map(|members| PlanError::Cycle {
            system: spec.name.clone(),
            order: order.name().to_owned(),
            members: members.into_iter().map(str::to_owned).collect(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use rts_schemas::system::SystemSpec;
    use serde_json::json;

    use super::{check_orders, cycle_pointer};

    fn system(orders: serde_json::Value) -> SystemSpec {
        let components: Vec<_> = ["A", "B", "C", "D"]
            .iter()
            .map(|name| json!({"instance": name, "type": "T"}))
            .collect();
        let spec = json!({"name": "s", "components": components, "orders": orders});
        serde_json::from_value(spec).unwrap()
    }

    fn after(target: &str, sequence: u32, before: &[&str]) -> serde_json::Value {
        json!({"target": target, "sequence": sequence, "wait":
            {"kind": "preceding", "timing": "sync", "timeoutMs": 0, "components": before}})
    }

    fn errors(orders: serde_json::Value) -> String {
        let errors = check_orders(&system(orders));
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        lines.join("\n")
    }

    #[test]
    fn order_without_cycle_is_fine() {
        let activation = [
            after("A", 1, &["B"]),
            after("B", 0, &["C"]),
            after("C", 0, &[]),
        ];
        assert_eq!(errors(json!({"activation": activation})), "");
    }

    #[test]
    fn all_members_are_named() {
        let activation = [
            after("C", 0, &["B"]),
            after("B", 0, &["A"]),
            after("A", 0, &["C"]),
        ];
        insta::assert_snapshot!(
            errors(json!({"activation": activation, "shutDown": [after("D", 0, &["D"])]})),
            @r"
        the ShutDown orders of system s form a cycle of D
        the Activation orders of system s form a cycle of A, B, C
        "
        );
    }

    #[test]
    fn preceding_outweighs_a_sequence_number() {
        let activation = [
            after("A", 0, &["B"]),
            after("B", 1, &[]),
            after("C", 0, &[]),
        ];
        assert_eq!(errors(json!({"activation": activation})), "");
        let activation = [after("A", 0, &["B"]), after("B", 1, &["A"])];
        insta::assert_snapshot!(
            errors(json!({"activation": activation})),
            @"the Activation orders of system s form a cycle of A, B"
        );
    }

    #[test]
    fn two_orders_of_one_step_must_agree() {
        let orders =
            json!({"startUp": [after("A", 0, &["B"])], "initializing": [after("B", 0, &["A"])]});
        insta::assert_snapshot!(
            errors(orders),
            @"the StartUp and Initializing orders of system s form a cycle of A, B"
        );
    }

    #[test]
    fn unknown_components_are_left_to_others() {
        let orders = json!({"activation": [after("A", 0, &["X"]), after("X", 0, &["A"])]});
        assert_eq!(errors(orders), "");
    }

    #[test]
    fn a_cycle_is_where_its_last_condition_stands() {
        let spec = system(json!({
            "shutDown": [after("A", 0, &["B"])],
            "activation": [after("A", 1, &["B"]), after("B", 2, &["A"]), after("C", 3, &["B"])],
        }));
        let errors = check_orders(&spec);
        let pointers: Vec<_> = errors.iter().map(|e| cycle_pointer(&spec, e)).collect();
        assert_eq!(pointers, ["/orders/activation/1"]);
        let orders =
            json!({"startUp": [after("A", 0, &["B"])], "initializing": [after("B", 0, &["A"])]});
        let spec = system(orders);
        let pointer = cycle_pointer(&spec, &check_orders(&spec)[0]);
        assert_eq!(pointer, "/orders/startUp/0");
    }
}
