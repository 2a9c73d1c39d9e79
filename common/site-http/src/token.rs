//! The token of clients on other machines: made and told once, stored as its sha256.

use crate::access::Access;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// Why there is no token.
#[derive(Debug, thiserror::Error)]
pub enum TokenError {
    /// The file cannot be read or written.
    #[error("the token's file {} cannot be used", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file holds something else.
    #[error("the token's file {} holds no sha256; without it a new token is made", path.display())]
    Content {
        /// The file.
        path: PathBuf,
    },
}

/// Who may look at what is served: the machine itself where nobody else reaches it, else whoever has the token whose hash is in a
/// file. Without the file a token is made, and told this once.
///
/// # Errors
/// See [`TokenError`].
pub fn access_of(is_own_machine: bool, path: &Path, tell: impl FnOnce(&str)) -> Result<Access, TokenError> {
    if is_own_machine {
        return Ok(Access::OwnMachine);
    }
    let failed = |source| TokenError::Io { path: path.to_owned(), source };
    match std::fs::read_to_string(path) {
        Ok(text) => parse(text.trim()).map(Access::Token).ok_or_else(|| TokenError::Content { path: path.to_owned() }),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let token = new_token().map_err(failed)?;
            let hash = Access::hash_of(&token);
            path.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(failed)?;
            let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(path).map_err(failed)?;
            file.write_all(format!("{}\n", hex(&hash)).as_bytes()).map_err(failed)?;
            tell(&token);
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
        let (path, mut told) = (state.path().join("new/token.sha256"), String::new());
        let access = access_of(false, &path, |token| told = token.to_owned()).unwrap();
        assert_eq!(access_of(false, &path, |_| panic!("there is one")).unwrap(), access);
        assert_eq!(access, Access::Token(Access::hash_of(&told)));
        let stored = std::fs::read_to_string(&path).unwrap();
        assert!(stored == format!("{}\n", hex(&Access::hash_of(&told))) && !stored.contains(&told));
        assert_ne!(new_token().unwrap(), new_token().unwrap());
    }

    #[test]
    fn the_own_machine_needs_none() {
        let state = tempfile::tempdir().unwrap();
        let path = state.path().join("token.sha256");
        assert_eq!(access_of(true, &path, |_| ()).unwrap(), Access::OwnMachine);
        assert!(!path.exists());
    }

    #[test]
    fn a_file_with_something_else_is_told() {
        let state = tempfile::tempdir().unwrap();
        let path = state.path().join("token.sha256");
        std::fs::write(&path, "secret").unwrap();
        let error = access_of(false, &path, |_| ()).unwrap_err();
        assert!(matches!(error, TokenError::Content { .. }));
    }
}
