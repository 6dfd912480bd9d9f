//! How far what a connector is to travel by reaches.

use super::Interface;

/// Where the in-port is, as seen from the out-port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Distance {
    /// In the same process.
    Process,
    /// In another process of the node.
    Node,
    /// On another node.
    Beyond,
}

/// Why an interface type does not reach.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutOfReach {
    /// Code of the finding.
    pub code: &'static str,
    /// The interface type.
    pub word: &'static str,
    /// Where both components must be.
    pub needs: &'static str,
    /// How to mend it.
    pub help: &'static str,
}

impl Interface {
    /// Why it does not reach so far; none when it does.
    pub fn out_of_reach(self, distance: Distance) -> Option<OutOfReach> {
        let (word, farthest) = match self {
            Self::Best | Self::Tcp => return None,
            Self::Direct => ("direct", Distance::Process),
            Self::SharedMemory => ("shm", Distance::Node),
            Self::Unix => ("uds", Distance::Node),
        };
        let (code, needs, help) = match farthest {
            Distance::Process => (
                "direct-across-processes",
                "in one process",
                "place both in one manager, or choose corba_cdr",
            ),
            _ => (
                "interface-across-nodes",
                "on one node",
                "place both on one node, or choose tcp or corba_cdr",
            ),
        };
        (distance > farthest).then_some(OutOfReach {
            code,
            word,
            needs,
            help,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reaches_as_far_as_it_can() {
        use Distance::{Beyond, Node, Process};
        for (interface, farthest) in [
            (Interface::Best, Beyond),
            (Interface::Tcp, Beyond),
            (Interface::SharedMemory, Node),
            (Interface::Unix, Node),
            (Interface::Direct, Process),
        ] {
            for distance in [Process, Node, Beyond] {
                let fault = interface.out_of_reach(distance);
                assert_eq!(
                    fault.is_none(),
                    distance <= farthest,
                    "{interface:?} {fault:?}"
                );
            }
        }
    }
}
