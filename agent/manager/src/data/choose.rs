//! Which transport a connector gets: the one that its properties name, or the best that reaches.

use rts_schemas::connector::{Distance, Interface, OutOfReach};
use rts_transport::Kind;

/// The transports to try, the best first; why there is none otherwise, and what to do about it.
pub fn choose(interface: Interface, distance: Distance) -> Result<&'static [Kind], String> {
    use Distance::{Beyond, Node, Process};
    use Kind::{InProcess, SharedMemory, Tcp, Unix};
    if let Some(OutOfReach {
        word, needs, help, ..
    }) = interface.out_of_reach(distance)
    {
        return Err(format!(
            "`dataport.interface_type` is {word}, which needs both components {needs}: {help}"
        ));
    }
    Ok(match (interface, distance) {
        (Interface::Best, Process) => &[InProcess],
        (Interface::Best, Node) => &[SharedMemory, Unix],
        // Nodes that share a machine may have networks of their own.
        (Interface::Best, Beyond) => &[Tcp, Unix],
        (Interface::Direct, _) => &[InProcess],
        (Interface::SharedMemory, _) => &[SharedMemory],
        (Interface::Unix, _) => &[Unix],
        (Interface::Tcp, _) => &[Tcp],
    })
}

/// The name of a transport as everybody sees it.
pub fn name(kind: Kind) -> &'static str {
    match kind {
        Kind::InProcess => "direct",
        kind => kind.name(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_that_reaches_is_first() {
        let best = |distance| choose(Interface::Best, distance).unwrap()[0];
        assert_eq!(best(Distance::Process), Kind::InProcess);
        assert_eq!(best(Distance::Node), Kind::SharedMemory);
        assert_eq!(best(Distance::Beyond), Kind::Tcp);
    }

    #[test]
    fn what_is_named_is_taken_or_refused_with_a_way_out() {
        for (interface, kind, reaches) in [
            (Interface::Direct, Kind::InProcess, 1),
            (Interface::SharedMemory, Kind::SharedMemory, 2),
            (Interface::Unix, Kind::Unix, 2),
            (Interface::Tcp, Kind::Tcp, 3),
        ] {
            let distances = [Distance::Process, Distance::Node, Distance::Beyond];
            for (at, distance) in distances.into_iter().enumerate() {
                match choose(interface, distance) {
                    Ok(kinds) => assert!(at < reaches && kinds == [kind], "{kinds:?}"),
                    Err(why) => {
                        assert!(at >= reaches, "{why}");
                        assert!(why.contains("place both"), "{why}");
                        assert!(why.contains("or choose"), "{why}");
                    }
                }
            }
        }
    }
}
