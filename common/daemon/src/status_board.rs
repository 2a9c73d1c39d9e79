//! The last report of each process of a site, with its age: in files beside the bus, also of those that are dead or hang.
//!
//! | file in `board/` of the bus's folder | what |
//! |---|---|
//! | `<process>.json` | its last [`Report`], replaced whole with every heartbeat and change |
//! | `<process>.lock` | locked by the process while it lives; its time of modification is that of the last report, as a
//!   monotonic time: it is told also where the file system has no room for a report |
//!
//! The bus's user sees the state of a site at once, without joining the bus; other users ask the relay for it.

use crate::config::SiteConfig;
use crate::site_process::SiteProcess;
use crate::work_watch::Busy;
use bus::{Daemon, Domain, DomainError, ReportKind, RobotName, Stamp};
use messages::{SeenProcess, SeenReport};
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Serialize};
use site_view::SILENT_AFTER;
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};
use tracing::warn;

/// What a process says of itself; `F` are the facts of a daemon, see [`crate::facts`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Report<F = serde_json::Value> {
    /// Its build, as its `--version` prints it; empty if it does not say.
    #[serde(default)]
    pub build: String,
    /// Its process.
    pub process_id: u32,
    /// How often its process died and was started again.
    pub restarts: u32,
    /// Monotonic time of the report, nanoseconds since the machine's boot.
    pub stamp_ns: u64,
    /// What it is doing.
    #[serde(rename = "stage")]
    pub activity: String,
    /// Resident memory in bytes.
    pub memory_bytes: u64,
    /// Why its output is not what its inputs ask for, or what it failed to do last.
    pub error: Option<String>,
    /// What an operator should know although nothing failed.
    pub warning: Option<String>,
    /// Epochs of the samples that it has handled, and of the last one that it published, by topic; not those of grids.
    pub epochs: BTreeMap<String, u64>,
    /// Monotonic time of its last output, nanoseconds since the machine's boot; `None` before the first.
    #[serde(default)]
    pub output_stamp_ns: Option<u64>,
    /// From the publication of the last input to the end of the work on it, in seconds; `None` for an input that was there
    /// before the daemon.
    #[serde(default)]
    pub latency_s: Option<f64>,
    /// When it published, from old to new, the last minute: the first output of each second.
    #[serde(default)]
    pub outputs: Vec<OutputStamp>,
    /// What its service works on; `None` while it is idle.
    #[serde(default)]
    pub busy: Option<Busy>,
    /// Facts of its service; null without one.
    pub facts: F,
}

/// When a sample was published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct OutputStamp {
    /// Its epoch.
    pub epoch: u64,
    /// Monotonic time, nanoseconds since the machine's boot.
    pub stamp_ns: u64,
}

impl<F> Report<F> {
    /// How long ago it was written.
    pub fn age(&self) -> Duration {
        Stamp::now().since(Stamp(self.stamp_ns))
    }

    /// True if it was not written for so long that its process hangs, or is gone.
    pub fn is_silent(&self) -> bool {
        self.age() >= SILENT_AFTER
    }

    /// That its process and this program are of builds that do not work together; `None` if they do.
    pub fn of_other_build(&self) -> Option<String> {
        let (build, own) = (self.build.as_str(), bus::own_build());
        let differs = !build.is_empty() && !bus::is_same_build(build, own);
        differs
            .then(|| format!("it is of groundplan {build}, and this program of {own}: use one build for all of a site"))
    }
}

/// The reports of a site, in the folder beside the bus; other users than the bus's ask its relay each time.
#[derive(Debug, Clone)]
pub struct StatusBoard {
    folder: PathBuf,
    /// The robot with a name whose daemons are meant.
    robot: Option<RobotName>,
    relayed: Option<Domain>,
}

/// A copy of the board. By process: whether it lives, and its last report.
type BoardCopy = BTreeMap<String, (bool, Option<Report>)>;

impl StatusBoard {
    /// The board beside a bus.
    pub fn of(bus_root: &Path) -> Self {
        Self { folder: bus_root.join("board"), robot: None, relayed: None }
    }

    /// The board of a site of this user, where daemons of a robot are those of the robot that the configuration is of.
    pub fn of_own(config: &SiteConfig) -> Self {
        Self { robot: config.robot_name, ..Self::of(&config.bus.root) }
    }

    /// The same board, where daemons of a robot are those of this one.
    #[must_use]
    pub fn of_robot(&self, robot: Option<RobotName>) -> Self {
        Self { robot, ..self.clone() }
    }

    /// The board of a site as this user may see it.
    ///
    /// # Errors
    /// No relay, or none that serves this user.
    pub fn of_site(config: &SiteConfig) -> Result<Self, DomainError> {
        let domain = config.domain()?;
        let is_relayed = bus::relayed_report(&domain, ReportKind::Status)?.is_some();
        Ok(Self { relayed: is_relayed.then_some(domain), ..Self::of_own(config) })
    }

    /// The whole board, for a relay to pass on: of a site with these named robots.
    pub fn to_bytes(&self, robots: &[RobotName]) -> Vec<u8> {
        let unnamed = robots.is_empty().then_some(None);
        let owners: Vec<Option<RobotName>> = unnamed.into_iter().chain(robots.iter().copied().map(Some)).collect();
        let of_site = |daemon: &Daemon| !daemon.is_of_robot();
        let of_robots = owners.into_iter().flat_map(|robot| {
            let daemons = Daemon::ALL.into_iter().filter(|daemon| daemon.is_of_robot());
            daemons.map(move |daemon| SiteProcess::of(robot, daemon))
        });
        let of_site = Daemon::ALL.into_iter().filter(of_site).map(SiteProcess::from);
        let processes = of_site.chain(of_robots).chain([SiteProcess::Keeper, SiteProcess::Relay]);
        let entry = |process: SiteProcess| (process.to_string(), (self.is_alive(process), self.report(process)));
        let copy: BoardCopy = processes.map(entry).collect();
        serde_json::to_vec(&copy).unwrap_or_default()
    }

    /// A process of the site with its last report, for who judges how it is.
    pub fn seen(&self, process: SiteProcess) -> SeenProcess {
        let report: Option<Report<IgnoredAny>> = self.report(process);
        let report = report.map(|report| SeenReport {
            age: report.age(),
            is_overdue: report.is_silent(),
            process_id: report.process_id,
            restarts: report.restarts,
            memory_bytes: report.memory_bytes,
            busy: report.busy.as_ref().map(|busy| (busy.job.clone(), busy.duration())),
            error: report.of_other_build().into_iter().chain(report.error).reduce(|all, error| all + "; " + &error),
            activity: report.activity,
            warning: report.warning,
        });
        SeenProcess { name: process.to_string(), is_alive: self.is_alive(process), report }
    }

    /// The processes of the site: those that are supervised by its configuration, and ros-bridge and groundplan-web where they run
    /// without being in it (`groundplan up --ros`, `--web`).
    pub fn processes(&self, config: &SiteConfig) -> impl Iterator<Item = SiteProcess> + use<> {
        let bridges = config
            .of_each_robot()
            .into_iter()
            .map(|robot| (robot.ros.enabled, SiteProcess::of(robot.robot_name, Daemon::RosBridge)));
        let of_site = [(config.web.enabled, Daemon::Web.into()), (config.ask.enabled, Daemon::Ask.into())];
        let optional = bridges.chain(of_site);
        let unasked: Vec<SiteProcess> = optional
            .filter(|(is_asked, process)| !is_asked && self.is_alive(*process))
            .map(|(_, process)| process)
            .collect();
        SiteProcess::supervised(config).chain(unasked)
    }

    /// The last report of a process; `None` if there is none that can be read.
    pub fn report<F: DeserializeOwned>(&self, process: impl Into<SiteProcess>) -> Option<Report<F>> {
        let process = self.meant(process);
        if let Some(domain) = &self.relayed {
            return report_of(&copy_of(domain)?, process);
        }
        let bytes = fs::read(self.file(process, "json")).ok()?;
        let mut report: Report<F> = serde_json::from_slice(&bytes).ok()?;
        report.stamp_ns = report.stamp_ns.max(self.touched_ns(process).unwrap_or(0));
        Some(report)
    }

    /// When the process last told that it lives, nanoseconds since the machine's boot.
    fn touched_ns(&self, process: SiteProcess) -> Option<u64> {
        let touched = fs::metadata(self.file(process, "lock")).ok()?.modified().ok()?;
        let touched_ns = u64::try_from(touched.duration_since(UNIX_EPOCH).ok()?.as_nanos()).ok()?;
        // A lock that was just made has the time of the clock.
        (touched_ns <= Stamp::now().0).then_some(touched_ns)
    }

    /// True if the process lives: the kernel drops its lock however it dies.
    pub fn is_alive(&self, process: impl Into<SiteProcess>) -> bool {
        let process = self.meant(process);
        if let Some(domain) = &self.relayed {
            return copy_of(domain).is_some_and(|copy| copy.get(&process.to_string()).is_some_and(|entry| entry.0));
        }
        let lock = File::open(self.file(process, "lock"));
        lock.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
    }

    /// A daemon of a robot is that of the robot whose board this is.
    fn meant(&self, process: impl Into<SiteProcess>) -> SiteProcess {
        match process.into() {
            SiteProcess::Daemon(daemon) => SiteProcess::of(self.robot, daemon),
            process => process,
        }
    }

    fn file(&self, process: SiteProcess, kind: &str) -> PathBuf {
        self.folder.join(format!("{process}.{kind}"))
    }
}

/// The board as the relay sees it; `None` while there is no relay.
fn copy_of(domain: &Domain) -> Option<BoardCopy> {
    serde_json::from_slice(&bus::relayed_report(domain, ReportKind::Status).ok()??).ok()
}

fn report_of<F: DeserializeOwned>(copy: &BoardCopy, process: SiteProcess) -> Option<Report<F>> {
    let report = copy.get(&process.to_string())?.1.as_ref()?;
    serde_json::from_value(serde_json::to_value(report).ok()?).ok()
}

/// A process's own place on the board. A report that is there before it is one of a process that died.
#[derive(Debug)]
pub(crate) struct BoardEntry {
    board: StatusBoard,
    process: SiteProcess,
    lock: Option<File>,
    restarts: u32,
    /// Why the last report is not there.
    unwritten: Option<String>,
}

impl BoardEntry {
    pub(crate) fn new(bus_root: &Path, process: impl Into<SiteProcess>) -> Self {
        let (board, process) = (StatusBoard::of(bus_root), process.into());
        let earlier: Option<Report> = board.report(process);
        Self {
            board,
            process,
            lock: None,
            restarts: earlier.map_or(0, |report| report.restarts.saturating_add(1)),
            unwritten: None,
        }
    }

    /// How often the process died and was started again.
    pub(crate) fn restarts(&self) -> u32 {
        self.restarts
    }

    /// Takes the report away: the process leaves in order.
    pub(crate) fn remove(&mut self) {
        if self.lock.take().is_some() {
            // What cannot be removed is taken for the report of a process that died.
            let _ = fs::remove_file(self.board.file(self.process, "json"));
        }
    }

    /// Replaces the report. Where it cannot be, readers see the last one.
    pub(crate) fn put(&mut self, report: &Report) {
        let unwritten = self.write(report).err();
        // Before the keeper there is no folder.
        let unwritten = unwritten.filter(|why| why.kind() != io::ErrorKind::NotFound).map(|why| why.to_string());
        if unwritten != self.unwritten
            && let Some(why) = &unwritten
        {
            warn!(service = %self.process, error = why, "the report is not on the status board");
        }
        self.unwritten = unwritten;
    }

    fn write(&mut self, report: &Report) -> io::Result<()> {
        self.keep_locked()?;
        if let Some(lock) = &self.lock {
            lock.set_modified(UNIX_EPOCH + Duration::from_nanos(report.stamp_ns))?;
        }
        let path = self.board.file(self.process, "json");
        let beside = path.with_extension("json.new");
        let bytes = serde_json::to_vec(report)?;
        let written = fs::write(&beside, bytes).and_then(|()| fs::rename(&beside, &path));
        if written.is_err() {
            // What is half written helps nobody.
            let _ = fs::remove_file(&beside);
        }
        written
    }

    /// Locks, unless it is locked: the folder may have been removed and made again.
    fn keep_locked(&mut self) -> io::Result<()> {
        let path = self.board.file(self.process, "lock");
        let is_there = |held: &File| {
            let (held, there) = (held.metadata(), fs::metadata(&path));
            held.is_ok_and(|held| there.is_ok_and(|there| (held.dev(), held.ino()) == (there.dev(), there.ino())))
        };
        if self.lock.as_ref().is_some_and(is_there) {
            return Ok(());
        }
        self.lock = None;
        // The keeper makes the folder of the bus.
        match fs::create_dir(&self.board.folder) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
            _ => {}
        }
        let file = File::create(&path)?;
        file.try_lock()?;
        self.lock = Some(file);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_of_another_build_has_that_as_an_error() {
        let root = tempfile::tempdir().unwrap();
        let mut entry = BoardEntry::new(root.path(), SiteProcess::Keeper);
        let mut seen = |build: &str, error: Option<&str>| {
            entry.put(&Report { build: build.to_owned(), ..report(error) });
            StatusBoard::of(root.path()).seen(SiteProcess::Keeper).report.unwrap().error
        };
        let own = bus::own_build();
        assert_eq!([seen(own, None), seen("", None)], [None, None]);
        let told = seen("0.9.3 (commit 0123456789ab)", Some("no bus")).unwrap();
        assert!(
            told.contains("0.9.3 (commit 0123456789ab)") && told.contains(own) && told.ends_with("; no bus"),
            "{told}"
        );
    }

    fn report(error: Option<&str>) -> Report {
        Report {
            process_id: 7,
            stamp_ns: Stamp::now().0,
            activity: "idle".to_owned(),
            memory_bytes: 1,
            error: error.map(str::to_owned),
            facts: serde_json::json!({"storeys": 3}),
            ..Report::default()
        }
    }

    #[test]
    fn the_last_report_stays_when_its_daemon_dies_and_the_lock_tells_that_it_did() {
        let root = tempfile::tempdir().unwrap();
        let board = StatusBoard::of(root.path());
        assert!(!board.is_alive(Daemon::Rasterize) && board.report::<serde_json::Value>(Daemon::Rasterize).is_none());
        let mut entry = BoardEntry::new(root.path(), Daemon::Rasterize);
        entry.write(&report(None)).unwrap();
        entry.write(&report(Some("it is broken"))).unwrap();
        assert!(board.is_alive(Daemon::Rasterize) && !board.is_alive(Daemon::ScheduleEval));
        let mut second = BoardEntry::new(root.path(), Daemon::Rasterize);
        assert!(second.write(&report(None)).is_err(), "another process of this daemon lives");
        drop(entry);
        assert_eq!(BoardEntry::new(root.path(), Daemon::Rasterize).restarts(), 1);
        let last = board.report::<crate::facts::RasterizeFacts>(Daemon::Rasterize).unwrap();
        assert_eq!((last.error.as_deref(), last.facts.storeys), (Some("it is broken"), 3));
        assert!(!board.is_alive(Daemon::Rasterize));
    }

    #[test]
    fn daemons_of_robots_have_places_of_their_own_also_in_a_copy() {
        let root = tempfile::tempdir().unwrap();
        let robots: [RobotName; 2] = ["lift", "scan"].map(|name| name.parse().unwrap());
        let board = StatusBoard::of(root.path());
        let mut entries =
            robots.map(|robot| BoardEntry::new(root.path(), SiteProcess::of(Some(robot), Daemon::Rasterize)));
        entries[0].write(&report(None)).unwrap();
        entries[1].write(&report(Some("it is broken"))).unwrap();
        let error = |robot| board.of_robot(robot).report::<serde_json::Value>(Daemon::Rasterize).map(|r| r.error);
        assert_eq!(
            [Some(robots[0]), Some(robots[1]), None].map(error),
            [Some(None), Some(Some("it is broken".to_owned())), None]
        );
        let copy: BoardCopy = serde_json::from_slice(&board.to_bytes(&robots)).unwrap();
        assert!(copy["rasterize@lift"].0 && copy["rasterize@scan"].0);
        assert!(!copy.contains_key("rasterize") && !copy["ifc-ingest"].0);
        drop(entries);
        assert!(!board.of_robot(Some(robots[0])).is_alive(Daemon::Rasterize));
    }

    #[test]
    fn a_process_whose_reports_find_no_room_is_not_silent() {
        let root = tempfile::tempdir().unwrap();
        let board = StatusBoard::of(root.path());
        let mut entry = BoardEntry::new(root.path(), Daemon::Rasterize);
        entry.put(&report(None));
        let first = board.report::<serde_json::Value>(Daemon::Rasterize).unwrap().stamp_ns;
        // A report cannot be written where its file is to be.
        fs::create_dir_all(root.path().join("board/rasterize.json.new/in it")).unwrap();
        entry.put(&report(Some("it is broken")));
        let last = board.report::<serde_json::Value>(Daemon::Rasterize).unwrap();
        assert!(first < last.stamp_ns && last.error.is_none() && entry.unwritten.is_some());
    }

    #[test]
    fn a_copy_says_what_the_board_says() {
        let root = tempfile::tempdir().unwrap();
        let mut entry = BoardEntry::new(root.path(), Daemon::Rasterize);
        entry.write(&report(Some("it is broken"))).unwrap();
        let board = StatusBoard::of(root.path());
        let copy: BoardCopy = serde_json::from_slice(&board.to_bytes(&[])).unwrap();
        assert!(copy["rasterize"].0 && !copy["ifc-ingest"].0);
        let last: Report<crate::facts::RasterizeFacts> = report_of(&copy, Daemon::Rasterize.into()).unwrap();
        assert_eq!((last.error.as_deref(), last.facts.storeys), (Some("it is broken"), 3));
        assert!(report_of::<serde_json::Value>(&copy, Daemon::IfcIngest.into()).is_none());
    }

    #[test]
    fn a_board_that_was_removed_is_made_again_and_a_missing_bus_is_not() {
        let root = tempfile::tempdir().unwrap();
        let mut entry = BoardEntry::new(root.path(), Daemon::IfcIngest);
        entry.write(&report(None)).unwrap();
        fs::remove_dir_all(root.path().join("board")).unwrap();
        entry.write(&report(None)).unwrap();
        assert!(StatusBoard::of(root.path()).is_alive(Daemon::IfcIngest));
        fs::remove_dir_all(root.path()).unwrap();
        assert!(entry.write(&report(None)).is_err() && !root.path().exists());
    }
}
