//! The sockets of a relay: their folder, their groups, who is at the other end.

use crate::accounts::{gid_of, group_text};
use crate::error::DomainError;
use crate::relay_protocol::{CONTROL_SOCKET, VIEW_SOCKET};
use rustix::fs::{Gid, chown};
use rustix::io::Errno;
use rustix::net::sockopt::socket_peercred;
use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType, accept_with, bind, listen, socket_with};
use std::fs::{self, DirBuilder, File, Permissions, TryLockError};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

/// Clients that wait to be accepted.
const BACKLOG: i32 = 64;

/// Clients of a socket that are accepted before it is the turn of those that are there.
const MAX_ACCEPTED_AT_ONCE: usize = 16;

/// The view socket and the control socket.
pub(super) struct Sockets {
    folder: PathBuf,
    groups: [Option<u32>; 2],
    listeners: [Listener; 2],
    control_group: String,
    _lock: File,
}

struct Listener {
    path: PathBuf,
    socket: OwnedFd,
    /// What the path names while nobody deleted it.
    inode: u64,
}

/// A client that has connected.
pub(super) struct Accepted {
    pub(super) socket: UnixStream,
    /// Who it is, as the system says.
    pub(super) uid: u32,
    pub(super) may_command: bool,
}

impl Sockets {
    /// Listens in a folder, for a group that may look and one that may command; and what an operator should know.
    pub(super) fn open(folder: &Path, groups: [Option<&str>; 2]) -> Result<(Self, Vec<String>), DomainError> {
        let failed = |source| DomainError::File { path: folder.to_owned(), source };
        make_folder(folder).map_err(failed)?;
        // Whoever may open the file may lock it.
        let lock = File::options().create(true).append(true).mode(0o600).open(folder.join("relay.lock"));
        let lock = lock.map_err(failed)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(DomainError::RelayRuns { folder: folder.to_owned() }),
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        let mut notes = Vec::new();
        let mut gids = groups.map(|group| {
            let gid = gid_of(group?);
            if gid.is_none() {
                notes.push(format!("there is no group {}: only root and the bus's user are served for it", group?));
            }
            gid
        });
        let view = Listener::open(folder.join(VIEW_SOCKET), &mut gids[0], &mut notes).map_err(failed)?;
        let control = Listener::open(folder.join(CONTROL_SOCKET), &mut gids[1], &mut notes).map_err(failed)?;
        let control_group = gids[1].map_or_else(String::new, group_text);
        let (folder, listeners) = (folder.to_owned(), [view, control]);
        Ok((Self { folder, groups: gids, listeners, control_group, _lock: lock }, notes))
    }

    /// Makes sockets again that were deleted.
    pub(super) fn keep(&mut self) -> Result<(), DomainError> {
        let failed = |source| DomainError::File { path: self.folder.clone(), source };
        for (listener, gid) in self.listeners.iter_mut().zip(&mut self.groups) {
            if !fs::symlink_metadata(&listener.path).is_ok_and(|metadata| metadata.ino() == listener.inode) {
                make_folder(&self.folder).map_err(failed)?;
                *listener = Listener::open(listener.path.clone(), gid, &mut Vec::new()).map_err(failed)?;
            }
        }
        Ok(())
    }

    /// The group that may send commands; empty if there is none.
    pub(super) fn control_group(&self) -> &str {
        &self.control_group
    }

    pub(super) fn listeners(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        self.listeners.iter().map(|listener| listener.socket.as_fd())
    }

    /// Clients that wait, some of each socket at a time.
    ///
    /// # Errors
    /// The system has no descriptor or memory for one of them: it goes on waiting, and its socket stays readable.
    pub(super) fn accept(&self) -> (Vec<Accepted>, io::Result<()>) {
        let mut accepted = Vec::new();
        for (listener, may_command) in self.listeners.iter().zip([false, true]) {
            for _ in 0..MAX_ACCEPTED_AT_ONCE {
                match accept_one(&listener.socket) {
                    Ok((socket, uid)) => accepted.push(Accepted { socket, uid, may_command }),
                    Err(Errno::AGAIN) => break,
                    Err(errno @ (Errno::MFILE | Errno::NFILE | Errno::NOBUFS | Errno::NOMEM)) => {
                        return (accepted, Err(errno.into()));
                    }
                    // One that has gone already.
                    Err(_) => {}
                }
            }
        }
        (accepted, Ok(()))
    }
}

/// The next client, and who it is, as the system says.
fn accept_one(listener: &OwnedFd) -> Result<(UnixStream, u32), Errno> {
    let socket = accept_with(listener, SocketFlags::CLOEXEC | SocketFlags::NONBLOCK)?;
    let uid = socket_peercred(&socket)?.uid.as_raw();
    Ok((UnixStream::from(socket), uid))
}

impl Drop for Sockets {
    fn drop(&mut self) {
        for listener in &self.listeners {
            // A socket that nobody listens on is refused by the system.
            let _ = fs::remove_file(&listener.path);
        }
    }
}

impl Listener {
    /// Listens at a path; a group that cannot be given to it is taken away.
    fn open(path: PathBuf, gid: &mut Option<u32>, notes: &mut Vec<String>) -> io::Result<Self> {
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
        let socket = socket_with(AddressFamily::UNIX, SocketType::STREAM, flags, None)?;
        bind(&socket, &SocketAddrUnix::new(&path)?)?;
        // Nobody can connect before it listens, and it listens when its mode is right.
        fs::set_permissions(&path, Permissions::from_mode(0o600))?;
        if let Some(group) = *gid {
            match chown(&path, None, Some(Gid::from_raw(group))) {
                Ok(()) => fs::set_permissions(&path, Permissions::from_mode(0o660))?,
                Err(errno) => {
                    let (group, path) = (group_text(group), path.display());
                    notes.push(format!(
                        "{path} cannot be given to the group {group} ({errno}): make the bus's user a member of it"
                    ));
                    *gid = None;
                }
            }
        }
        listen(&socket, BACKLOG)?;
        let inode = fs::symlink_metadata(&path)?.ino();
        Ok(Self { path, socket, inode })
    }
}

/// A folder that others may enter, and not write.
fn make_folder(folder: &Path) -> io::Result<()> {
    DirBuilder::new().recursive(true).mode(0o755).create(folder)?;
    if fs::metadata(folder)?.permissions().mode() & 0o777 != 0o755 {
        fs::set_permissions(folder, Permissions::from_mode(0o755))?;
    }
    Ok(())
}
