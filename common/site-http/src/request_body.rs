//! Bodies of requests: short, and there within their time.

use axum::body::{Body, to_bytes};
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::time::Duration;

/// Longest body of a request, in bytes.
#[derive(Debug, Clone, Copy)]
pub struct BodyLimit(pub usize);

/// Time in which the head of a request has to be there, and then its body.
pub const REQUEST_TIMEOUT: Duration = Duration::from_secs(10);

/// Reads the whole body before anything is done, whatever is asked for.
pub async fn read_whole(State(BodyLimit(max_bytes)): State<BodyLimit>, request: Request, next: Next) -> Response {
    let (head, body) = request.into_parts();
    match tokio::time::timeout(REQUEST_TIMEOUT, to_bytes(body, max_bytes)).await {
        Ok(Ok(body)) => next.run(Request::from_parts(head, Body::from(body))).await,
        Ok(Err(_)) => {
            (StatusCode::PAYLOAD_TOO_LARGE, "the body of the request is too long, or broken off").into_response()
        }
        Err(_) => (StatusCode::REQUEST_TIMEOUT, "the body of the request did not come in time").into_response(),
    }
}
