//! The HTTP server: questions as paths, the OpenAPI document, MCP.

use crate::desk::Desk;
use crate::guard::Guard;
use crate::mcp::McpServer;
use crate::problem::{Problem, ProblemKind};
use crate::questions::{QUESTIONS, question};
use crate::schemas::{openapi, values_of};
use axum::body::{Body, to_bytes};
use axum::extract::{Path, Query, Request, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde_json::{Value, json};
use site_http::{BodyLimit, read_whole, tell_one_too_many};
use std::sync::Arc;

/// Longest body of a request: a call of a tool has names of 400 characters.
const MAX_REQUEST_BYTES: usize = 64 << 10;
/// Longest sentence of another part that is passed on as a problem.
const MAX_DETAIL_BYTES: usize = 1 << 10;

/// What the paths share.
#[derive(Clone)]
struct Shared {
    desk: Desk,
    /// The OpenAPI document, made once.
    openapi: Arc<Value>,
}

/// All paths.
pub(crate) fn router(desk: Desk, guard: Guard) -> Router {
    let mcp = McpServer::of(desk.clone()).over_http();
    let shared = Shared { desk, openapi: Arc::new(openapi(guard.needs_token())) };
    Router::new()
        .route("/", get(index))
        .route("/openapi.json", get(document))
        .route("/v1/{question}", get(ask))
        .route_service("/mcp", mcp)
        .fallback(|| async { problem(&Problem::of(ProblemKind::NoSuchQuestion, "see /openapi.json")) })
        .layer(middleware::from_fn_with_state(BodyLimit(MAX_REQUEST_BYTES), read_whole))
        .layer(middleware::from_fn_with_state(Arc::new(guard), check))
        .layer(middleware::from_fn(tell_one_too_many))
        .layer(middleware::from_fn(as_problems))
        .with_state(shared)
}

/// What there is.
async fn index() -> Json<Value> {
    let questions: Vec<Value> = QUESTIONS
        .iter()
        .map(|question| json!({"path": format!("/v1/{}", question.name), "title": question.title}))
        .collect();
    Json(json!({"questions": questions, "openapi": "/openapi.json", "mcp": "/mcp"}))
}

async fn document(State(shared): State<Shared>) -> Json<Value> {
    Json(Value::clone(&shared.openapi))
}

async fn ask(
    State(shared): State<Shared>,
    Path(name): Path<String>,
    query: Result<Query<Vec<(String, String)>>, axum::extract::rejection::QueryRejection>,
) -> Response {
    let answer = async {
        let Query(pairs) = query.map_err(|why| Problem::of(ProblemKind::BadParameter, why.body_text()))?;
        shared.desk.ask(&name, values_of(question(&name)?, pairs)?).await
    };
    match answer.await {
        Ok(answer) => Json(answer).into_response(),
        Err(why) => problem(&why),
    }
}

/// A problem as an answer.
fn problem(why: &Problem) -> Response {
    let status = StatusCode::from_u16(why.status()).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    let body = serde_json::to_vec(why).unwrap_or_default();
    let mut response = (status, [(header::CONTENT_TYPE, PROBLEM)], body).into_response();
    let headers = response.headers_mut();
    if status == StatusCode::SERVICE_UNAVAILABLE {
        headers.insert(header::RETRY_AFTER, HeaderValue::from_static("3"));
    }
    if status == StatusCode::UNAUTHORIZED {
        headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
    }
    response
}

const PROBLEM: &str = "application/problem+json";

/// Lets a request through, or refuses it.
async fn check(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    match guard.check(request.uri(), request.headers()) {
        Ok(()) => next.run(request).await,
        Err(why) => problem(&why),
    }
}

/// Adds the headers that all answers have, and tells what other parts refuse as problems, too; MCP has its own words.
async fn as_problems(request: Request, next: Next) -> Response {
    let is_mcp = request.uri().path() == "/mcp";
    let mut response = next.run(request).await;
    let is_problem = response.headers().get(header::CONTENT_TYPE).is_some_and(|of| of == PROBLEM);
    if !is_mcp && response.status().as_u16() >= 400 && !is_problem {
        response = of_other_part(response).await;
    }
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, "default-src 'none'; frame-ancestors 'none'"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

async fn of_other_part(response: Response) -> Response {
    let (head, body) = response.into_parts();
    let told = to_bytes(body, MAX_DETAIL_BYTES).await.unwrap_or_default();
    let words = String::from_utf8_lossy(&told).into_owned();
    let kind = ProblemKind::of_status(head.status.as_u16());
    let mut made = problem(&Problem::of(kind, if words.is_empty() { "see /openapi.json".to_owned() } else { words }));
    *made.status_mut() = head.status;
    for name in [header::ALLOW, header::CONNECTION, header::RETRY_AFTER] {
        if let Some(value) = head.headers.get(&name) {
            made.headers_mut().insert(name, value.clone());
        }
    }
    let (head, body) = made.into_parts();
    Response::from_parts(head, Body::new(body))
}
