//! Bodies of requests: short, and there within their time.

use axum::body::{Body, to_bytes};
use axum::extract::Request;
use axum::http::StatusCode;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::time::Duration;

/// Longest body of a request.
const MAX_REQUEST_BYTES: usize = 4096;
/// Time in which the head of a request has to be there, and then its body.
pub(super) const REQUEST_TIMEOUT: Duration = Duration::from_secs(10);

/// Reads the whole body before anything is done, whatever is asked for.
pub(super) async fn read_whole(request: Request, next: Next) -> Response {
    let (head, body) = request.into_parts();
    match tokio::time::timeout(REQUEST_TIMEOUT, to_bytes(body, MAX_REQUEST_BYTES)).await {
        Ok(Ok(body)) => next.run(Request::from_parts(head, Body::from(body))).await,
        Ok(Err(_)) => {
            (StatusCode::PAYLOAD_TOO_LARGE, "the body of the request is too long, or broken off").into_response()
        }
        Err(_) => (StatusCode::REQUEST_TIMEOUT, "the body of the request did not come in time").into_response(),
    }
}
