//! A large system, spread over nodes: each component feeds the next one on its node.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Name of the system.
pub const NAME: &str = "fleet";

/// What is to run where.
#[derive(Debug, Clone)]
pub struct System {
    /// Nodes `n0`, `n1`, …
    pub nodes: u32,
    /// Components, in equal parts on all nodes.
    pub components: u32,
    /// Type of each.
    pub type_name: &'static str,
    /// Parameter that the first of them has another value of than the others.
    pub parameter: &'static str,
    /// That value.
    pub value: f64,
}

impl System {
    /// Writes it as an RTS Profile.
    pub fn write(&self, file: &Path) -> Result<PathBuf> {
        std::fs::write(file, self.text())
            .with_context(|| format!("cannot write {}", file.display()))?;
        Ok(file.to_owned())
    }

    /// The name of a component: its node, which half of the node's components it belongs to, and its number.
    fn name(&self, component: u32) -> String {
        let share = self.components.div_ceil(self.nodes);
        let half = if component % share < share.div_ceil(2) {
            'a'
        } else {
            'b'
        };
        format!("N{}{half}{component}", self.node(component))
    }

    /// The node of a component.
    fn node(&self, component: u32) -> u32 {
        component / self.components.div_ceil(self.nodes)
    }

    /// True for all but the first component of a node.
    fn follows(&self, component: u32) -> bool {
        component > 0 && self.node(component) == self.node(component - 1)
    }

    fn text(&self) -> String {
        let mut text = String::from(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:rtsctl:fleet:1.0" rts:version="0.2" rts:creationDate="2026-01-01T00:00:00" rts:updateDate="2026-01-01T00:00:00" xmlns:rts="http://www.openrtp.org/namespaces/rts" xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
"#,
        );
        let Self {
            type_name,
            parameter,
            ..
        } = self;
        let id = format!("RTC:rtsctl:bench:{type_name}:1.0");
        // Writing into a text cannot fail.
        for i in 0..self.components {
            let value = if i == 0 { self.value } else { 1.0 };
            let _ = writeln!(
                text,
                r#"<rts:Components rts:id="{id}" rts:instanceName="{name}" rts:pathUri="n{node}/{name}.rtc" rts:activeConfigurationSet="default" rts:compositeType="None" rts:isRequired="true">
<rts:DataPorts rts:name="{name}.in"/><rts:DataPorts rts:name="{name}.out"/>
<rts:ConfigurationSets rts:id="default"><rts:ConfigurationData rts:name="{parameter}" rts:data="{value}"/></rts:ConfigurationSets>
<rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="10.0"/>
</rts:Components>"#,
                node = self.node(i),
                name = self.name(i)
            );
        }
        for i in (0..self.components).filter(|i| self.follows(*i)) {
            let (name, before) = (self.name(i), self.name(i - 1));
            let _ = writeln!(
                text,
                r#"<rts:DataPortConnectors rts:connectorId="k{i}" rts:name="k{i}" rts:dataType="IDL:RTC/TimedDouble:1.0" rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush">
<rts:sourceDataPort rts:portName="{before}.out" rts:instanceName="{before}" rts:componentId="{id}"/><rts:targetDataPort rts:portName="{name}.in" rts:instanceName="{name}" rts:componentId="{id}"/>
</rts:DataPortConnectors>"#
            );
        }
        text.push_str("</rts:RtsProfile>\n");
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_spread_and_each_feeds_the_next_on_its_node() {
        let system = System {
            nodes: 2,
            components: 6,
            type_name: "Part",
            parameter: "gain",
            value: 2.0,
        };
        let text = system.text();
        assert_eq!(text.matches("<rts:DataPortConnectors ").count(), 4);
        assert_eq!(text.matches("<rts:Components ").count(), 6);
        assert_eq!(text.matches("pathUri=\"n1/").count(), 3);
        assert_eq!(text.matches("rts:data=\"2\"").count(), 1);
        assert!(
            !text.contains("k3"),
            "the components 2 and 3 are on two nodes"
        );
        assert_eq!(
            (system.name(1), system.name(5)),
            ("N0a1".into(), "N1b5".into())
        );
    }
}
