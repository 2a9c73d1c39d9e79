//! Who may ask: hosts, origins, the token.
//!
//! A page from elsewhere reaches this server through a browser that runs on the machine or in its network: by its own origin, or
//! by a name of its own that leads here (DNS rebinding). Both are refused before anything else is looked at.

use crate::problem::{Problem, ProblemKind};
use axum::http::{HeaderMap, Uri, header};
use site_http::{Access, bearer_token, host_of, is_own_name};
use std::net::IpAddr;

/// Who may ask.
#[derive(Debug, Clone)]
pub(crate) struct Guard {
    /// The machine itself, or holders of a token.
    pub(crate) access: Access,
    /// Names of this server beside those of the machine itself and addresses as numbers.
    pub(crate) hosts: Vec<String>,
}

impl Guard {
    /// Refuses whoever may not ask.
    ///
    /// # Errors
    /// Another name of this server, a page from elsewhere, no token or another one.
    pub(crate) fn check(&self, uri: &Uri, headers: &HeaderMap) -> Result<(), Problem> {
        let refused = |why| Err(Problem::of(ProblemKind::Refused, why));
        if !host_of(uri, headers).is_some_and(|host| self.is_host(host)) {
            return refused("this server is not called so: [ask] hosts of the site's configuration has its names");
        }
        for origin in headers.get_all(header::ORIGIN) {
            let origin = origin.to_str().ok().and_then(|origin| origin.parse::<Uri>().ok());
            if !origin.is_some_and(|origin| host_of(&origin, &HeaderMap::new()).is_some_and(|host| self.is_host(host)))
            {
                return refused("a page from elsewhere may not ask");
            }
        }
        match (&self.access, bearer_token(headers)) {
            (Access::OwnMachine, _) => Ok(()),
            (Access::Token(_), Some(token)) if self.access.is_token(token) => Ok(()),
            (Access::Token(_), _) => {
                let why = "send the token that was printed when it was made: Authorization: Bearer TOKEN";
                Err(Problem::of(ProblemKind::NoToken, why))
            }
        }
    }

    /// True if a token is asked for.
    pub(crate) fn needs_token(&self) -> bool {
        matches!(self.access, Access::Token(_))
    }

    fn is_host(&self, host: &str) -> bool {
        // A name leads where whoever owns it wants; a number does not.
        let is_number = || self.needs_token() && host.parse::<IpAddr>().is_ok();
        is_own_name(host) || is_number() || self.hosts.iter().any(|known| known.eq_ignore_ascii_case(host))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn verdict(guard: &Guard, headers: &[(header::HeaderName, &str)]) -> u16 {
        let headers = headers.iter().map(|(name, value)| (name.clone(), HeaderValue::from_str(value).unwrap()));
        guard
            .check(&"/v1/rooms".parse().unwrap(), &HeaderMap::from_iter(headers))
            .map_or_else(|why| why.status(), |()| 200)
    }

    #[test]
    fn names_that_lead_here_from_elsewhere_and_pages_from_elsewhere_are_refused() {
        let guard = Guard { access: Access::OwnMachine, hosts: vec!["office.example".to_owned()] };
        let host = |host| verdict(&guard, &[(header::HOST, host)]);
        assert!(
            ["localhost:8643", "127.0.0.1:8643", "[::1]:8643", "Office.example:1"]
                .into_iter()
                .all(|name| host(name) == 200)
        );
        for name in ["evil.example", "localhost.evil.example:8643", "192.168.0.7:8643", "", "127.0.0.1.nip.io"] {
            assert_eq!(host(name), 403, "{name}");
        }
        let origin = |origin| verdict(&guard, &[(header::HOST, "localhost"), (header::ORIGIN, origin)]);
        assert!(
            ["http://localhost:3000", "http://127.0.0.1", "https://office.example"]
                .into_iter()
                .all(|page| origin(page) == 200)
        );
        for page in ["http://evil.example", "null", "", "file://", "http://localhost.evil.example"] {
            assert_eq!(origin(page), 403, "{page}");
        }
        assert_eq!(verdict(&guard, &[]), 403, "no name at all");
    }

    #[test]
    fn elsewhere_the_whole_token_is_asked_for_in_its_header_alone() {
        let guard = Guard { access: Access::Token(Access::hash_of("secret")), hosts: Vec::new() };
        let with = |value| verdict(&guard, &[(header::HOST, "192.168.0.7:8643"), (header::AUTHORIZATION, value)]);
        assert_eq!(with("Bearer secret"), 200);
        for wrong in ["Bearer secre", "Bearer ", "secret", "Basic secret", "bearer secret"] {
            assert_eq!(with(wrong), 401, "{wrong}");
        }
        let named = [(header::HOST, "evil.example"), (header::AUTHORIZATION, "Bearer secret")];
        assert_eq!(verdict(&guard, &named), 403, "a name is refused with the token, too");
        let in_address = "/v1/rooms?token=secret".parse().unwrap();
        let headers = HeaderMap::from_iter([(header::HOST, HeaderValue::from_static("192.168.0.7"))]);
        assert_eq!(guard.check(&in_address, &headers).unwrap_err().status(), 401, "addresses are logged");
    }
}
