//! Writes small RTS Profiles.

use std::fmt::Write;

/// An RTS Profile in the making.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    name: String,
    components: Vec<Component>,
    connectors: Vec<(String, String)>,
    orders: String,
}

#[derive(Debug, Clone, Default)]
struct Component {
    instance: String,
    type_name: String,
    optional: bool,
    rate: Option<String>,
    parameters: Vec<(String, String)>,
    properties: Vec<(String, String)>,
}

impl Profile {
    /// A system without components.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }

    /// Five components of TimedDouble in five processes, one after another; `first` numbers the instances. Activation
    /// and Deactivation each wait `wait` milliseconds before every component, from the sink to the source and back.
    pub fn chain(name: &str, wait: u32) -> Self {
        let types = [
            "SineSource",
            "LowPassFilter",
            "LowPassFilter",
            "LowPassFilter",
            "Printer",
        ];
        let instance = |nr: usize| format!("{name}{nr}");
        let mut profile = Self::new(name);
        for (nr, type_name) in types.into_iter().enumerate() {
            let manager = format!("m{nr}");
            profile = profile
                .component(&instance(nr), type_name)
                .with("manager", &manager);
        }
        for nr in 1..types.len() {
            let (from, to) = (instance(nr - 1), instance(nr));
            profile = profile.connect(&format!("{from}.out"), &format!("{to}.in"));
        }
        let names: Vec<String> = (0..types.len()).map(instance).collect();
        let back: Vec<&str> = names.iter().rev().map(String::as_str).collect();
        let forth: Vec<&str> = names.iter().map(String::as_str).collect();
        profile
            .order("Activation", &back, wait)
            .order("Deactivation", &forth, wait)
    }

    /// One more component.
    #[must_use]
    pub fn component(mut self, instance: &str, type_name: &str) -> Self {
        self.components.push(Component {
            instance: instance.to_owned(),
            type_name: type_name.to_owned(),
            ..Component::default()
        });
        self
    }

    /// The component that was named last is not required.
    #[must_use]
    pub fn optional(mut self) -> Self {
        self.components.last_mut().expect("a component").optional = true;
        self
    }

    /// A parameter of the component that was named last, in its default set.
    #[must_use]
    pub fn parameter(mut self, name: &str, value: &str) -> Self {
        let last = self.components.last_mut().expect("a component");
        last.parameters.push((name.to_owned(), value.to_owned()));
        self
    }

    /// The rate in Hz of the component that was named last.
    #[must_use]
    pub fn rate(mut self, rate: &str) -> Self {
        self.components.last_mut().expect("a component").rate = Some(rate.to_owned());
        self
    }

    /// A `rtsctl.` key of the component that was named last.
    #[must_use]
    pub fn with(mut self, key: &str, value: &str) -> Self {
        let last = self.components.last_mut().expect("a component");
        last.properties
            .push((format!("rtsctl.{key}"), value.to_owned()));
        self
    }

    /// Connects `Instance.port` to `Instance.port`.
    #[must_use]
    pub fn connect(mut self, source: &str, target: &str) -> Self {
        self.connectors.push((source.to_owned(), target.to_owned()));
        self
    }

    /// An order (`Activation`): one after another, each after `wait` milliseconds.
    #[must_use]
    pub fn order(mut self, action: &str, instances: &[&str], wait: u32) -> Self {
        let _ = write!(self.orders, "<rts:{action}>");
        for (nr, instance) in instances.iter().enumerate() {
            let _ = write!(
                self.orders,
                r#"<rts:targets rts:sequence="{}"><rts:TargetComponent rts:id="0" rts:instanceName="{instance}" rts:componentId=""/><rts:WaitTime rts:waitTime="{wait}"/></rts:targets>"#,
                nr + 1
            );
        }
        let _ = write!(self.orders, "</rts:{action}>");
        self
    }

    /// An order (`Activation`) of one condition: `target` waits at most `timeout` ms (0: for ever) until `before` is there.
    #[must_use]
    pub fn sync(mut self, action: &str, target: &str, before: &str, timeout: u32) -> Self {
        let end = |tag: &str, instance: &str| {
            format!(r#"<rts:{tag} rts:id="0" rts:instanceName="{instance}" rts:componentId=""/>"#)
        };
        let _ = write!(
            self.orders,
            r#"<rts:{action}><rts:targets rts:sequence="1"><rts:Preceding rts:sendingTiming="SYNC" rts:timeout="{timeout}">{}</rts:Preceding>{}</rts:targets></rts:{action}>"#,
            end("PrecedingComponents", before),
            end("TargetComponent", target),
        );
        self
    }

    /// Ports of a component that connectors lead to, and their kinds.
    fn ports(&self, instance: &str) -> Vec<(&str, &'static str)> {
        let ends = self.connectors.iter().flat_map(|(source, target)| {
            [
                (source.as_str(), "DataOutPort"),
                (target.as_str(), "DataInPort"),
            ]
        });
        let mut ports: Vec<_> = ends
            .filter(|(port, _)| port.split_once('.').is_some_and(|(own, _)| own == instance))
            .collect();
        ports.sort_unstable();
        ports.dedup();
        ports
    }

    /// The XML text.
    pub fn xml(&self) -> String {
        let mut text = format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:test:{}:1.0" rts:version="0.2" xmlns:rts="http://www.openrtp.org/namespaces/rts" xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
"#,
            self.name
        );
        for component in &self.components {
            component.write(&mut text, &self.ports(&component.instance));
        }
        for (source, target) in &self.connectors {
            let end = |tag: &str, port: &str| {
                let instance = port.split_once('.').expect("Instance.port").0;
                format!(
                    r#"<rts:{tag} rts:portName="{port}" rts:instanceName="{instance}" rts:componentId=""/>"#
                )
            };
            let _ = writeln!(
                text,
                r#"<rts:DataPortConnectors rts:connectorId="{source}-{target}" rts:name="{source}-{target}" rts:dataType="IDL:RTC/TimedDouble:1.0" rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush">{}{}</rts:DataPortConnectors>"#,
                end("sourceDataPort", source),
                end("targetDataPort", target)
            );
        }
        text + &self.orders + "\n</rts:RtsProfile>\n"
    }
}

impl Component {
    fn write(&self, text: &mut String, ports: &[(&str, &str)]) {
        let (instance, type_name) = (&self.instance, &self.type_name);
        let required = !self.optional;
        let _ = writeln!(
            text,
            r#"<rts:Components xsi:type="rtsExt:component_ext" rts:instanceName="{instance}" rts:id="RTC:rtsctl:example:{type_name}:1.0" rts:pathUri="localhost/{instance}.rtc" rts:isRequired="{required}" rts:activeConfigurationSet="default">"#
        );
        for (port, kind) in ports {
            let _ = write!(
                text,
                r#"<rts:DataPorts xsi:type="rtsExt:dataport_ext" rts:name="{port}"><rtsExt:Properties rtsExt:name="port.port_type" rtsExt:value="{kind}"/><rtsExt:Properties rtsExt:name="dataport.data_type" rtsExt:value="IDL:RTC/TimedDouble:1.0"/></rts:DataPorts>"#
            );
        }
        text.push_str(r#"<rts:ConfigurationSets rts:id="default">"#);
        for (name, value) in &self.parameters {
            let _ = write!(
                text,
                r#"<rts:ConfigurationData rts:name="{name}" rts:data="{value}"/>"#
            );
        }
        text.push_str("</rts:ConfigurationSets>");
        if let Some(rate) = &self.rate {
            let _ = write!(
                text,
                r#"<rts:ExecutionContexts xsi:type="rtsExt:execution_context_ext" rts:id="0" rts:kind="PERIODIC" rts:rate="{rate}"/>"#
            );
        }
        for (name, value) in &self.properties {
            let _ = write!(
                text,
                r#"<rtsExt:Properties rtsExt:name="{name}" rtsExt:value="{value}"/>"#
            );
        }
        text.push_str("</rts:Components>\n");
    }
}
