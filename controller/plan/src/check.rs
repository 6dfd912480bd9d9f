//! Finds orders that can never be obeyed, before anything is stored or stopped.

use rts_schemas::system::{Condition, Orders, SystemSpec};

use crate::order::Order;
use crate::plan::PlanError;

/// Every cycle in every order of a system. Conditions that name unknown components are the schema checks' business.
pub fn check_orders(spec: &SystemSpec) -> Vec<PlanError> {
    let mut errors = Vec::new();
    for (order, conditions) in lists(&spec.orders) {
        errors.extend(cycles(spec, order, &[conditions]));
    }
    // Create also initialises and Delete also finalises, so that each of these pairs orders the same steps.
    let orders = &spec.orders;
    let pairs = [
        (
            "StartUp and Initializing",
            &orders.start_up,
            &orders.initializing,
        ),
        (
            "ShutDown and Finalizing",
            &orders.shut_down,
            &orders.finalizing,
        ),
    ];
    for (name, one, other) in pairs {
        let alone = cycles(spec, name, &[one]).len() + cycles(spec, name, &[other]).len();
        if alone == 0 {
            errors.extend(cycles(spec, name, &[one, other]));
        }
    }
    errors
}

fn lists(orders: &Orders) -> [(&'static str, &Vec<Condition>); 7] {
    [
        ("StartUp", &orders.start_up),
        ("ShutDown", &orders.shut_down),
        ("Activation", &orders.activation),
        ("Deactivation", &orders.deactivation),
        ("Resetting", &orders.resetting),
        ("Initializing", &orders.initializing),
        ("Finalizing", &orders.finalizing),
    ]
}

fn cycles<'a>(spec: &'a SystemSpec, order: &'a str, lists: &[&'a [Condition]]) -> Vec<PlanError> {
    let members = spec.components.iter().map(|c| c.instance.as_str());
    Order::new(order, lists, members)
        .cycles()
        .into_iter()
        .map(|members| PlanError::Cycle {
            system: spec.name.clone(),
            order: order.to_owned(),
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
