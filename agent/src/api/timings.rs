//! Where the time went.

use std::time::Duration;

use axum::extract::Query;
use rts_agent_api::messages::{Timings, TimingsQuery};
use rts_agent_api::paths;
use rts_host::timing;
use rts_http::server::{Json, Principal};

/// What took how long lately.
#[utoipa::path(
    get,
    path = paths::TIMINGS,
    params(("micros" = u64, Query, description = "spans that ended within so many microseconds")),
    responses((status = 200, body = Timings))
)]
pub(super) async fn timings(_: Principal, Query(query): Query<TimingsQuery>) -> Json<Timings> {
    let kept = timing::within(Duration::from_micros(query.micros));
    Json(Timings::of(kept, timing::now()))
}
