//! Revisions that find no room: what is tried again, and what is not.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/models.rs"]
#[expect(dead_code, reason = "other tests use the rest of it")]
mod models;

use bus::Daemon;
use daemon::IngestRequest;
use models::{START_MS, models};
use site_simulator::{DAEMONS, Daemons, End, SimulatedClock};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicI64;

/// A site whose configuration names these models, or none, and whose memory is full.
struct FullSite {
    daemons: Daemons,
    clock: SimulatedClock,
    _home: tempfile::TempDir,
}

impl FullSite {
    fn of(configured: &[PathBuf]) -> Self {
        let home = tempfile::tempdir().unwrap();
        let configured: Vec<String> = configured.iter().map(|path| path.display().to_string()).collect();
        let [rules, state] = [models().folder.path().join("rules.toml"), home.path().join("state")];
        let toml = format!("models = {configured:?}\nstate = {state:?}\n[schedule]\nrules = {rules:?}\n");
        let clock = SimulatedClock(Arc::new(AtomicI64::new(START_MS)));
        let mut daemons = Daemons::of(&toml, home.path(), clock.clone());
        daemons.shared.bus.set_full(true);
        for daemon in DAEMONS {
            daemons.start(daemon);
        }
        Self { daemons, clock, _home: home }
    }

    fn load(&mut self, dry_run: bool) -> End<daemon::IngestAnswer> {
        let models = vec![models().paths[0].clone()];
        self.daemons.ingest.ask(IngestRequest::Load { models, dry_run, force: false })
    }

    /// True if there is a site once memory has room and a minute has passed.
    fn has_site_later(&mut self) -> bool {
        self.daemons.shared.bus.set_full(false);
        for _ in 0..12 {
            self.clock.pass(5_000);
            self.daemons.tick(Daemon::IfcIngest);
            (0..2).for_each(|input| drop(self.daemons.deliver(Daemon::ScheduleEval, input)));
        }
        self.daemons.ingest.facts().unwrap().site.epoch > 0
    }
}

#[test]
fn a_first_model_that_finds_no_room_is_loaded_once_there_is_some() {
    let mut site = FullSite::of(&[]);
    assert!(matches!(site.load(false), End::Failed(_)));
    assert!(site.has_site_later());
}

#[test]
fn a_model_that_was_only_to_be_compared_is_never_loaded() {
    let mut site = FullSite::of(&[]);
    assert!(matches!(site.load(true), End::Failed(_)));
    assert!(!site.has_site_later());
    assert_eq!(site.daemons.ingest.standing().unwrap().error, None);
}

#[test]
fn the_models_of_the_site_are_read_although_a_comparison_of_others_found_no_room() {
    let mut site = FullSite::of(&[models().paths[1].clone()]);
    assert!(matches!(site.load(true), End::Failed(_)));
    assert!(site.has_site_later());
}
