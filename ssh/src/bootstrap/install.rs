//! Installs an agent as a service, or brings one that is there up to date.

use std::path::PathBuf;
use std::time::Duration;

use super::change::{Change, changes};
use super::found::Found;
use super::service::{Keeper, Service};
use super::{BootstrapError, Request, steps};
use crate::answer::tame;
use crate::copies::{Claim, service_lease};
use crate::session::Session;
use crate::store::{LocalFile, Stored};
use crate::survey::Survey;

/// Longest wait until the agent serves.
const SERVES: Duration = Duration::from_secs(20);
/// Longest wait for a program that says its version.
const VERSION: Duration = Duration::from_secs(10);

/// What was done, or would be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Installed {
    /// The service.
    pub service: Service,
    /// What was done.
    pub changes: Vec<Change>,
    /// Services of the account run while nobody is logged in; also said where it was not tried.
    pub lingers: bool,
    /// Why copies stay that nobody needs, if they do.
    pub told: Vec<String>,
}

/// The service with all its files, and which of these are not there.
struct Settled {
    service: Service,
    programs: Vec<LocalFile>,
    modules: Vec<LocalFile>,
    files: Stored,
    digests: Vec<String>,
    names: Vec<(String, String)>,
}

/// Installs it; `progress` is told of each change before it is made.
pub async fn install(
    session: &Session,
    survey: &Survey,
    request: &Request,
    mut progress: impl FnMut(&Change),
) -> Result<Installed, BootstrapError> {
    let service = Service::new(survey, &request.node);
    let found = steps::look(session, &service).await?;
    refuse_strangers(session, &service, &found)?;
    let settled = settle(session, survey, request, service, &found).await?;
    let service = settled.service.clone();
    let known = found.record.as_ref();
    let mut lingers = survey.linger;
    let mut record = service.record(
        settled.digests.clone(),
        settled.names.clone(),
        known.is_some_and(|record| record.lingers),
    );
    let changes = changes(
        &service,
        &settled.files.files,
        &record,
        &found,
        survey.linger,
    );
    if request.dry_run {
        return Ok(Installed {
            service,
            changes,
            lingers: true,
            told: Vec::new(),
        });
    }
    let lease = service_lease(&service.home, &service.node);
    let mut told = Vec::new();
    let is_ours = |change: &Change| matches!(change, Change::Copy(_) | Change::Forget);
    let claims = changes.iter().any(is_ours);
    if claims {
        let needed: Vec<&str> = record.digests().collect();
        let claim = Claim::Keep(&lease, &needed);
        told = session.collect(&service.home, claim).await?.told;
    }
    copy(session, &settled, &changes, &mut progress).await?;
    for change in &changes {
        if !is_ours(change) {
            progress(change);
        }
        match change {
            Change::Copy(_) | Change::Forget => {}
            Change::Stop(pid) => steps::stop(session, &service, &[*pid], false).await?,
            Change::Linger => {
                lingers = steps::linger(session, true).await?;
                record.lingers |= lingers;
            }
            Change::Write { path, text } if service.keeper == Keeper::Process => {
                steps::write(session, path, "700", text).await?;
            }
            Change::Write { path, text } => {
                steps::write(session, path, "644", text).await?;
                steps::systemctl(session, service.keeper, &["daemon-reload"]).await?;
            }
            Change::StartUnit { unit, .. } => {
                let (enable, restart) = (format!("enable {unit}"), format!("restart {unit}"));
                steps::systemctl(session, service.keeper, &[&enable, &restart]).await?;
            }
            Change::StartProcess => steps::start(session, &service).await?,
        }
    }
    // Before the wait: what does not serve can be mended and removed as well.
    if known != Some(&record) {
        let text = serde_json::to_string(&record).unwrap_or_default();
        steps::write(session, &service.record_file(), "600", &text).await?;
    }
    wait(session, &service).await?;
    if changes.contains(&Change::Forget) {
        progress(&Change::Forget);
    }
    // Also where nothing was to be copied: one that was cut off before may have left its lease.
    let collected = session.collect(&service.home, Claim::End(&lease)).await?;
    told.extend(collected.told);
    told.dedup();
    Ok(Installed {
        service,
        changes,
        lingers,
        told,
    })
}

fn refuse_strangers(
    session: &Session,
    service: &Service,
    found: &Found,
) -> Result<(), BootstrapError> {
    let ours = format!("{}/", service.programs());
    match &found.agent {
        Some((pid, program)) if !program.starts_with(&ours) => Err(BootstrapError::Taken {
            host: session.host().to_owned(),
            node: service.node.clone(),
            pid: *pid,
            program: program.clone(),
        }),
        _ => Ok(()),
    }
}

/// Looks at the files, here and there.
async fn settle(
    session: &Session,
    survey: &Survey,
    request: &Request,
    mut service: Service,
    found: &Found,
) -> Result<Settled, BootstrapError> {
    let modules: &[PathBuf] = request.modules.as_deref().unwrap_or_default();
    for file in [&request.agent, &request.manager]
        .into_iter()
        .chain(modules)
    {
        survey.check_machine(session.host(), file)?;
    }
    let programs = vec![
        LocalFile::program(&request.agent),
        LocalFile::program(&request.manager),
    ];
    let modules: Vec<LocalFile> = modules.iter().map(LocalFile::data).collect();
    let mut files = session.lacking(&programs, &service.programs()).await?;
    let digests: Vec<String> = files.files.iter().map(|file| file.digest.clone()).collect();
    let paths: Vec<String> = files.files.iter().map(|file| file.path.clone()).collect();
    let names = match &request.modules {
        Some(_) => {
            let there = session.lacking(&modules, &service.modules()).await?;
            let names = there
                .files
                .iter()
                .map(|file| (file.digest.clone(), file.name.clone()));
            let names = names.collect();
            files.files.extend(there.files);
            names
        }
        None => found
            .record
            .as_ref()
            .map(|record| record.modules.clone())
            .unwrap_or_default(),
    };
    if let [agent, manager] = paths.as_slice() {
        service.run(agent, manager, &names, &request.aliases);
    }
    Ok(Settled {
        service,
        programs,
        modules,
        files,
        digests,
        names,
    })
}

/// Copies, and sees that the programs start there before anything depends on them.
async fn copy(
    session: &Session,
    settled: &Settled,
    changes: &[Change],
    progress: &mut impl FnMut(&Change),
) -> Result<(), BootstrapError> {
    let copies = changes
        .iter()
        .filter(|change| matches!(change, Change::Copy(_)));
    copies.for_each(progress);
    session
        .store(&settled.programs, &settled.service.programs())
        .await?;
    if !settled.modules.is_empty() {
        session
            .store(&settled.modules, &settled.service.modules())
            .await?;
    }
    let new = settled
        .files
        .files
        .iter()
        .take(settled.programs.len())
        .filter(|file| file.sent);
    for program in new {
        let words = ["exec \"$1\" --version", &program.path];
        let run = session.run("a program that was copied", words[0], &words[1..]);
        let failed = |said: String| BootstrapError::CannotRun {
            host: session.host().to_owned(),
            program: program.path.clone(),
            said,
        };
        let ran = tokio::time::timeout(VERSION, run).await;
        let ran =
            ran.map_err(|_| failed(format!("it said nothing within {} s", VERSION.as_secs())))??;
        if ran.code != Some(0) {
            let out = tame(&String::from_utf8_lossy(&ran.out));
            return Err(failed(format!("{out} {}", ran.err).trim().to_owned()));
        }
    }
    Ok(())
}

async fn wait(session: &Session, service: &Service) -> Result<(), BootstrapError> {
    if steps::serves(session, service, SERVES).await? {
        return Ok(());
    }
    Err(BootstrapError::NotServing {
        host: session.host().to_owned(),
        node: service.node.clone(),
        seconds: SERVES.as_secs(),
        said: steps::log(session, service).await,
    })
}

impl Installed {
    /// What the user should know: how long the service lives, and what of it takes space for nothing.
    pub fn notes(&self) -> Vec<String> {
        let life = self.life();
        life.into_iter().chain(self.told.iter().cloned()).collect()
    }

    fn life(&self) -> Vec<String> {
        match self.service.keeper {
            Keeper::Process => vec![
                "there is no systemd for this account: the agent is a plain process, which does not come back after a reboot. This \
                 line for `crontab -e` there would start it"
                    .to_owned(),
                self.service.cron_line(),
            ],
            Keeper::UserUnit if !self.lingers => vec![
                "the service ends when the account logs out for the last time, and starts with its next login: `loginctl enable-linger` \
                 was not permitted; an administrator can do it"
                    .to_owned(),
            ],
            _ => Vec::new(),
        }
    }
}
