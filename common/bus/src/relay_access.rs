//! Access to the sockets of a relay by user and group, with the error of a user who has none.

use crate::accounts::{group_text, user_text};
use crate::error::DomainError;
use crate::relay_protocol::{CONTROL_SOCKET, VIEW_SOCKET};
use rustix::net::sockopt::socket_peercred;
use std::fs;
use std::io::{self, ErrorKind};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::net::UnixStream;
use std::path::Path;

/// What a missing relay means.
const NOT_THERE: &str = "it does not run; is the site up?";

/// Connects to the control socket if this user may, else to the view socket.
///
/// # Errors
/// No relay, one of another user than the bus's, or a user in none of its groups.
pub(crate) fn connect(folder: &Path, owner: u32) -> Result<UnixStream, DomainError> {
    let no_relay = |reason: String| DomainError::NoRelay { owner: user_text(owner), folder: folder.to_owned(), reason };
    for name in [CONTROL_SOCKET, VIEW_SOCKET] {
        match UnixStream::connect(folder.join(name)) {
            Ok(socket) => {
                // Anybody may make a folder where the relay's is missing.
                let peer = socket_peercred(&socket).map_err(|e| no_relay(io::Error::from(e).to_string()))?;
                let uid = peer.uid.as_raw();
                return if uid == owner {
                    Ok(socket)
                } else {
                    Err(no_relay(format!("the relay there is that of {}", user_text(uid))))
                };
            }
            Err(error) if error.kind() == ErrorKind::PermissionDenied => {}
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(no_relay(NOT_THERE.to_owned())),
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => return Err(no_relay(NOT_THERE.to_owned())),
            Err(error) => return Err(no_relay(error.to_string())),
        }
    }
    let group_of = |name| group_of(&folder.join(name));
    let groups: Vec<String> = [VIEW_SOCKET, CONTROL_SOCKET].into_iter().filter_map(group_of).collect();
    Err(DomainError::NoAccess { owner: user_text(owner), groups })
}

/// The group that may open a socket.
fn group_of(socket: &Path) -> Option<String> {
    let metadata = fs::symlink_metadata(socket).ok()?;
    (metadata.permissions().mode() & 0o060 == 0o060).then(|| group_text(metadata.gid()))
}
