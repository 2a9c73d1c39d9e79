//! Requirements on the machine, independent of the site. Facts are gathered first; checks are functions of them.

use super::check::{Check, failure, ok, warning};
use crate::supervise::executable_of_own_build;
use bus::{Daemon, own_build};
use rustix::fs::{StatVfs, statfs, statvfs};
use std::path::Path;

/// Where shared memory is.
pub(super) const SHARED: &str = "/dev/shm";
/// `statfs` of a file system in memory.
pub(super) const TMPFS_MAGIC: i64 = 0x0102_1994;
/// A small building with its daemons.
const MIN_SHARED_BYTES: u64 = 256 << 20;
/// Enough for a site of ten storeys.
const RECOMMENDED_SHARED_BYTES: u64 = 1 << 30;
/// A daemon holds about a hundred descriptors, a monitor more.
const MIN_OPEN_FILES: u64 = 1_024;

/// Checks memory, kernel, limits and executables.
pub(super) fn of_machine() -> Vec<Check> {
    vec![shared_memory(&SharedMemory::here()), kernel(&kernel_release()), files(open_files()), executables()]
}

/// Facts about shared memory; `None` if there is none.
struct SharedMemory {
    place: Option<(bool, u64, u64)>,
}

impl SharedMemory {
    fn here() -> Self {
        let place = || -> rustix::io::Result<(bool, u64, u64)> {
            let is_tmpfs = statfs(SHARED)?.f_type == TMPFS_MAGIC;
            let StatVfs { f_blocks, f_bavail, f_frsize, .. } = statvfs(SHARED)?;
            Ok((is_tmpfs, f_blocks * f_frsize, f_bavail * f_frsize))
        };
        Self { place: place().ok() }
    }
}

fn shared_memory(memory: &SharedMemory) -> Check {
    const WHAT: &str = "shared memory";
    let Some((is_tmpfs, size, free)) = memory.place else {
        return failure(WHAT, format!("{SHARED} is not there: mount a tmpfs"));
    };
    let sizes = format!("{} MB free of {} MB", free >> 20, size >> 20);
    match (is_tmpfs, free) {
        (false, _) => failure(WHAT, format!("{SHARED} is no tmpfs: maps would be written to a disk")),
        (_, ..MIN_SHARED_BYTES) => failure(
            WHAT,
            format!("{sizes}: too little for a building; a container needs --shm-size=2g or {SHARED} mounted"),
        ),
        (_, ..RECOMMENDED_SHARED_BYTES) => warning(WHAT, format!("{sizes}: enough for a small building")),
        _ => ok(WHAT, sizes),
    }
}

fn kernel_release() -> String {
    std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default().trim().to_owned()
}

fn kernel(release: &str) -> Check {
    let mut numbers = release.split(['.', '-']).map_while(|n| n.parse::<u32>().ok());
    match (numbers.next(), numbers.next()) {
        (Some(major), Some(minor)) if (major, minor) >= (5, 14) => ok("kernel", release),
        (Some(_), Some(_)) => warning(
            "kernel",
            format!(
                "{release}: before 5.14 a daemon that finds shared memory full is killed instead of getting an error"
            ),
        ),
        _ => warning("kernel", format!("{release:?}: unknown")),
    }
}

/// Files that a process may have open.
fn open_files() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::Nofile).current
}

fn files(limit: Option<u64>) -> Check {
    match limit {
        Some(limit @ ..MIN_OPEN_FILES) => {
            warning("open files", format!("{limit} a process; raise LimitNOFILE to {MIN_OPEN_FILES}"))
        }
        Some(limit) => ok("open files", format!("{limit} a process")),
        None => ok("open files", "no limit"),
    }
}

fn executables() -> Check {
    const WHAT: &str = "executables";
    let names = Daemon::ALL.into_iter().filter(|daemon| daemon.is_of_site()).map(Daemon::name);
    match names.map(executable_of_own_build).find_map(Result::err) {
        Some(why) => failure(WHAT, format!("{why:#}")),
        None => ok(WHAT, own_build()),
    }
}

/// systemd removes a user's shared memory when the last session ends, unless RemoveIPC=no.
pub(super) fn remove_ipc() -> Check {
    let text = std::fs::read_to_string("/etc/systemd/logind.conf").unwrap_or_default();
    let keeps = text.lines().any(|line| line.trim().eq_ignore_ascii_case("RemoveIPC=no"));
    let is_system_user = rustix::process::getuid().as_raw() < 1_000;
    match (Path::new("/run/systemd/system").exists(), keeps || is_system_user) {
        (false, _) => ok("RemoveIPC", "no systemd"),
        (true, true) => ok("RemoveIPC", "shared memory stays when users log out"),
        (true, false) => warning(
            "RemoveIPC",
            "systemd removes this user's shared memory at the last logout: set RemoveIPC=no in logind.conf, or use the system's units",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::CheckResult;
    use super::*;

    #[test]
    fn the_shared_memory_of_a_container_is_too_small() {
        let check = |place| shared_memory(&SharedMemory { place });
        let container = check(Some((true, 64 << 20, 64 << 20)));
        assert_eq!(container.verdict, CheckResult::Failure);
        assert!(container.found.contains("--shm-size"), "{}", container.found);
        assert_eq!(check(Some((true, 8 << 30, 512 << 20))).verdict, CheckResult::Warning);
        assert_eq!(check(Some((true, 8 << 30, 4 << 30))).verdict, CheckResult::Ok);
        assert_eq!(check(Some((false, 8 << 30, 4 << 30))).verdict, CheckResult::Failure);
        assert_eq!(check(None).verdict, CheckResult::Failure);
    }

    #[test]
    fn kernels_before_5_14_are_warned_of() {
        let check = |release: &str| kernel(release).verdict;
        assert_eq!(
            [check("5.13.19-generic"), check("5.14.0"), check("6.1"), check("odd")],
            [CheckResult::Warning, CheckResult::Ok, CheckResult::Ok, CheckResult::Warning]
        );
    }

    #[test]
    fn few_open_files_are_warned_of() {
        assert_eq!(files(Some(256)).verdict, CheckResult::Warning);
    }
}
