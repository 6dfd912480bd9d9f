//! Invariants: what holds in every run, whatever goes wrong. Each is a witness of its own that sees everything that happens.
//!
//! What happens is told by machines, disks and the network; what users asked for is told to [`Desired`] by whoever plays
//! them. The first violation ends a run ([`Verdicts::broken`]).

mod acknowledged_kept;
mod desired;
#[cfg(test)]
mod fixtures;
mod hard_orders;
mod lives;
mod one_incarnation;
mod prerequisites;
mod settled_untouched;
mod stale_epoch;
mod verdicts;

use crate::truth::Truth;

pub use acknowledged_kept::AcknowledgedKept;
pub use desired::Desired;
pub use one_incarnation::OneIncarnation;
pub use prerequisites::Prerequisites;
pub use settled_untouched::SettledUntouched;
pub use stale_epoch::StaleEpoch;
pub use verdicts::{Verdicts, Violation};

/// Looks at every invariant from now on.
pub fn watch(truth: &Truth, desired: &Desired) -> Verdicts {
    let verdicts = Verdicts::default();
    // The one who takes notes is first: the others read what he wrote.
    truth.show(desired.clone());
    truth.show(OneIncarnation::new(verdicts.clone()));
    truth.show(Prerequisites::new(desired.clone(), verdicts.clone()));
    truth.show(SettledUntouched::new(desired.clone(), verdicts.clone()));
    truth.show(AcknowledgedKept::new(desired.clone(), verdicts.clone()));
    truth.show(StaleEpoch::new(desired.clone(), verdicts.clone()));
    verdicts
}
