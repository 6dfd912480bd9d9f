//! Stand-ins for components whose module is not to be had.

use std::path::{Path, PathBuf};

use rts_controller_api::requests::Expect;
use rts_schemas::diagnostic::{Report, Severity};
use rts_schemas::stand_in;
use rts_schemas::system::{StandIn, SystemSpec};

use super::read;
use crate::error::CliError;
use crate::library;
use crate::output::Output;
use crate::show::findings;

/// Which components may be stand-ins.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct StandInArgs {
    /// Let a stand-in take the place of each component whose module is not to be had, unless its profile or an overlay
    /// says otherwise (`standIn`)
    #[arg(long)]
    pub stand_ins: bool,
    /// Refuse (exit 3) if more than N components would be stand-ins
    #[arg(long, value_name = "N")]
    max_stand_ins: Option<u32>,
    /// An RTC Profile, or a folder of them: from there stand-ins have their ports, parameters and rates (may be repeated)
    #[arg(long, value_name = "PATH")]
    pub(super) rtc: Vec<PathBuf>,
}

impl StandInArgs {
    /// Says what components do not say themselves.
    pub(super) fn lay(&self, spec: &mut SystemSpec, out: &Output) -> Result<(), CliError> {
        if self.stand_ins {
            for component in &mut spec.components {
                component.stand_in.when.get_or_insert(StandIn::Missing);
            }
        }
        if self.rtc.is_empty() {
            return Ok(());
        }
        let mut failed = None;
        let mut bytes = |path: &Path| match read(path) {
            Ok(bytes) => Some(bytes),
            Err(error) => {
                failed.get_or_insert(error);
                None
            }
        };
        let mut report = Report::default();
        let library = library::read(&self.rtc, &mut bytes, &mut report, out);
        // What nobody asked for by its name, and is no RTC Profile, is no news here.
        report.findings.retain(|f| f.severity != Severity::Note);
        findings::print(&report, out);
        if let Some(error) = failed {
            return Err(error);
        }
        let may_be = |component: &&mut _| may_be(component);
        for component in spec.components.iter_mut().filter(may_be) {
            component.stand_in.profile = stand_in::facts(&library, component);
        }
        Ok(())
    }

    pub(super) fn expect(&self) -> Expect {
        Expect {
            max_stand_ins: self.max_stand_ins,
            ..Expect::default()
        }
    }
}

fn may_be(component: &rts_schemas::system::ComponentSpec) -> bool {
    component.stand_in.policy() != StandIn::Never
}
