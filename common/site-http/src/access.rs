//! Admission: users of the machine itself, or holders of a token.

use axum::http::uri::Authority;
use axum::http::{HeaderMap, Uri, header};
use sha2::{Digest, Sha256};
use std::net::IpAddr;

/// Who may look.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Access {
    /// Whoever reaches the address of this machine alone. Names of other machines that lead to it are refused, so that a page
    /// from elsewhere cannot read the site through a browser that runs here.
    OwnMachine,
    /// Whoever has the token with this sha256.
    Token([u8; 32]),
}

impl Access {
    /// Sha256 of a token.
    pub fn hash_of(token: &str) -> [u8; 32] {
        Sha256::digest(token.as_bytes()).into()
    }

    /// True if this is the token that is asked for.
    pub fn is_token(&self, token: &str) -> bool {
        match self {
            Self::OwnMachine => false,
            Self::Token(hash) => is_equal(&Self::hash_of(token), hash),
        }
    }
}

/// The token in the header for it.
pub fn bearer_token(headers: &HeaderMap) -> Option<&str> {
    headers.get(header::AUTHORIZATION)?.to_str().ok()?.strip_prefix("Bearer ")
}

/// The name by which a request calls this machine, without a port.
pub fn host_of<'a>(uri: &'a Uri, headers: &'a HeaderMap) -> Option<&'a str> {
    // HTTP/2 has the name in the address.
    let of_uri = uri.authority().map(Authority::as_str);
    let host = of_uri.or_else(|| headers.get(header::HOST)?.to_str().ok())?;
    Some(match host.strip_prefix('[') {
        Some(rest) => rest.split(']').next().unwrap_or_default(),
        None => host.rsplit_once(':').map_or(host, |(name, _)| name),
    })
}

/// True for a name or address of a machine that leads nowhere else than to itself.
pub fn is_own_name(name: &str) -> bool {
    name == "localhost" || name.parse().is_ok_and(|address: IpAddr| address.is_loopback())
}

/// Compares all bytes, however early they differ.
fn is_equal(a: &[u8; 32], b: &[u8; 32]) -> bool {
    a.iter().zip(b).fold(0, |difference, (a, b)| difference | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_calls_this_machine_by_its_address_or_its_host() {
        let of = |uri: &str, host: &'static str| {
            let headers = HeaderMap::from_iter([(header::HOST, header::HeaderValue::from_static(host))]);
            host_of(&uri.parse().unwrap(), &headers).map(str::to_owned)
        };
        assert_eq!(of("/", "site.example:80").as_deref(), Some("site.example"));
        assert_eq!(of("/", "[::1]:80").as_deref(), Some("::1"));
        assert_eq!(of("https://evil.example:1/", "localhost").as_deref(), Some("evil.example"));
        assert_eq!(host_of(&"/".parse().unwrap(), &HeaderMap::new()), None);
        assert!(["localhost", "127.0.0.1", "127.1.2.3", "::1"].into_iter().all(is_own_name));
        assert!(!["localhost.evil.example", "192.168.0.7", "", "0x7f.1"].into_iter().any(is_own_name));
    }

    #[test]
    fn only_the_whole_token_is_one() {
        let access = Access::Token(Access::hash_of("secret"));
        assert!(access.is_token("secret") && !access.is_token("secre") && !access.is_token(""));
        assert!(!Access::OwnMachine.is_token("secret"));
        let headers = |text: &'static str| {
            HeaderMap::from_iter([(header::AUTHORIZATION, header::HeaderValue::from_static(text))])
        };
        assert_eq!(bearer_token(&headers("Bearer secret")), Some("secret"));
        assert_eq!(bearer_token(&headers("Basic secret")), None);
    }
}
