//! Credentials of a store, from a file that only its user can read.

use serde::Deserialize;
use std::fmt;
use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// A longer file is none of credentials.
const MAX_BYTES: u64 = 64 << 10;

/// Credentials of a store: TOML, all keys optional.
///
/// ```toml
/// # S3
/// access_key = "AKIA.."
/// secret_key = ".."
/// endpoint = "https://minio.site.example:9000"
/// region = "eu-north-1"
/// # a web server
/// user = "robot-7"
/// password = ".."
/// # both: the certificate of the authority that signed the server's, PEM
/// authority = "site-ca.pem"
/// ```
#[derive(Clone, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Credentials {
    /// Access key of S3.
    pub access_key: Option<String>,
    /// Its secret.
    pub secret_key: Option<String>,
    /// Address of the S3 service; Amazon's without one.
    pub endpoint: Option<String>,
    /// Region of the bucket; `us-east-1` without one.
    pub region: Option<String>,
    /// User of a web server.
    pub user: Option<String>,
    /// Password of the user.
    pub password: Option<String>,
    /// Certificate of an authority that is trusted beside those of the system, PEM.
    pub authority: Option<PathBuf>,
}

/// Credentials that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CredentialsError {
    /// The file cannot be read.
    #[error("credentials {} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Others than its owner may read it.
    #[error("credentials {} can be read by others: chmod 600 {}", path.display(), path.display())]
    Shared {
        /// The file.
        path: PathBuf,
    },
    /// Not TOML, or an unknown key; what it holds is not repeated.
    #[error("credentials {} are no TOML of the keys access_key, secret_key, endpoint, region, user, password, authority", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
    },
    /// Half of a pair.
    #[error("credentials: {0} go together")]
    Half(&'static str),
    /// No PEM certificate.
    #[error("credentials: the authority {} is no certificate in PEM", path.display())]
    Authority {
        /// The file.
        path: PathBuf,
    },
}

impl Credentials {
    /// The credentials of a file; paths in it count from its folder.
    ///
    /// # Errors
    /// A file that cannot be read, that others can read, or that holds something else.
    pub fn read(path: &Path) -> Result<Self, CredentialsError> {
        let io = |source| CredentialsError::Io { path: path.to_owned(), source };
        let file = std::fs::File::open(path).map_err(io)?;
        if file.metadata().map_err(io)?.mode() & 0o077 != 0 {
            return Err(CredentialsError::Shared { path: path.to_owned() });
        }
        let mut text = String::new();
        file.take(MAX_BYTES).read_to_string(&mut text).map_err(io)?;
        // The error of the parser would show lines of the file.
        let mut read: Self = toml::from_str(&text).map_err(|_| CredentialsError::Toml { path: path.to_owned() })?;
        if let (Some(authority), Some(folder)) = (&mut read.authority, path.parent()) {
            *authority = folder.join(&*authority);
        }
        read.check()?;
        Ok(read)
    }

    fn check(&self) -> Result<(), CredentialsError> {
        if self.access_key.is_some() != self.secret_key.is_some() {
            return Err(CredentialsError::Half("access_key and secret_key"));
        }
        if self.user.is_some() != self.password.is_some() {
            return Err(CredentialsError::Half("user and password"));
        }
        Ok(())
    }
}

impl fmt::Debug for Credentials {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Nothing of it is for a log.
        f.write_str("Credentials")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    fn read(text: &str, mode: u32) -> Result<Credentials, CredentialsError> {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("store.toml");
        std::fs::write(&path, text).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
        Credentials::read(&path)
    }

    #[test]
    fn credentials_that_others_can_read_are_refused() {
        assert_eq!(read("user = \"a\"\npassword = \"b\"", 0o600).unwrap().user.as_deref(), Some("a"));
        assert!(matches!(read("", 0o640), Err(CredentialsError::Shared { .. })));
    }

    #[test]
    fn an_error_shows_nothing_of_what_is_secret() {
        let why = read("secret_key = hunter2", 0o600).unwrap_err();
        assert!(!format!("{why} {why:?}").contains("hunter2"));
        assert!(matches!(read("user = \"a\"", 0o600), Err(CredentialsError::Half(_))));
        let held = Credentials { password: Some("hunter2".to_owned()), ..Credentials::default() };
        assert!(!format!("{held:?}").contains("hunter2"));
    }
}
