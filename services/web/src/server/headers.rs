//! Headers of answers: caching, and what a browser may do with the page.

use super::compression::{gzip, is_compressible, takes_gzip};
use crate::source::Bytes;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use messages::ContentId;

/// A header of the page and its server alone, which a form of another site cannot send.
pub(super) const OWN_PAGE: &str = "x-groundplan";

/// Scripts, styles and data from this server alone; pictures also from memory, as the page draws them. No page may hold it in a
/// frame, and no form leads anywhere.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// How long an answer may be kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Caching {
    /// Its address names its content.
    Forever,
    /// It is asked for each time, and sent only if it has changed.
    Checked,
}

/// Adds the headers that all answers have.
pub(crate) async fn with_security_headers(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (header::HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

/// A document, or that the browser has it already.
pub(crate) fn document(asked: &HeaderMap, bytes: &Bytes, media_type: &'static str, caching: Caching) -> Response {
    // Weak: compressed or not, it is the same document.
    let tag = format!("W/\"{}\"", ContentId::of(bytes).short());
    let keep = match caching {
        Caching::Forever => "private, max-age=31536000, immutable",
        Caching::Checked => "no-cache",
    };
    let is_known = asked.get_all(header::IF_NONE_MATCH).iter().any(|known| names(known, &tag));
    let mut headers = HeaderMap::from_iter([
        (header::ETAG, HeaderValue::from_str(&tag).expect("digits are a header")),
        (header::CACHE_CONTROL, HeaderValue::from_static(keep)),
        (header::CONTENT_TYPE, HeaderValue::from_static(media_type)),
    ]);
    let is_compressible = is_compressible(media_type, bytes.len());
    if is_compressible {
        headers.insert(header::VARY, HeaderValue::from_static("Accept-Encoding"));
    }
    if is_known {
        return (StatusCode::NOT_MODIFIED, headers).into_response();
    }
    if is_compressible && takes_gzip(asked) {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        return (headers, Body::from(gzip(bytes))).into_response();
    }
    (headers, Body::from(bytes.to_vec())).into_response()
}

/// True if a list of tags has this one, weak or not.
fn names(known: &HeaderValue, tag: &str) -> bool {
    let opaque = |tag: &str| tag.trim().trim_start_matches("W/").to_owned();
    known.to_str().is_ok_and(|list| list.split(',').any(|known| opaque(known) == opaque(tag)))
}

/// There is no such thing.
pub(crate) fn not_found() -> Response {
    (StatusCode::NOT_FOUND, "there is no such document").into_response()
}
