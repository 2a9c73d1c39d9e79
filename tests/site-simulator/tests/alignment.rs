//! slam-align among the daemons of a site: what cannot be committed leaves bus, disk and state as they were, and is decided again.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/models.rs"]
mod models;
#[path = "support/robot.rs"]
mod robot;

use bus::{Bus, Daemon, RawSubscriber, TopicName, topics};
use daemon::{AlignAnswer, AlignRequest, Confirmations, KnownPlaces, ScheduleRequest, SearchState};
use models::{START_MS, copy_folder, models, toml};
use robot::{N_MAPS, Robot, TRUE_POSE, accepted, east_wall, result_of, save};
use serde_json::Value;
use site_simulator::{DAEMONS, Daemons, DiskFaults, End, SimulatedClock};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicI64;

/// A site on which all walls stand, with a robot.
struct Site {
    _home: tempfile::TempDir,
    daemons: Daemons,
    robot: Robot,
    alignments: RawSubscriber,
    /// What was seen last on the bus: epoch, and x of the pose.
    last: (u64, f64),
}

impl Site {
    fn new() -> Self {
        let models = models();
        let home = tempfile::Builder::new().prefix("sim").tempdir_in("/dev/shm").unwrap();
        let state = home.path().join("state");
        copy_folder(&models.folder.path().join("template"), &state);
        let clock = SimulatedClock(Arc::new(AtomicI64::new(START_MS)));
        let mut daemons = Daemons::of(&toml(&state, models), home.path(), clock);
        for daemon in DAEMONS {
            daemons.start(daemon);
            (0..4).for_each(|input| drop(daemons.deliver(daemon, input)));
        }
        let at_s = START_MS / 1_000 + 60 * 86_400;
        assert!(matches!(daemons.schedule.ask(ScheduleRequest::SetPlanTime { at_s }), End::Done(_)));
        let robot = Robot::of(&daemons.shared.bus, 0);
        let reader = Bus::in_process(&daemons.shared.bus, Daemon::Groundplan);
        let alignments = reader.raw_subscriber(TopicName::Alignment).unwrap();
        let mut site = Self { _home: home, daemons, robot, alignments, last: (0, 0.0) };
        site.deliver();
        site
    }

    /// All daemons take what has come.
    fn deliver(&mut self) {
        for daemon in DAEMONS {
            (0..4).for_each(|input| drop(self.daemons.deliver(daemon, input)));
        }
    }

    /// The worker ends its job; a search finds this pose.
    fn finish(&self, x_m: f64) -> bool {
        self.daemons.aligner.finish(|job| result_of(job, &accepted([x_m, TRUE_POSE[1], TRUE_POSE[2]])))
    }

    /// Ends all jobs, with ticks after each.
    fn work(&mut self, x_m: f64) {
        while self.finish(x_m) {
            let ticked = self.daemons.align.tick();
            assert!(matches!(ticked, End::Done(())), "{ticked:?}");
        }
    }

    fn set_faults(&mut self, faults: DiskFaults) {
        self.daemons.set_faults(Daemon::SlamAlign, faults);
    }

    fn alignment_file(&self) -> PathBuf {
        self.daemons.shared.config.state.join("alignment.json")
    }

    fn saved(&self) -> Value {
        std::fs::read(self.alignment_file()).map(|bytes| serde_json::from_slice(&bytes).unwrap()).unwrap_or_default()
    }

    fn confirmations(&mut self) -> Confirmations {
        match self.daemons.align.ask(AlignRequest::ListConfirmed) {
            End::Done(AlignAnswer::Confirmations(confirmations)) => confirmations,
            other => panic!("{other:?}"),
        }
    }

    /// What is on the bus, in force and saved.
    fn state(&mut self) -> (Option<f64>, String, Confirmations, Value) {
        while let Some(sample) = self.alignments.take().unwrap() {
            let epoch = sample.header().epoch;
            assert!(self.last.0 < epoch, "epochs fall");
            let alignment = sample.of(topics::Alignment).unwrap().check().unwrap();
            let x_m = alignment.view().pose().map_or(f64::NAN, |pose| pose.map_from_slam[0]);
            self.last = (epoch, x_m);
        }
        let told = self.daemons.align.facts().unwrap().alignment.unwrap();
        let x_m = told.map_from_slam.map(|pose| pose.x_m);
        assert_eq!(x_m.unwrap_or(f64::NAN).to_bits(), self.last.1.to_bits(), "published is what is in force");
        (x_m, told.validity, self.confirmations(), self.saved())
    }

    /// A site with an effective pose.
    fn aligned() -> Self {
        let mut site = Self::new();
        site.robot.publish(0);
        site.deliver();
        site.work(TRUE_POSE[0]);
        let (x_m, validity, _, saved) = site.state();
        assert!(x_m.is_some() && saved["pose"].is_object(), "{validity} {saved}");
        site
    }

    /// Asks for a search that finds a pose elsewhere, which waits then.
    fn find_elsewhere(&mut self) {
        let request = AlignRequest::Align { hint: None, storey: None, places: KnownPlaces::default() };
        let End::Done(AlignAnswer::Search(search)) = self.daemons.align.ask(request) else { panic!("no search") };
        self.work(TRUE_POSE[0] + 2.0);
        let ended = self.daemons.align.ask(AlignRequest::SearchResult { search });
        let End::Done(AlignAnswer::SearchState(SearchState::Done { alignment, .. })) = ended else {
            panic!("{ended:?}")
        };
        let (_, validity, confirmations, _) = self.state();
        assert_eq!((validity.as_str(), confirmations.waiting.is_some()), ("waits_for_confirm", true));
        assert!(0 < alignment.epoch && alignment.epoch <= self.last.0, "{alignment:?} {:?}", self.last);
    }

    /// All walls stand and are compared with a map that sees through one of them.
    fn compared() -> Self {
        let mut site = Self::aligned();
        site.robot.publish(N_MAPS - 1);
        site.deliver();
        site.work(TRUE_POSE[0]);
        site
    }

    fn confirm_absent(&mut self) -> End<AlignAnswer> {
        self.daemons.align.ask(AlignRequest::ConfirmAbsent { elements: vec![east_wall().to_owned()] })
    }

    /// What fails is as if it had not been tried, on the bus, in force and on disk; the next try is another one.
    fn fails_and_changes_nothing(&mut self, mut act: impl FnMut(&mut Self) -> bool) {
        let before = self.state();
        for what in ["memory is full", "the disk is full", "the first publication fails"] {
            self.set_fault(what, true);
            assert!(!act(self), "{what}");
            self.set_fault(what, false);
            assert_eq!(format!("{:?}", self.state()), format!("{before:?}"), "{what}");
        }
    }

    fn set_fault(&mut self, what: &str, is_on: bool) {
        let bus = &self.daemons.shared.bus;
        match what {
            "memory is full" => bus.set_full(is_on),
            "the disk is full" => self.set_faults(DiskFaults { is_full: is_on, ..DiskFaults::default() }),
            _ if is_on => bus.fail_publish_after(0),
            _ => {}
        }
    }
}

fn is_done<T: std::fmt::Debug>(end: &End<T>) -> bool {
    assert!(!matches!(end, End::Died), "{end:?}");
    matches!(end, End::Done(_))
}

#[test]
fn an_alignment_that_cannot_be_committed_is_decided_again_at_the_next_look() {
    let mut site = Site::new();
    site.robot.publish(0);
    site.deliver();
    assert!(site.finish(TRUE_POSE[0]));
    site.fails_and_changes_nothing(|site| is_done(&site.daemons.align.tick()));
    assert!(is_done(&site.daemons.align.tick()));
    let (x_m, _, _, saved) = site.state();
    assert_eq!(x_m, Some(TRUE_POSE[0]));
    assert_eq!(saved["pose"]["map_from_slam"][0], TRUE_POSE[0]);
}

#[test]
fn a_confirmation_and_its_undoing_are_whole_or_not_at_all() {
    let mut site = Site::aligned();
    site.find_elsewhere();
    let pose = |site: &mut Site, request: AlignRequest| is_done(&site.daemons.align.ask(request));
    let waiting = site.state().2.waiting.unwrap();
    let confirm = || AlignRequest::ConfirmPose { waiting };
    let mut elsewhere = waiting;
    elsewhere.map_from_slam.x_m += 1.0;
    assert!(!pose(&mut site, AlignRequest::ConfirmPose { waiting: elsewhere }), "not what waits");
    site.fails_and_changes_nothing(|site| pose(site, confirm()));
    assert!(pose(&mut site, confirm()) && pose(&mut site, confirm()), "it may come twice");
    let (_, _, confirmed, saved) = site.state();
    assert!(confirmed.before_confirmed.is_some() && saved["before_confirmed"].is_array(), "{saved}");
    let (before, _) = confirmed.before_confirmed.unwrap();
    let undo = || AlignRequest::UndoPose { before };
    assert!(!pose(&mut site, AlignRequest::UndoPose { before: elsewhere }), "not what was confirmed");
    site.fails_and_changes_nothing(|site| pose(site, undo()));
    assert!(pose(&mut site, undo()) && pose(&mut site, undo()), "it may come twice");
    let (_, _, undone, saved) = site.state();
    assert!(undone.before_confirmed.is_none() && undone.waiting.is_some() && saved["before_confirmed"].is_null());
}

#[test]
fn a_map_file_is_taken_with_its_copy_or_not_at_all() {
    let mut site = Site::aligned();
    let folder = site.daemons.shared.config.state.parent().unwrap().to_owned();
    let file = save(1, &folder);
    let copies = |site: &Site| {
        let entries = std::fs::read_dir(&site.daemons.shared.config.state).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.starts_with("slam-map-")).count()
    };
    let setting = |site: &Site| site.daemons.align.facts().unwrap().setting;
    let read = |site: &mut Site| site.daemons.align.ask(AlignRequest::ReadSlamMap { file: file.clone() });
    site.fails_and_changes_nothing(|site| is_done(&read(site)));
    assert_eq!((copies(&site), setting(&site)), (0, None));
    for n_writes in 0..3 {
        let death = Some((n_writes, false));
        site.set_faults(DiskFaults { death, ..DiskFaults::default() });
        assert!(matches!(read(&mut site), End::Died));
        assert!(is_done(&site.daemons.start(Daemon::SlamAlign)));
        site.deliver();
        assert_eq!((copies(&site), setting(&site)), (0, None), "after {n_writes} writes");
    }
    assert!(is_done(&read(&mut site)));
    assert_eq!(copies(&site), 4, "image and description, each twice");
    assert!(setting(&site).is_some_and(|setting| setting.value.ends_with("map.yaml")));
    site.daemons.kill(Daemon::SlamAlign);
    assert!(is_done(&site.daemons.start(Daemon::SlamAlign)));
    assert!(setting(&site).is_some() && copies(&site) == 4);
}

#[test]
fn an_absence_is_confirmed_here_and_in_schedule_eval_or_nowhere() {
    let mut site = Site::compared();
    let before = site.state();
    site.daemons.aligner.take_tables(false);
    assert!(!is_done(&site.confirm_absent()));
    assert_eq!(format!("{:?}", site.state()), format!("{before:?}"));
    site.daemons.aligner.take_tables(true);
    assert!(is_done(&site.daemons.align.tick()));
    let has_it = |site: &Site| site.daemons.aligner.table().is_some_and(|table| table.contains(east_wall()));
    assert!(!has_it(&site));
    site.set_faults(DiskFaults { is_full: true, ..DiskFaults::default() });
    assert!(!is_done(&site.confirm_absent()));
    site.set_faults(DiskFaults::default());
    assert!(site.confirmations().absent.is_empty() && !has_it(&site));
    assert!(is_done(&site.confirm_absent()));
    assert!(has_it(&site) && site.confirmations().absent.len() == 1);
}

#[test]
fn what_is_on_disk_when_the_process_dies_is_in_force_afterwards_everywhere() {
    for is_after in [false, true] {
        let mut site = Site::compared();
        site.set_faults(DiskFaults { death: Some((0, is_after)), ..DiskFaults::default() });
        assert!(matches!(site.confirm_absent(), End::Died));
        assert!(is_done(&site.daemons.start(Daemon::SlamAlign)));
        site.deliver();
        let is_absent = site.confirmations().absent.len() == 1;
        let is_in_schedule = site.daemons.aligner.table().is_some_and(|table| table.contains(east_wall()));
        assert_eq!((is_absent, is_in_schedule), (is_after, is_after));
        site.work(TRUE_POSE[0]);
        let (x_m, _, _, saved) = site.state();
        assert_eq!(saved["pose"]["map_from_slam"][0].as_f64().map(f64::round), x_m.map(f64::round));
    }
}
