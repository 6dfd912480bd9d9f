//! `/openapi.json`: what the handlers say of themselves, and what all of them share.

use rts_controller_api::Problem;
use rts_http::problem::PROBLEM_JSON;
use rts_http::server::{Json, Principal};
use utoipa::openapi::path::Operation;
use utoipa::openapi::{Content, OpenApi, PathItem, Ref, RefOr, Response};

/// Where the description begins.
#[derive(utoipa::OpenApi)]
#[openapi(
    info(
        title = "rts-controller",
        description = "Deploys and watches systems of RT-Components. Errors are RFC 9457 problem documents."
    ),
    components(schemas(Problem))
)]
pub struct Document;

/// This document.
#[utoipa::path(get, path = "/openapi.json", responses((status = 200, body = serde_json::Value)))]
pub async fn openapi(_: Principal) -> Json<OpenApi> {
    Json(super::openapi())
}

/// Adds the answers that every handler may give, and says of all problems what they are.
pub fn finished(mut document: OpenApi) -> OpenApi {
    for item in document.paths.paths.values_mut() {
        operations(item).for_each(finish);
    }
    document
}

fn operations(item: &mut PathItem) -> impl Iterator<Item = &mut Operation> {
    let methods = [
        &mut item.get,
        &mut item.put,
        &mut item.post,
        &mut item.delete,
    ];
    methods.into_iter().flatten()
}

fn finish(operation: &mut Operation) {
    let mut add = |status: &str, why: &str| {
        let responses = &mut operation.responses.responses;
        let missing = || RefOr::T(Response::new(why));
        responses.entry(status.to_owned()).or_insert_with(missing);
    };
    add("400", "The request cannot be understood");
    add("403", "Only the user that runs this server may use it");
    if operation.request_body.is_some() {
        add("413", "The body is too large");
        add("415", "The body is not application/json");
        add("422", "The body is understood, but invalid");
    }
    for (status, response) in &mut operation.responses.responses {
        if let (true, RefOr::T(response)) = (status.as_str() >= "400", response) {
            let problem = Content::new(Some(Ref::from_schema_name("Problem")));
            response.content.shift_remove("application/json");
            response
                .content
                .insert(PROBLEM_JSON.to_owned(), RefOr::T(problem));
        }
    }
}
