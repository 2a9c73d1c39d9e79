//! Admission of viewers: users of the machine itself, or holders of the token.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use site_http::{Access, bearer_token, host_of, is_own_name};
use std::sync::Arc;

/// Name of the cookie that carries the token.
const COOKIE: &str = "groundplan_token";

/// What becomes of a request.
fn verdict_of(access: &Access, uri: &Uri, headers: &HeaderMap) -> Verdict {
    match access {
        Access::OwnMachine if host_of(uri, headers).is_some_and(is_own_name) => Verdict::Allowed,
        Access::OwnMachine => Verdict::Refused("this address serves its own machine alone"),
        Access::Token(_) => {
            let of_query = uri.query().into_iter().flat_map(|query| query.split('&'));
            if let Some(token) = of_query.filter_map(|pair| pair.strip_prefix("token=")).next() {
                return if access.is_token(token) {
                    Verdict::Welcome(token.to_owned())
                } else {
                    Verdict::Refused("this is not the token")
                };
            }
            let cookies = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
            let mut tokens = cookies
                .flat_map(|cookie| cookie.split(';'))
                .filter_map(|pair| pair.trim().strip_prefix(COOKIE)?.strip_prefix('='));
            if tokens.any(|token| access.is_token(token))
                || bearer_token(headers).is_some_and(|token| access.is_token(token))
            {
                Verdict::Allowed
            } else {
                Verdict::Refused("open the address with ?token= and the token that was printed when it was made")
            }
        }
    }
}

#[derive(Debug, PartialEq, Eq)]
enum Verdict {
    Allowed,
    /// The token came in the address: it goes into a cookie, and out of the address.
    Welcome(String),
    Refused(&'static str),
}

/// Who may look, and how.
#[derive(Debug, Clone)]
pub(super) struct Door {
    pub(super) access: Arc<Access>,
    /// True if the server itself encrypts.
    pub(super) is_encrypted: bool,
}

/// Lets a request through, or refuses it.
pub(super) async fn check(State(door): State<Door>, request: Request, next: Next) -> Response {
    let Door { access, is_encrypted } = door;
    match verdict_of(&access, request.uri(), request.headers()) {
        Verdict::Allowed => next.run(request).await,
        Verdict::Welcome(token) => {
            // A browser sends it back encrypted alone, where it came encrypted.
            let secure = if is_encrypted || was_encrypted(request.headers()) { "; Secure" } else { "" };
            let cookie = format!("{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict; Max-Age=31536000{secure}");
            match HeaderValue::from_str(&cookie) {
                Ok(cookie) => {
                    let path = HeaderValue::from_str(request.uri().path()).unwrap_or(HeaderValue::from_static("/"));
                    (StatusCode::SEE_OTHER, [(header::SET_COOKIE, cookie), (header::LOCATION, path)]).into_response()
                }
                Err(_) => refused("this is not the token"),
            }
        }
        Verdict::Refused(why) => refused(why),
    }
}

/// True if a proxy says that the viewer came by https. Who says so of itself has only its own cookie by it.
fn was_encrypted(headers: &HeaderMap) -> bool {
    let text = |name: &str| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
    // The first one is what the viewer used, those behind are between proxies.
    let first = |list: &str| list.split(',').next().unwrap_or_default().trim().to_ascii_lowercase();
    let forwarded = first(text("forwarded"));
    let mut pairs = forwarded.split(';').filter_map(|pair| pair.trim().strip_prefix("proto="));
    first(text("x-forwarded-proto")) == "https" || pairs.any(|proto| proto.trim_matches('"') == "https")
}

fn refused(why: &'static str) -> Response {
    (StatusCode::FORBIDDEN, [(header::CONTENT_TYPE, "text/plain; charset=utf-8")], why).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(access: &Access, uri: &str, name: header::HeaderName, value: &str) -> Verdict {
        let mut headers = HeaderMap::new();
        headers.insert(name, HeaderValue::from_str(value).unwrap());
        verdict_of(access, &uri.parse().unwrap(), &headers)
    }

    #[test]
    fn only_names_of_the_own_machine_are_answered_without_a_token() {
        let of = |host| verdict(&Access::OwnMachine, "/", header::HOST, host) == Verdict::Allowed;
        assert!(["localhost:8080", "127.0.0.1", "127.0.0.1:80", "[::1]:8080"].into_iter().all(of));
        assert!(
            !["evil.example", "evil.example:8080", "192.168.0.7:8080", "", "localhost.evil.example"]
                .into_iter()
                .any(of)
        );
    }

    #[test]
    fn the_name_in_the_address_counts_where_there_is_one() {
        let of =
            |uri: &str| verdict_of(&Access::OwnMachine, &uri.parse().unwrap(), &HeaderMap::new()) == Verdict::Allowed;
        assert!(of("https://localhost:8642/") && !of("https://evil.example/") && !of("/"));
    }

    #[test]
    fn a_proxy_says_how_the_viewer_came() {
        let came = |name: &'static str, value: &'static str| {
            was_encrypted(&HeaderMap::from_iter([(
                header::HeaderName::from_static(name),
                HeaderValue::from_static(value),
            )]))
        };
        for (name, value) in [
            ("x-forwarded-proto", "https"),
            ("x-forwarded-proto", "HTTPS, http"),
            ("forwarded", "for=192.0.2.43;proto=https, for=198.51.100.17"),
            ("forwarded", "Proto=\"https\""),
        ] {
            assert!(came(name, value), "{name}: {value}");
        }
        for (name, value) in
            [("x-forwarded-proto", "http, https"), ("forwarded", "for=a;proto=http"), ("x-forwarded-for", "https")]
        {
            assert!(!came(name, value), "{name}: {value}");
        }
    }

    #[test]
    fn the_token_is_taken_from_the_address_a_cookie_or_a_header() {
        let access = Access::Token(Access::hash_of("secret"));
        let with = |uri, name, value: &str| verdict(&access, uri, name, value);
        assert_eq!(with("/?token=secret", header::HOST, "site"), Verdict::Welcome("secret".to_owned()));
        assert!(matches!(with("/?token=Secret", header::COOKIE, "groundplan_token=secret"), Verdict::Refused(_)));
        assert_eq!(with("/", header::COOKIE, "a=b; groundplan_token=secret"), Verdict::Allowed);
        assert_eq!(with("/", header::AUTHORIZATION, "Bearer secret"), Verdict::Allowed);
        for value in ["groundplan_token=", "groundplan_token=secre", "xgroundplan_token=secret"] {
            assert!(matches!(with("/data/site.json", header::COOKIE, value), Verdict::Refused(_)), "{value}");
        }
    }
}
