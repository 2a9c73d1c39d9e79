//! `data/control`: the plan time and confirmations, for a site that allows it.

use super::headers::{OWN_PAGE, not_found};
use super::served::Served;
use crate::live::{ControlError, LiveSite};
use axum::Json;
use axum::body::Bytes;
use axum::extract::{ConnectInfo, FromRequestParts, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use std::fmt::Debug;
use std::net::SocketAddr;
use std::sync::Arc;
use tracing::{info, warn};

/// Characters of a header that are logged.
const MAX_LOGGED: usize = 200;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SetDate {
    at: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Confirm {
    global_id: String,
}

/// Who asks, for the log.
pub(super) struct Viewer {
    address: SocketAddr,
    /// For whom a proxy asks, as it says.
    forwarded_for: Option<String>,
}

impl<S: Send + Sync> FromRequestParts<S> for Viewer {
    type Rejection = <ConnectInfo<SocketAddr> as FromRequestParts<S>>::Rejection;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let ConnectInfo(address) = ConnectInfo::from_request_parts(parts, state).await?;
        let named = ["x-forwarded-for", "forwarded"].into_iter().find_map(|name| parts.headers.get(name));
        let text = named.map(|value| String::from_utf8_lossy(value.as_bytes()).chars().take(MAX_LOGGED).collect());
        Ok(Self { address, forwarded_for: text })
    }
}

pub(super) async fn set_date(
    State(served): State<Served>,
    viewer: Viewer,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    carry_out(served, viewer, &headers, &body, |live, SetDate { at }| live.set_date(at)).await
}

pub(super) async fn confirm(State(served): State<Served>, viewer: Viewer, headers: HeaderMap, body: Bytes) -> Response {
    carry_out(served, viewer, &headers, &body, |live, Confirm { global_id }| live.confirm(global_id)).await
}

async fn carry_out<T: DeserializeOwned + Debug + Send + 'static>(
    served: Served,
    viewer: Viewer,
    headers: &HeaderMap,
    body: &[u8],
    act: impl FnOnce(&dyn LiveSite, &T) -> Result<(), ControlError> + Send + 'static,
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
    let worked = tokio::task::spawn_blocking(move || {
        let done = act(&*live, &asked);
        log(&viewer, &asked, done.as_ref().err());
        done
    });
    match worked.await {
        Ok(Ok(())) => Json(json!({})).into_response(),
        Ok(Err(why @ ControlError::NotAllowed)) => error(StatusCode::FORBIDDEN, &why.to_string()),
        Ok(Err(why)) => error(StatusCode::CONFLICT, &daemon::chain(&why)),
        Err(_) => error(StatusCode::INTERNAL_SERVER_ERROR, "the work was given up"),
    }
}

/// Says who asked for what. Texts of viewers are quoted, so that they begin no line of their own.
fn log<T: Debug>(viewer: &Viewer, asked: &T, failed: Option<&ControlError>) {
    let Viewer { address, forwarded_for } = viewer;
    let service = "groundplan-web";
    match failed {
        None => info!(service, viewer = %address, ?forwarded_for, ?asked, "a viewer changed the site"),
        Some(why) => {
            let error = daemon::chain(why);
            warn!(service, viewer = %address, ?forwarded_for, ?asked, error, "a viewer was refused");
        }
    }
}

fn error(status: StatusCode, why: &str) -> Response {
    (status, Json(json!({"error": why}))).into_response()
}
