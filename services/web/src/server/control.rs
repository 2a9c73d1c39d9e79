//! `data/control`: the plan time and confirmations, for a site that allows it.

use super::headers::not_found;
use super::served::Served;
use crate::live::{ControlError, LiveSite};
use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use std::sync::Arc;

/// A header that a form of another site cannot send.
const OWN_PAGE: &str = "x-groundplan";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetDate {
    at: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Confirm {
    global_id: String,
}

pub(super) async fn set_date(State(served): State<Served>, headers: HeaderMap, body: Bytes) -> Response {
    carry_out(served, &headers, &body, |live, SetDate { at }| live.set_date(&at)).await
}

pub(super) async fn confirm(State(served): State<Served>, headers: HeaderMap, body: Bytes) -> Response {
    carry_out(served, &headers, &body, |live, Confirm { global_id }| live.confirm(&global_id)).await
}

async fn carry_out<T: DeserializeOwned + Send + 'static>(
    served: Served,
    headers: &HeaderMap,
    body: &[u8],
    act: impl FnOnce(&dyn LiveSite, T) -> Result<(), ControlError> + Send + 'static,
) -> Response {
    let Some(live) = served.live else { return not_found() };
    if !headers.contains_key(OWN_PAGE) {
        return error(StatusCode::FORBIDDEN, "only the page itself may ask for this");
    }
    let asked: T = match serde_json::from_slice(body) {
        Ok(asked) => asked,
        Err(why) => return error(StatusCode::BAD_REQUEST, &why.to_string()),
    };
    let live: Arc<dyn LiveSite> = live;
    match tokio::task::spawn_blocking(move || act(&*live, asked)).await {
        Ok(Ok(())) => Json(json!({})).into_response(),
        Ok(Err(why @ ControlError::NotAllowed)) => error(StatusCode::FORBIDDEN, &why.to_string()),
        Ok(Err(why)) => error(StatusCode::CONFLICT, &daemon::chain(&why)),
        Err(_) => error(StatusCode::INTERNAL_SERVER_ERROR, "the work was given up"),
    }
}

fn error(status: StatusCode, why: &str) -> Response {
    (status, Json(json!({"error": why}))).into_response()
}
