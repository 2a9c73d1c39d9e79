//! The token of viewers from other machines, and how it is told.

use daemon::state_files::WEB_TOKEN;
use site_http::{Access, TokenError};
use std::net::SocketAddr;
use std::path::Path;

/// Who may look at what is served on an address: its own machine, or whoever has the token in the state folder. A token that is
/// made is printed on standard error.
///
/// # Errors
/// See [`TokenError`].
pub(crate) fn access_of(listen: SocketAddr, state: &Path, is_encrypted: bool) -> Result<Access, TokenError> {
    site_http::access_of(listen.ip().is_loopback(), &state.join(WEB_TOKEN), |token| {
        let scheme = if is_encrypted { "https" } else { "http" };
        eprintln!("viewers need a token, which is shown this once: {scheme}://{listen}/?token={token}");
        if !is_encrypted {
            eprintln!("the page is not encrypted: certificate and key in [web] make it https");
        }
    })
}
