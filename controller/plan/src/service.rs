//! Which end of a service connector provides.

use rts_schemas::system::{ConnectorSpec, PortRef};

/// The end that provides the interfaces of a service connector. None when its properties do not say so, or when each
/// end provides something to the other: the ends as written say nothing.
///
/// OpenRTM-aist keeps the binding as properties: `Inst0.port.svc.required.TYPE.NAME` with the value
/// `Other0.port.svc.provided.TYPE.NAME`; a key with `.provided.` stands for an interface of that end.
pub fn service_provider(spec: &ConnectorSpec) -> Option<&PortRef> {
    let ends = [&spec.source, &spec.target];
    let mut provides = [false; 2];
    for (key, value) in &spec.properties {
        for (end, port) in ends.into_iter().enumerate() {
            match role(key, port) {
                Some("required") => provides[1 - end] = true,
                Some("provided") => provides[end] = true,
                _ => {}
            }
            if role(value, port) == Some("provided") {
                provides[end] = true;
            }
        }
    }
    match provides {
        [true, false] => Some(&spec.source),
        [false, true] => Some(&spec.target),
        _ => None,
    }
}

/// `required` or `provided`, in the name of an interface at a port.
fn role<'a>(name: &'a str, port: &PortRef) -> Option<&'a str> {
    let rest = name.strip_prefix(port.instance.as_str())?;
    let rest = rest.strip_prefix(".port.")?;
    let rest = rest.strip_prefix(port.port.as_str())?.strip_prefix('.')?;
    rest.split('.').next()
}

#[cfg(test)]
mod tests {
    use rts_schemas::system::ConnectorSpec;
    use serde_json::json;

    use super::service_provider;

    fn provider(properties: &[(&str, &str)]) -> Option<String> {
        let properties: serde_json::Map<String, serde_json::Value> = properties
            .iter()
            .map(|(key, value)| ((*key).to_owned(), json!(value)))
            .collect();
        let spec: ConnectorSpec = serde_json::from_value(json!({
            "name": "C0.svc-P0.svc", "kind": "service",
            "source": {"instance": "C0", "port": "svc"},
            "target": {"instance": "P0", "port": "svc"},
            "properties": properties,
        }))
        .unwrap();
        service_provider(&spec).map(ToString::to_string)
    }

    const REQUIRED: (&str, &str) = (
        "C0.port.svc.required.ssr::Simulator.Simulator",
        "P0.port.svc.provided.ssr::Simulator.Simulator",
    );

    #[test]
    fn whoever_requires_consumes() {
        assert_eq!(provider(&[REQUIRED]).as_deref(), Some("P0.svc"));
        let key_alone = (REQUIRED.0, "");
        assert_eq!(provider(&[key_alone]).as_deref(), Some("P0.svc"));
    }

    #[test]
    fn an_interface_that_is_provided_is_enough() {
        assert_eq!(provider(&[(REQUIRED.1, "")]).as_deref(), Some("P0.svc"));
        let source = "C0.port.svc.provided.A.a";
        assert_eq!(provider(&[(source, "")]).as_deref(), Some("C0.svc"));
    }

    #[test]
    fn nothing_is_guessed() {
        assert_eq!(provider(&[]), None);
        let others = [
            ("port.port_type", "CorbaPort"),
            ("port.connection.strictness", "strict"),
            ("C00.port.svc.required.A.a", "P0.port.svc2.provided.A.a"),
            ("C0.port.svc.requiredness", "x"),
        ];
        assert_eq!(provider(&others), None);
    }

    #[test]
    fn who_provides_to_each_other_has_no_order() {
        let back = ("P0.port.svc.required.B.b", "C0.port.svc.provided.B.b");
        assert_eq!(provider(&[REQUIRED, back]), None);
    }
}
