//! The HTTP server: the page, its documents, live events, control.
//!
//! Requests name dates, storeys and hashes, and never a file. Everything is read-only but `data/control`, which only a site that
//! allows it has.

mod access;
mod compression;
mod control;
mod events;
mod headers;
mod paths;
mod served;

pub(crate) use served::{MAX_VIEWERS, Served};

use crate::page::{FILES, INDEX, PageFile};
use crate::question::Question;
use crate::source::{Bytes, ContentName, SourceError};
use access::Door;
use axum::Router;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use headers::{Caching, document, not_found};
use site_http::{BodyLimit, read_whole, tell_one_too_many};
use std::sync::Arc;

/// Longest body of a request.
const MAX_REQUEST_BYTES: usize = 4096;

/// All paths.
pub(crate) fn router(served: Served, is_encrypted: bool) -> Router {
    let mut router = Router::new().route("/", get(|headers: HeaderMap| page_file(headers, INDEX)));
    for file in FILES {
        router = router.route(&format!("/{}", file.path), get(move |headers: HeaderMap| page_file(headers, file)));
    }
    let door = Door { access: Arc::clone(&served.access), is_encrypted };
    router
        .route("/data/site.json", get(site))
        .route("/data/calendar.json", get(calendar))
        .route("/data/dates/{file}", get(date))
        .route("/data/tasks.json", get(tasks))
        .route("/data/summary/{file}", get(summary))
        .route("/data/tiles/{storey}/{layer}/{name}/{level}/{column}/{row}", get(tile))
        .route("/data/models/{file}", get(model))
        .route("/data/room/{room}", get(about_room))
        .route("/data/door/{door}", get(about_door))
        .route("/data/way/{from}/{to}", get(about_way))
        .route("/data/slam/{file}", get(slam_picture))
        .route("/data/fleet.json", get(fleet))
        .route("/data/events", get(events::events))
        .route("/data/control/date", post(control::set_date))
        .route("/data/control/confirm", post(control::confirm))
        .fallback(|_: Uri| async { not_found() })
        .layer(middleware::from_fn_with_state(BodyLimit(MAX_REQUEST_BYTES), read_whole))
        .layer(middleware::from_fn_with_state(door, access::check))
        .layer(middleware::from_fn(tell_one_too_many))
        .layer(middleware::from_fn(headers::with_security_headers))
        .with_state(served)
}

async fn page_file(headers: HeaderMap, file: PageFile) -> Response {
    answer(headers, file.media_type, Caching::Checked, move || Ok(Some(Bytes::from(file.bytes)))).await
}

async fn site(State(served): State<Served>, headers: HeaderMap) -> Response {
    answer(headers, JSON, Caching::Checked, move || served.source.site().map(Some)).await
}

async fn calendar(State(served): State<Served>, headers: HeaderMap) -> Response {
    answer(headers, JSON, Caching::Checked, move || served.source.calendar().map(Some)).await
}

async fn date(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(key) = file.strip_suffix(".json").map(str::to_owned) else { return not_found() };
    answer(headers, JSON, Caching::Checked, move || served.source.date(&key)).await
}

async fn tasks(State(served): State<Served>, headers: HeaderMap) -> Response {
    answer(headers, JSON, Caching::Checked, move || served.source.tasks().map(Some)).await
}

async fn summary(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(key) = file.strip_suffix(".json").map(str::to_owned) else { return not_found() };
    answer(headers, JSON, Caching::Checked, move || served.source.summary(&key)).await
}

async fn tile(
    State(served): State<Served>,
    Path(path): Path<(u32, String, String, u32, u32, String)>,
    headers: HeaderMap,
) -> Response {
    let Some(address) = paths::tile_address(path) else { return not_found() };
    answer(headers, PNG, Caching::Forever, move || served.source.tile(&address)).await
}

async fn model(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(name) = file.strip_suffix(".glb").and_then(ContentName::parse) else { return not_found() };
    answer(headers, "model/gltf-binary", Caching::Forever, move || served.source.model(&name)).await
}

async fn about_room(State(served): State<Served>, Path(room): Path<String>, headers: HeaderMap) -> Response {
    asked(served, headers, Question::Room(room)).await
}

async fn about_door(State(served): State<Served>, Path(door): Path<String>, headers: HeaderMap) -> Response {
    asked(served, headers, Question::Door(door)).await
}

async fn about_way(State(served): State<Served>, Path(ends): Path<[String; 2]>, headers: HeaderMap) -> Response {
    asked(served, headers, Question::Way(ends)).await
}

async fn asked(served: Served, headers: HeaderMap, question: Question) -> Response {
    if !question.is_short() {
        return (StatusCode::URI_TOO_LONG, "no room, door or point has such a long name").into_response();
    }
    answer(headers, JSON, Caching::Checked, move || served.source.answer(&question).map(Some)).await
}

async fn slam_picture(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(name) = file.strip_suffix(".png").and_then(ContentName::parse) else { return not_found() };
    let Some(live) = served.live else { return not_found() };
    answer(headers, PNG, Caching::Forever, move || Ok(live.slam_picture(&name))).await
}

async fn fleet(State(served): State<Served>, headers: HeaderMap) -> Response {
    let Some(live) = served.live else { return not_found() };
    let made = tokio::task::spawn_blocking(move || live.fleet()).await;
    match made {
        Ok(Ok(Some(bytes))) => document(&headers, &bytes, JSON, Caching::Checked),
        Ok(Ok(None)) => not_found(),
        Ok(Err(why)) => (StatusCode::SERVICE_UNAVAILABLE, daemon::chain(why.as_ref())).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the work was given up").into_response(),
    }
}

const JSON: &str = "application/json";
const PNG: &str = "image/png";

/// Makes an answer on a thread for work that takes its time.
async fn answer(
    headers: HeaderMap,
    media_type: &'static str,
    caching: Caching,
    make: impl FnOnce() -> Result<Option<Bytes>, SourceError> + Send + 'static,
) -> Response {
    let made = tokio::task::spawn_blocking(move || {
        let made = make();
        made.map(|bytes| bytes.map(|bytes| document(&headers, &bytes, media_type, caching)))
    });
    match made.await {
        Ok(Ok(Some(document))) => document,
        Ok(Ok(None)) => not_found(),
        Ok(Err(why @ SourceError::NotYet)) => (StatusCode::SERVICE_UNAVAILABLE, why.to_string()).into_response(),
        Ok(Err(why @ (SourceError::Unknown(_) | SourceError::NotHeld { .. }))) => {
            (StatusCode::NOT_FOUND, why.to_string()).into_response()
        }
        Ok(Err(why @ SourceError::Changed { .. })) => (StatusCode::CONFLICT, why.to_string()).into_response(),
        Ok(Err(why)) => {
            tracing::error!(service = "groundplan-web", error = daemon::chain(&why), "a document cannot be made");
            (
                StatusCode::INTERNAL_SERVER_ERROR,
                [(header::CONTENT_TYPE, "text/plain; charset=utf-8")],
                daemon::chain(&why),
            )
                .into_response()
        }
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the work was given up").into_response(),
    }
}

#[cfg(test)]
mod tests;
