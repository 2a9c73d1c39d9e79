//! What this machine lacks. Facts are gathered first; what they mean is a function of them.

use super::up::{executable, running, version_of};
use crate::cli::DoctorArgs;
use crate::failure::Failure;
use bus::{Bus, Daemon};
use daemon::{Robot, SiteConfig};
use frames::counted;
use rustix::fs::{StatVfs, statfs, statvfs};
use serde::Serialize;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

const SHARED: &str = "/dev/shm";
/// `statfs` of a file system in memory.
const TMPFS_MAGIC: i64 = 0x0102_1994;
/// A small building with its daemons.
const LEAST_SHARED_BYTES: u64 = 256 << 20;
/// Enough for a site of ten storeys.
const AMPLE_SHARED_BYTES: u64 = 1 << 30;
/// A daemon holds about a hundred descriptors, a monitor more.
const LEAST_FILES: u64 = 1_024;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    Ok,
    Warning,
    Failure,
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Check {
    what: &'static str,
    verdict: Verdict,
    found: String,
}

fn ok(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: Verdict::Ok, found: found.into() }
}

fn warning(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: Verdict::Warning, found: found.into() }
}

fn failure(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: Verdict::Failure, found: found.into() }
}

/// Looks at this machine and the site's configuration; the text, and whether nothing fails.
///
/// # Errors
/// JSON that cannot be written.
pub fn doctor(arguments: &DoctorArgs) -> Result<(String, bool), Failure> {
    let mut checks = vec![shared_memory(&SharedMemory::here()), kernel(&kernel_release()), files(open_files())];
    checks.push(executables());
    match arguments.site.config() {
        Ok(config) => checks.extend(of_site(&config)),
        Err(why) => checks.push(failure("configuration", format!("{why:#}"))),
    }
    let is_well = checks.iter().all(|check| check.verdict != Verdict::Failure);
    if arguments.json {
        return Ok((serde_json::to_string(&checks).map_err(Failure::work)? + "\n", is_well));
    }
    let line = |check: &Check| {
        let word = match check.verdict {
            Verdict::Ok => "ok",
            Verdict::Warning => "warning",
            Verdict::Failure => "FAILS",
        };
        format!("{word:<8} {:<16} {}\n", check.what, check.found)
    };
    Ok((checks.iter().map(line).collect(), is_well))
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
        (_, ..LEAST_SHARED_BYTES) => failure(
            WHAT,
            format!("{sizes}: too little for a building; a container needs --shm-size=2g or {SHARED} mounted"),
        ),
        (_, ..AMPLE_SHARED_BYTES) => warning(WHAT, format!("{sizes}: enough for a small building")),
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
            format!("{release}: before 5.14 a daemon that finds shared memory full is killed instead of told"),
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
        Some(limit @ ..LEAST_FILES) => {
            warning("open files", format!("{limit} a process; raise LimitNOFILE to {LEAST_FILES}"))
        }
        Some(limit) => ok("open files", format!("{limit} a process")),
        None => ok("open files", "no limit"),
    }
}

fn executables() -> Check {
    const WHAT: &str = "executables";
    let own = env!("CARGO_PKG_VERSION");
    for name in Daemon::SUPERVISED.map(Daemon::name) {
        let version = executable(name).and_then(|path| version_of(&path));
        match version {
            Ok(version) if version == own => {}
            Ok(version) => {
                return failure(WHAT, format!("{name} is of version {version}, this is {own}: install one version"));
            }
            Err(why) => return failure(WHAT, format!("{why:#}")),
        }
    }
    ok(WHAT, format!("version {own}"))
}

fn of_site(config: &SiteConfig) -> Vec<Check> {
    let running = running(&config.state).is_some();
    vec![
        ok("configuration", if running { "daemons of this site run" } else { "no daemons of this site run" }),
        models(&config.models),
        robot(config),
        state(&config.state),
        bus_folder(&config.bus.root),
        leftovers(&config.bus.prefix, is_alive(config)),
        owner(&config.bus.prefix),
        clock(config.clock.synchronised_while.as_deref()),
        remove_ipc(),
    ]
}

fn is_alive(config: &SiteConfig) -> bool {
    config.bus.domain().is_ok_and(|domain| Bus::join(&domain, Daemon::Groundplan).is_ok())
}

fn models(models: &[PathBuf]) -> Check {
    match models.iter().find(|path| std::fs::File::open(path).is_err()) {
        Some(missing) => failure("models", format!("{} cannot be read", missing.display())),
        None if models.is_empty() => warning("models", "none: nothing is drawn until groundplan load"),
        None => ok("models", counted(models.len(), "file")),
    }
}

fn robot(config: &SiteConfig) -> Check {
    match config.robot.profile.as_deref().map(Robot::read) {
        Some(Err(why)) => failure("robot", daemon::chain(&why)),
        Some(Ok(robot)) => ok("robot", robot.name),
        None => ok("robot", "the default one"),
    }
}

fn state(folder: &Path) -> Check {
    let probe = folder.join("doctor.new");
    let tried = std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::write(&probe, b""))
        .and_then(|()| std::fs::remove_file(&probe));
    match tried {
        Ok(()) => ok("state folder", folder.display().to_string()),
        Err(why) => failure("state folder", format!("{} cannot be written: {why}", folder.display())),
    }
}

fn bus_folder(root: &Path) -> Check {
    const WHAT: &str = "bus folder";
    let there = root.ancestors().find(|folder| folder.is_dir()).unwrap_or(Path::new("/"));
    let shown = root.display();
    if there != root && rustix::fs::access(there, rustix::fs::Access::WRITE_OK).is_err() {
        return failure(WHAT, format!("{shown} is not there and cannot be made in {}", there.display()));
    }
    match statfs(there).map(|fs| fs.f_type) {
        Ok(TMPFS_MAGIC) => ok(WHAT, shown.to_string()),
        Ok(_) => {
            warning(WHAT, format!("{shown} is on a disk: starting takes seconds; use a folder in /run or {SHARED}"))
        }
        Err(why) => failure(WHAT, format!("{shown}: {why}")),
    }
}

fn segments(prefix: &str) -> Vec<std::fs::DirEntry> {
    let entries = std::fs::read_dir(SHARED).into_iter().flatten().flatten();
    entries.filter(|e| e.file_name().to_string_lossy().starts_with(prefix)).collect()
}

fn leftovers(prefix: &str, is_alive: bool) -> Check {
    let n = segments(prefix).len();
    match (n, is_alive) {
        (0, false) => ok("leftovers", "none"),
        (_, true) => ok("leftovers", format!("a bus runs, with {n} segments")),
        _ => warning(
            "leftovers",
            format!("{n} segments {SHARED}/{prefix}* of a bus that died; the next start removes them"),
        ),
    }
}

fn owner(prefix: &str) -> Check {
    let own = rustix::process::getuid().as_raw();
    let other = segments(prefix).iter().find_map(|e| e.metadata().ok().map(|m| m.uid()).filter(|uid| *uid != own));
    match other {
        Some(uid) => failure(
            "owner",
            format!("the bus belongs to user {uid}, this is user {own}: run as one user, or set another prefix"),
        ),
        None => ok("owner", format!("user {own}")),
    }
}

fn clock(synchronised_while: Option<&Path>) -> Check {
    match synchronised_while {
        Some(path) if path.exists() => ok("clock", "synchronised"),
        Some(path) => {
            warning("clock", format!("{} is not there: a plan time that follows the clock stands", path.display()))
        }
        None => ok("clock", "taken for synchronised; [clock] synchronised_while tells otherwise"),
    }
}

/// systemd removes a user's shared memory when the last session ends, unless it is told not to.
fn remove_ipc() -> Check {
    let text = std::fs::read_to_string("/etc/systemd/logind.conf").unwrap_or_default();
    let keeps = text.lines().any(|line| line.trim().eq_ignore_ascii_case("RemoveIPC=no"));
    let is_system_user = rustix::process::getuid().as_raw() < 1_000;
    match (Path::new("/run/systemd/system").exists(), keeps || is_system_user) {
        (false, _) => ok("RemoveIPC", "no systemd"),
        (true, true) => ok("RemoveIPC", "shared memory stays when somebody logs out"),
        (true, false) => warning(
            "RemoveIPC",
            "systemd removes this user's shared memory at the last logout: set RemoveIPC=no in logind.conf, or use the system's units",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shared_memory_of_a_container_is_too_small() {
        let check = |place| shared_memory(&SharedMemory { place });
        let container = check(Some((true, 64 << 20, 64 << 20)));
        assert_eq!(container.verdict, Verdict::Failure);
        assert!(container.found.contains("--shm-size"), "{}", container.found);
        assert_eq!(check(Some((true, 8 << 30, 512 << 20))).verdict, Verdict::Warning);
        assert_eq!(check(Some((true, 8 << 30, 4 << 30))).verdict, Verdict::Ok);
        assert_eq!(check(Some((false, 8 << 30, 4 << 30))).verdict, Verdict::Failure);
        assert_eq!(check(None).verdict, Verdict::Failure);
    }

    #[test]
    fn kernels_before_5_14_are_warned_of() {
        let check = |release: &str| kernel(release).verdict;
        assert_eq!(
            [check("5.13.19-generic"), check("5.14.0"), check("6.1"), check("odd")],
            [Verdict::Warning, Verdict::Ok, Verdict::Ok, Verdict::Warning]
        );
    }

    #[test]
    fn what_a_dead_bus_left_is_named_and_what_lives_is_not() {
        assert_eq!(leftovers("nobody_has_this_prefix_", false).verdict, Verdict::Ok);
        assert_eq!(leftovers("", true).verdict, Verdict::Ok);
        assert_eq!(files(Some(256)).verdict, Verdict::Warning);
    }
}
