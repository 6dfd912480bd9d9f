//! The user applies the change.

use std::sync::Arc;
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent_api::ClientError;
use rts_controller::Core;
use rts_controller::simulator::Scenario;
use rts_controller_api::Problem;
use rts_controller_api::requests::ApplyResult;
use tokio::time::sleep;

use super::record::Record;
use crate::fleet::SimUser;
use crate::world::World;

/// Time between two tries to apply.
const AGAIN: Duration = Duration::from_millis(500);

/// Applies as rtsctl does, again and again while that may help.
pub async fn apply(
    world: Arc<World>,
    record: Record,
    scenario: &Scenario,
) -> Result<ApplyResult, Problem> {
    let user = SimUser::new(&world.hosts);
    let name = scenario.request.spec.name.clone();
    let mut told = false;
    loop {
        let request = scenario.request.clone();
        let of = name.clone();
        let work = move |core: Arc<Core>| -> BoxFuture<'static, _> {
            let (name, request) = (of.clone(), request.clone());
            Box::pin(async move { rts_controller::apply(&core, &name, request, None).await })
        };
        let why = match user.ask(work).await {
            Ok(result) => return Ok(result),
            Err(ClientError::Problem(problem)) if !problem.retryable => return Err(problem),
            Err(ClientError::Problem(problem)) => problem.detail,
            Err(error) => error.to_string(),
        };
        if !std::mem::replace(&mut told, true) {
            let object = format!("system/{name}");
            let text = format!("not applied yet, and tried again: {why}");
            record.tell(world.truth.now(), &object, "ApplyFailed", text);
        }
        sleep(AGAIN).await;
    }
}
