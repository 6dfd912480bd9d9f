//! Finds orders that can never be obeyed, before anything is stored or stopped.

use rts_schemas::system::SystemSpec;

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

    use super::check_orders;

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
}
