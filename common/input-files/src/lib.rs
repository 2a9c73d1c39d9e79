//! Files that a person or a configuration names: regular ones, read without blocking, up to a limit.
//!
//! A path may name anything: a pipe that nobody writes to blocks who opens it, and a device has no end. What is read here is a
//! regular file, or the error says what it is instead.
//!
//! Errors are of [`std::io`], so that a file that is not there is told as ever; they do not name the path, which the caller has.
//!
//! # Guarantees
//!
//! - A pipe, a device or a folder is an error that says what it is: no daemon waits for a writer, and none fills the memory.
//! - The limit of each kind of file is where the kind is: a model in `ingest`, a schedule file in `tasks`, an image in
//!   `occupancy`.

use rustix::fs::OFlags;
use std::fs::{File, FileType, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

/// Bytes of the largest file of configuration: a robot profile, rules, options.
pub const MAX_CONFIGURATION_BYTES: u64 = 4 << 20;

/// The bytes of a regular file of at most `max_bytes`.
///
/// # Errors
/// A file that cannot be opened or read, is no regular one ([`ErrorKind::InvalidInput`]), or has more bytes
/// ([`ErrorKind::FileTooLarge`]), also if it grows while it is read.
pub fn read_regular_file(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let file = open_regular_file(path)?;
    let length = file.metadata()?.len();
    if max_bytes < length {
        return Err(too_large(max_bytes));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(length).unwrap_or(usize::MAX))?;
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if max_bytes < bytes.len() as u64 { Err(too_large(max_bytes)) } else { Ok(bytes) }
}

/// The text of a regular file of at most `max_bytes`.
///
/// # Errors
/// As [`read_regular_file`]; bytes that are not UTF-8 ([`ErrorKind::InvalidData`]).
pub fn read_regular_text(path: &Path, max_bytes: u64) -> io::Result<String> {
    let bytes = read_regular_file(path, max_bytes)?;
    String::from_utf8(bytes).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is no text in UTF-8"))
}

/// Opens a regular file for reading; anything else is refused, and nothing is waited for.
///
/// # Errors
/// A file that cannot be opened, or is no regular one ([`ErrorKind::InvalidInput`]).
pub fn open_regular_file(path: &Path) -> io::Result<File> {
    // Looked at first: to open a device can have an effect. What is there a moment later is looked at again, and to open a pipe
    // without blocking does not wait for its other end.
    require_regular(std::fs::metadata(path)?.file_type())?;
    let file = OpenOptions::new().read(true).custom_flags(OFlags::NONBLOCK.bits().cast_signed()).open(path)?;
    require_regular(file.metadata()?.file_type())?;
    Ok(file)
}

fn require_regular(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let what = if kind.is_dir() {
        "a folder"
    } else if kind.is_fifo() {
        "a pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    };
    Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {what}, not a regular file")))
}

fn too_large(max_bytes: u64) -> io::Error {
    let units = [(30, "GiB"), (20, "MiB"), (0, "bytes")];
    let whole = units.into_iter().find(|(bits, _)| (max_bytes >> bits) << bits == max_bytes && max_bytes >> bits > 0);
    let (bits, unit) = whole.unwrap_or((0, "bytes"));
    let limit = format!("{} {unit}", max_bytes >> bits);
    io::Error::new(ErrorKind::FileTooLarge, format!("it has more than {limit}, the most that is read"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fs::{CWD, FileType as Node, Mode, mknodat};
    use std::fs;

    /// Why a path is not read; a pipe that blocks would never give it.
    fn refusal(path: &Path) -> (ErrorKind, String) {
        let error = read_regular_file(path, 8).unwrap_err();
        (error.kind(), error.to_string())
    }

    #[test]
    fn a_regular_file_is_read_up_to_the_limit() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("file");
        for (content, max_bytes) in [("", 0), ("12345678", 8), ("12345678", u64::MAX)] {
            fs::write(&path, content).unwrap();
            assert_eq!(read_regular_text(&path, max_bytes).unwrap(), content);
        }
        fs::write(&path, "123456789").unwrap();
        let too_large = (ErrorKind::FileTooLarge, "it has more than 8 bytes, the most that is read".to_owned());
        assert_eq!(refusal(&path), too_large);
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        assert_eq!(refusal(&path), too_large, "nothing of it was read");
        assert_eq!(refusal(&home.path().join("none")).0, ErrorKind::NotFound);
    }

    #[test]
    fn a_file_whose_length_is_not_told_has_the_same_limit() {
        let endless = Path::new("/proc/self/maps");
        assert_eq!(fs::metadata(endless).unwrap().len(), 0);
        assert_eq!(refusal(endless).0, ErrorKind::FileTooLarge);
    }

    #[test]
    fn what_is_no_regular_file_is_refused_at_once_also_behind_a_link() {
        let home = tempfile::tempdir().unwrap();
        let [pipe, link] = ["pipe", "link"].map(|name| home.path().join(name));
        mknodat(CWD, &pipe, Node::Fifo, Mode::from_raw_mode(0o600), 0).unwrap();
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(home.path().join("socket")).unwrap();
        for (path, what) in [
            (pipe.as_path(), "a pipe"),
            (link.as_path(), "a pipe"),
            (Path::new("/dev/zero"), "a device"),
            (home.path(), "a folder"),
            (&home.path().join("socket"), "a socket"),
        ] {
            assert_eq!(refusal(path), (ErrorKind::InvalidInput, format!("it is {what}, not a regular file")));
        }
    }

    #[test]
    fn text_that_is_none_is_refused() {
        let home = tempfile::tempdir().unwrap();
        fs::write(home.path().join("file"), b"\xff").unwrap();
        let error = read_regular_text(&home.path().join("file"), 8).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidData);
    }
}
