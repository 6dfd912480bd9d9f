//! Activate, deactivate and reset by hand.

use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::messages::Acted;
use rts_http::problem::Problem;
use rts_manager_api::control::RequestBody;
use rts_plan::desired::PlacedComponent;
use rts_plan::observed::{ComponentObserved, LifeCycleState};
use rts_plan::target;
use rts_schemas::system::{DriftPolicy, ExecutionKind};

use super::super::LIMIT;
use super::super::answers::{link, step};
use crate::agent::Agent;
use crate::execute::Verb;
use crate::execute::activate::activate;

/// Most time for an activation; whoever asks over HTTP waits a little longer.
const LONGEST: Duration = Duration::from_secs(20);

impl Agent {
    pub(super) async fn activate_by_hand(
        self: &Arc<Self>,
        instance: &str,
        dry_run: bool,
    ) -> Result<Acted, Problem> {
        let subject = self.subject(instance).await?;
        let (node, target) = (&self.config.node, target::component(instance));
        refuse_error(&subject.component)?;
        refuse_created(&subject.component)?;
        if subject.component.state == LifeCycleState::Active {
            return Ok(subject.unchanged(node, target));
        }
        if !dry_run {
            let verb = Verb {
                agent: self.clone(),
                system: subject.component.system.clone(),
                limit: self.patience(&subject.component),
            };
            let key = &subject.manager.key;
            let activated = activate(&verb, key, instance.to_owned()).await;
            activated.map_err(step)?;
        }
        if subject.component.system.is_some() && subject.wanted.is_none() {
            return Ok(subject.drifted(node, target, dry_run));
        }
        Ok(subject.changed(node, target, dry_run))
    }

    /// How long `on_activated` may take while a person waits for it.
    fn patience(&self, component: &ComponentObserved) -> Duration {
        let policies = self.policies();
        let set = policies.start_timeout(component.system.as_ref(), &component.instance);
        set.min(LONGEST)
    }

    pub(super) async fn deactivate_by_hand(
        self: &Arc<Self>,
        instance: &str,
        dry_run: bool,
    ) -> Result<Acted, Problem> {
        let subject = self.subject(instance).await?;
        let (node, target) = (&self.config.node, target::component(instance));
        refuse_error(&subject.component)?;
        refuse_created(&subject.component)?;
        // One that is Inactive for another reason is not left so, unless a person says it.
        let by_hand = subject.mark(|wanted| wanted.component.settings_digest());
        let is_marked = subject.component.by_hand.deactivated.is_some();
        let is_so = subject.component.state == LifeCycleState::Inactive;
        if is_so && (is_marked || by_hand.is_none()) {
            return Ok(subject.unchanged(node, target));
        }
        if !dry_run {
            let request = RequestBody::Deactivate {
                instance: instance.to_owned(),
                by_hand,
            };
            let done = subject.manager.link.done(request, LIMIT).await;
            done.map_err(link)?;
        }
        let mut acted = subject.drifted(node, target, dry_run);
        if acted.policy == Some(DriftPolicy::Adopt) {
            acted.policy = Some(DriftPolicy::Ignore);
            acted.notes = vec![format!(
                "no profile can say that {instance} is Inactive, so that it is not adopted, but left so until it is activated or made again"
            )];
        }
        Ok(acted)
    }

    pub(super) async fn reset_by_hand(
        self: &Arc<Self>,
        instance: &str,
        dry_run: bool,
    ) -> Result<Acted, Problem> {
        let subject = self.subject(instance).await?;
        let (node, target) = (&self.config.node, target::component(instance));
        refuse_created(&subject.component)?;
        match subject.component.state {
            LifeCycleState::Inactive => return Ok(subject.unchanged(node, target)),
            LifeCycleState::Error => {}
            LifeCycleState::Created | LifeCycleState::Active => {
                return Err(wrong_state(format!(
                    "{instance} is Active: there is nothing to reset"
                )));
            }
        }
        if !dry_run {
            let request = RequestBody::Reset {
                instance: instance.to_owned(),
            };
            let done = subject.manager.link.done(request, LIMIT).await;
            done.map_err(link)?;
        }
        let mut acted = subject.changed(node, target, dry_run);
        let note = |(system, _): (&String, &PlacedComponent)| {
            format!("system {system} activates it again")
        };
        let wanted = subject.wanted.as_ref().map(|wanted| &wanted.component);
        acted.notes = acted.system.iter().zip(wanted).map(note).collect();
        Ok(acted)
    }

    pub(super) async fn tick_by_hand(
        self: &Arc<Self>,
        instance: &str,
        cycles: u32,
        dry_run: bool,
    ) -> Result<Acted, Problem> {
        let subject = self.subject(instance).await?;
        let (node, target) = (&self.config.node, target::component(instance));
        let kind = match subject.component.execution_kind {
            ExecutionKind::Other => None,
            ExecutionKind::Periodic => Some("periodic"),
            ExecutionKind::EventDriven => Some("event-driven"),
        };
        if let Some(kind) = kind {
            return Err(wrong_state(format!(
                "the execution context of {instance} is {kind} and runs by itself; only one of the kind OTHER is ticked"
            )));
        }
        if subject.component.state != LifeCycleState::Active {
            return Err(wrong_state(format!(
                "{instance} is {:?}: only what is Active runs cycles",
                subject.component.state
            )));
        }
        if !dry_run {
            let request = RequestBody::Tick {
                instance: instance.to_owned(),
                cycles,
            };
            let done = subject.manager.link.done(request, LIMIT).await;
            done.map_err(link)?;
        }
        Ok(subject.changed(node, target, dry_run))
    }
}

fn wrong_state(detail: String) -> Problem {
    Problem::conflict("wrong-state", detail)
}

fn refuse_created(component: &ComponentObserved) -> Result<(), Problem> {
    match component.state {
        LifeCycleState::Created => Err(wrong_state(format!(
            "{} is not initialised yet",
            component.instance
        ))),
        _ => Ok(()),
    }
}

fn refuse_error(component: &ComponentObserved) -> Result<(), Problem> {
    if component.state != LifeCycleState::Error {
        return Ok(());
    }
    let name = &component.instance;
    let why = component.message.iter().map(|why| format!(" ({why})"));
    Err(wrong_state(format!(
        "{name} is in Error{}: reset it first: rtsctl reset {name}",
        why.collect::<String>()
    )))
}
