//! What runs, without the names of single starts.

use std::collections::BTreeMap;

use rts_plan::desired::ManagerKey;
use rts_plan::observed::ByHand;

use crate::world::World;

/// Places, contents, settings and connectors. A rate that nobody writes stays as it was and does not count; nor do
/// marks where nothing differs, nor a module that no component uses: when a component ends by itself, its module stays
/// loaded, since nobody can tell it from one that a person loaded.
pub fn shape(world: &World) -> BTreeMap<(String, ManagerKey), String> {
    let specs = world
        .systems
        .iter()
        .flat_map(|system| &system.spec.components);
    let written = |name: &str| {
        let mut own = specs.clone().filter(|c| c.instance == name);
        own.any(|c| c.execution_context.rate.is_some())
    };
    let mut shape = BTreeMap::new();
    for (node, manager) in world.managers() {
        let mut components = manager.components.clone();
        components.sort_by(|a, b| a.instance.cmp(&b.instance));
        for component in &mut components {
            component.incarnation.clear();
            component.by_hand = ByHand::default();
            let active = &mut component.configuration.active;
            active.get_or_insert_with(|| "default".to_owned());
            component.connectors.sort_by(|a, b| a.name.cmp(&b.name));
            for connector in &mut component.connectors {
                connector.target_incarnation.clear();
                connector.by_hand = None;
            }
            component
                .bindings
                .sort_by(|a, b| a.connector.cmp(&b.connector));
            if !written(&component.instance) {
                component.rate = 0.0;
            }
        }
        let modules = manager.modules.iter();
        let used = modules.filter(|name| {
            components
                .iter()
                .any(|c| !c.stand_in && c.type_name == **name)
        });
        let modules: Vec<&String> = used.collect();
        let text = format!("{modules:?} {components:?}");
        shape.insert((node.to_owned(), manager.key.clone()), text);
    }
    shape
}
