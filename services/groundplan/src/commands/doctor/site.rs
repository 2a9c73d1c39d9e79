//! Checks of the configuration of a site: models, robot, state folder, bus and clock.

use super::check::{Check, failure, ok, warning};
use super::machine::{SHARED, TMPFS_MAGIC, remove_ipc};
use crate::site_check::findings;
use crate::supervise::running;
use bus::{Bus, Daemon};
use daemon::facts::RosBridgeFacts;
use daemon::{Report, Robot, SettingKey, SiteConfig, SiteProcess, StatusBoard};
use diagnostics::counted;
use rustix::fs::statfs;
use serde::de::IgnoredAny;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

pub(super) fn of_site(config: &SiteConfig) -> Vec<Check> {
    let running = running(&config.state).is_some();
    let mut checks =
        vec![ok("configuration", if running { "daemons of this site run" } else { "no daemons of this site run" })];
    if let Some(owner) = foreign_owner(&config.bus.root) {
        checks.push(ok("owner", format!("user {owner}: models, settings, state and bus are checked as that user")));
        checks.push(match StatusBoard::of_site(config) {
            Ok(_) => ok("relay", "it serves this user"),
            Err(why) => failure("relay", daemon::chain(&why)),
        });
        return checks;
    }
    checks.extend(configuration(config));
    checks.extend(config.unused_robot_state().into_iter().map(|told| warning("state folder", told)));
    checks.extend([
        state(&config.state),
        bus_folder(&config.bus.root),
        leftovers(&config.bus.prefix, is_alive(config)),
        owner(&config.bus.prefix),
        clock(config.clock.synchronised_while.as_deref()),
        remove_ipc(),
    ]);
    checks.extend(running.then(|| builds(config)));
    for config in config.of_each_robot() {
        let bridge: Option<Report<RosBridgeFacts>> = StatusBoard::of_own(&config).report(Daemon::RosBridge);
        checks.extend(bridge.filter(|_| running).map(|report| ros_graph(&report.facts)));
    }
    checks
}

/// The user of a bus that is another's: state and segments are not for others to look at.
fn foreign_owner(bus_root: &Path) -> Option<u32> {
    let own = rustix::process::geteuid().as_raw();
    std::fs::metadata(bus_root).ok().map(|folder| folder.uid()).filter(|uid| *uid != own)
}

/// What is wrong with keys of the configuration; models and robot are told of where nothing is wrong with them, too.
fn configuration(config: &SiteConfig) -> Vec<Check> {
    let findings = findings(config);
    let is_well = |key: SettingKey| findings.iter().all(|finding| finding.key != key.name());
    let mut checks = Vec::new();
    if let Some(follow) = &config.follow {
        checks.push(ok("models", format!("drawn by the server of {}, from {}", follow.site, follow.store)));
    } else if is_well(SettingKey::Models) {
        checks.push(match config.models.len() {
            0 => warning("models", "none: nothing is drawn until groundplan load"),
            n => ok("models", counted(n, "file")),
        });
    }
    if config.follow.is_none() && is_well(SettingKey::RobotProfile) {
        for config in config.of_each_robot() {
            let robot = config.robot.profile.as_deref().and_then(|path| Robot::read(path).ok());
            let profile = robot.map_or_else(|| "the default one".to_owned(), |robot| robot.name);
            let named = config.robot_name.map_or_else(String::new, |name| format!("{name}: "));
            checks.push(ok("robot", format!("{named}{profile}")));
        }
    }
    checks.extend(findings.iter().map(|finding| {
        let text = finding.to_string();
        if finding.is_fatal { failure("configuration", text) } else { warning("configuration", text) }
    }));
    checks
}

/// Whether all processes that run are of the build of this program.
fn builds(config: &SiteConfig) -> Check {
    const WHAT: &str = "builds";
    let board = StatusBoard::of_own(config);
    let other = |process: SiteProcess| {
        let report: Report<IgnoredAny> = board.report(process).filter(|_| board.is_alive(process))?;
        Some(format!("{process}: {}", report.of_other_build()?))
    };
    match board.processes(config).find_map(other) {
        Some(told) => failure(WHAT, told),
        None => ok(WHAT, format!("all processes are of groundplan {}, or do not say", bus::own_build())),
    }
}

fn is_alive(config: &SiteConfig) -> bool {
    config.domain().is_ok_and(|domain| Bus::join(&domain, Daemon::Groundplan).is_ok())
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
        Some(uid) => warning(
            "owner",
            format!("the bus belongs to user {uid}: start and stop it as that user; user {own} goes through the relay"),
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
        None => ok("clock", "assumed to be synchronised; set [clock] synchronised_while to check it"),
    }
}

/// What ros-bridge sees of others.
fn ros_graph(RosBridgeFacts { domain_id, peers, .. }: &RosBridgeFacts) -> Check {
    const WHAT: &str = "ROS 2";
    let others = counted(peers.participants, "other participant");
    let topic = |(topic, [publishers, subscriptions]): (&String, &[usize; 2])| {
        format!("{topic} {}, {}", counted(*publishers, "publisher"), counted(*subscriptions, "subscription"))
    };
    let topics: Vec<String> = peers.topics.iter().map(topic).collect();
    let found = format!("domain {domain_id}, {others}; of others: {}", topics.join("; "));
    if peers.participants == 0 {
        return warning(WHAT, format!("{found}; is it the domain of the robot, and does its network pass multicast?"));
    }
    ok(WHAT, found)
}

#[cfg(test)]
mod tests {
    use super::super::check::CheckResult;
    use super::*;

    #[test]
    fn leftovers_of_a_dead_bus_are_named_and_those_in_use_are_not() {
        assert_eq!(leftovers("nobody_has_this_prefix_", false).verdict, CheckResult::Ok);
        assert_eq!(leftovers("", true).verdict, CheckResult::Ok);
    }
}
