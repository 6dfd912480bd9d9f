//! Sends a system to a controller that may die meanwhile.

use std::time::{Duration, Instant};

use rts_controller_api::ClientError;
use rts_controller_api::client::Controller;
use rts_controller_api::requests::ApplyResult;

use crate::error::CliError;
use crate::input::Input;
use crate::local::relays::{because, despite_loss};

/// How long a controller that was there may be silent.
const SILENCE: Duration = Duration::from_secs(5);
/// Time between two tries.
const PAUSE: Duration = Duration::from_millis(200);

/// Sends the system. It may be sent again, so a controller that dies meanwhile is given time to come back, and so is a session
/// that was lost, until the deadline.
pub async fn put(
    input: &Input,
    controller: &Controller,
    deadline: Instant,
) -> Result<ApplyResult, CliError> {
    let what = format!("apply system/{}", input.request.spec.name);
    let end = Instant::now() + SILENCE;
    let mut again = false;
    loop {
        match despite_loss(deadline, || controller.apply(&input.request)).await {
            Err(ClientError::Unreachable { .. }) if Instant::now() < end => {
                again = true;
                tokio::time::sleep(PAUSE).await;
            }
            Err(e) if again && is_stale(&e) && is_stored(input, controller).await => {
                // The first try was stored, and its answer was lost: nobody else changed anything.
                let result = controller.apply(&input.planned()).await;
                return result.map_err(input.failed(what));
            }
            result => return result.map_err(because(input.failed(what))),
        }
    }
}

fn is_stale(error: &ClientError) -> bool {
    matches!(error, ClientError::Problem(problem) if problem.code == "stale-plan")
}

/// The very system that was sent is what is stored.
async fn is_stored(input: &Input, controller: &Controller) -> bool {
    let request = &input.request;
    let stored = controller.system(&request.spec.name).await;
    request.targets.is_empty() && stored.is_ok_and(|system| *system.spec == request.spec)
}
