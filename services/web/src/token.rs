//! The token of viewers from other machines: made and printed once, stored as its sha256.

use crate::server::Access;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::net::SocketAddr;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// The file with the hash, in the state folder.
const FILE: &str = "web-token.sha256";

/// Why there is no token.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TokenError {
    /// The file cannot be read or written.
    #[error("token of viewers: {} cannot be used", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file holds something else.
    #[error("token of viewers: {} holds no sha256; without the file a new token is made", path.display())]
    Content {
        /// The file.
        path: PathBuf,
    },
}

/// Who may look at what is served on an address: its own machine, or whoever has the token in the state folder. A token that is
/// made is printed on standard error.
///
/// # Errors
/// See [`TokenError`].
pub(crate) fn access_of(listen: SocketAddr, state: &Path, is_encrypted: bool) -> Result<Access, TokenError> {
    if listen.ip().is_loopback() {
        return Ok(Access::OwnMachine);
    }
    let path = state.join(FILE);
    let failed = |source| TokenError::Io { path: path.clone(), source };
    match std::fs::read_to_string(&path) {
        Ok(text) => parse(text.trim()).map(Access::Token).ok_or(TokenError::Content { path }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let token = new_token().map_err(failed)?;
            let hash = Access::hash_of(&token);
            std::fs::create_dir_all(state).map_err(failed)?;
            let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&path).map_err(failed)?;
            file.write_all(format!("{}\n", hex(&hash)).as_bytes()).map_err(failed)?;
            let scheme = if is_encrypted { "https" } else { "http" };
            eprintln!("viewers need a token, which is shown this once: {scheme}://{listen}/?token={token}");
            if !is_encrypted {
                eprintln!("the page is not encrypted: certificate and key in [web] make it https");
            }
            Ok(Access::Token(hash))
        }
        Err(error) => Err(failed(error)),
    }
}

/// Bytes in hexadecimal digits.
fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn new_token() -> io::Result<String> {
    let mut bytes = [0_u8; 24];
    File::open("/dev/urandom")?.read_exact(&mut bytes)?;
    Ok(hex(&bytes))
}

fn parse(text: &str) -> Option<[u8; 32]> {
    let mut hash = [0; 32];
    if text.len() != 2 * hash.len() || !text.is_ascii() {
        return None;
    }
    for (k, byte) in hash.iter_mut().enumerate() {
        *byte = u8::from_str_radix(text.get(2 * k..2 * k + 2)?, 16).ok()?;
    }
    Some(hash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_kept_as_its_hash_alone() {
        let state = tempfile::tempdir().unwrap();
        let listen = "0.0.0.0:8642".parse().unwrap();
        let access = access_of(listen, state.path(), false).unwrap();
        assert_eq!(access_of(listen, state.path(), false).unwrap(), access);
        let Access::Token(hash) = access else { panic!("{access:?}") };
        assert_eq!(std::fs::read_to_string(state.path().join(FILE)).unwrap(), format!("{}\n", hex(&hash)));
        assert_ne!(new_token().unwrap(), new_token().unwrap());
    }

    #[test]
    fn the_own_machine_needs_none() {
        let state = tempfile::tempdir().unwrap();
        assert_eq!(access_of("[::1]:0".parse().unwrap(), state.path(), false).unwrap(), Access::OwnMachine);
        assert!(!state.path().join(FILE).exists());
    }

    #[test]
    fn a_file_with_something_else_is_told() {
        let state = tempfile::tempdir().unwrap();
        std::fs::write(state.path().join(FILE), "secret").unwrap();
        let error = access_of("0.0.0.0:1".parse().unwrap(), state.path(), true).unwrap_err();
        assert!(matches!(error, TokenError::Content { .. }));
    }
}
