//! Files of passwords, which nobody but their user may read.

use crate::error::LinkError;
use std::fs::File;
use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// A longer file is none of passwords.
const MAX_BYTES: u64 = 1 << 20;

/// The text of such a file.
fn read(path: &Path) -> Result<String, LinkError> {
    let io = |source| LinkError::Io { path: path.to_owned(), source };
    let file = File::open(path).map_err(io)?;
    if file.metadata().map_err(io)?.mode() & 0o077 != 0 {
        return Err(LinkError::Shared { path: path.to_owned() });
    }
    let mut text = String::new();
    file.take(MAX_BYTES).read_to_string(&mut text).map_err(io)?;
    Ok(text)
}

/// The password of a robot: the only line of its file.
///
/// # Errors
/// A file that others may read, or of another form.
pub(crate) fn read_password(path: &Path) -> Result<String, LinkError> {
    let text = read(path)?;
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    match (lines.next(), lines.next()) {
        (Some(password), None) => Ok(password.to_owned()),
        _ => {
            Err(LinkError::Passwords { path: path.to_owned(), what: "it has not one line with a password".to_owned() })
        }
    }
}

/// The robots of which a file has passwords, in the form of zenoh: lines `ROBOT:PASSWORD`.
///
/// # Errors
/// A file that others may read, or of another form.
pub(crate) fn read_names(path: &Path) -> Result<Vec<String>, LinkError> {
    let text = read(path)?;
    let lines = text.lines().enumerate().map(|(place, line)| (place + 1, line.trim()));
    let names = lines.filter(|(_, line)| !line.is_empty()).map(|(number, line)| {
        let parts = line.split_once(':').map(|(name, password)| (name.trim(), password.trim()));
        match parts {
            Some((name, password)) if !name.is_empty() && !password.is_empty() => Ok(name.to_owned()),
            _ => Err(LinkError::Passwords {
                path: path.to_owned(),
                what: format!("line {number} is not ROBOT:PASSWORD"),
            }),
        }
    });
    names.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{Permissions, set_permissions, write};
    use std::os::unix::fs::PermissionsExt;

    fn file(text: &str, mode: u32) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("passwords");
        write(&path, text).unwrap();
        set_permissions(&path, Permissions::from_mode(mode)).unwrap();
        (folder, path)
    }

    #[test]
    fn passwords_that_others_may_read_are_refused() {
        let (_folder, path) = file("a:secret\n", 0o640);
        assert!(read_names(&path).unwrap_err().to_string().contains("chmod 600"));
        assert!(read_password(&path).is_err());
    }

    #[test]
    fn what_a_file_of_passwords_holds_is_never_repeated() {
        for text in ["a:secret\nhidden\n", "a:secret\n:hidden\n", "hidden:\n"] {
            let (_folder, path) = file(text, 0o600);
            let why = read_names(&path).unwrap_err().to_string();
            assert!(why.contains("line") && !why.contains("hidden") && !why.contains("secret"), "{why}");
        }
        let (_folder, path) = file("hidden\nhidden\n", 0o600);
        assert!(!read_password(&path).unwrap_err().to_string().contains("hidden"));
    }

    #[test]
    fn names_and_passwords_are_read_without_the_space_around_them() {
        let (_folder, path) = file("\n a : x:y \nb:z\n", 0o600);
        assert_eq!(read_names(&path).unwrap(), ["a", "b"]);
        let (_folder, path) = file(" x:y \n\n", 0o600);
        assert_eq!(read_password(&path).unwrap(), "x:y");
    }
}
