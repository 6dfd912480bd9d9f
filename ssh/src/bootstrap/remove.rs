//! Takes an installation away again, and leaves nothing.

use super::service::{Keeper, Service};
use super::{BootstrapError, steps};
use crate::copies::{Claim, service_lease};
use crate::session::Session;
use crate::survey::Survey;

/// What was removed, or would be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Removed {
    /// The service.
    pub service: Service,
    /// What was done, in words; nothing when nothing was there.
    pub done: Vec<String>,
    /// Managers that were stopped.
    pub managers: usize,
    /// What is left in the folder of rtsctl, as it is of others.
    pub left: Option<String>,
    /// Why copies stay that nobody needs, if they do.
    pub told: Vec<String>,
}

/// Removes it. Managers that run are stopped only if `yes`. With `dry_run` nothing is touched.
pub async fn remove(
    session: &Session,
    survey: &Survey,
    node: &str,
    yes: bool,
    dry_run: bool,
) -> Result<Removed, BootstrapError> {
    let mut service = Service::new(survey, node);
    let mut found = steps::look(session, &service).await?;
    let Some(record) = found.record.clone() else {
        return Ok(Removed {
            service,
            done: Vec::new(),
            managers: 0,
            left: None,
            told: Vec::new(),
        });
    };
    if record.keeper != service.keeper {
        // As it was installed: the machine may have another keeper now.
        service = Service::kept_by(record.keeper, survey, node);
        found = steps::look(session, &service).await?;
    }
    let managers = found.managers.len();
    if managers > 0 && !yes {
        let (host, node) = (session.host().to_owned(), node.to_owned());
        return Err(BootstrapError::InUse {
            host,
            node,
            managers,
        });
    }
    let is_unit = service.keeper != Keeper::Process && found.file.is_some();
    let (file, _) = service.file();
    let mut removed = Removed {
        service,
        done: Vec::new(),
        managers,
        left: None,
        told: Vec::new(),
    };
    let service = &removed.service;
    let mut done = Vec::new();
    if is_unit {
        done.push(format!("stop, disable and remove {}", service.unit_name()));
    } else if let Some((pid, _)) = &found.agent {
        done.push(format!("stop the agent (process {pid})"));
    }
    if managers > 0 {
        done.push(format!("stop {managers} manager processes"));
    }
    done.push(format!("remove all of node {node} in {}", service.home));
    if dry_run {
        removed.done = done;
        return Ok(removed);
    }
    if is_unit {
        let disable = format!("disable --now {}", service.unit_name());
        steps::systemctl(session, service.keeper, &[&disable]).await?;
    }
    let agent: Vec<u32> = found.agent.iter().map(|(pid, _)| *pid).collect();
    steps::stop(session, service, &agent, false).await?;
    // Again: an agent starts managers until it ends.
    let managers = steps::look(session, service).await?.managers;
    steps::stop(session, service, &managers, true).await?;
    // First: what is removed by then is not found when this is run again.
    let collected = session
        .collect(
            &service.home,
            Claim::Leave {
                node,
                lease: &service_lease(&service.home, node),
            },
        )
        .await?;
    let left = steps::remove(session, service, node, &file).await?;
    if is_unit {
        steps::systemctl(session, service.keeper, &["daemon-reload"]).await?;
    }
    if record.lingers && !found.others && service.keeper == Keeper::UserUnit {
        steps::linger(session, false).await?;
    }
    removed.managers = managers.len();
    removed.done = done;
    removed.left = left;
    removed.told = collected.told;
    Ok(removed)
}
