//! Files of the bus that are deleted or replaced from outside: the keeper makes a new generation, and participants join it.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod common;

use bus::{Bus, Daemon, Domain, DomainError, Keeper, topics};
use common::{Attended, Fixture, eventually, publish, sample_of};
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Does harm to a domain with a keeper and a publisher, and expects a new generation in which everything works.
fn leads_to_a_new_generation(what: &str, harm: impl Fn(&Fixture, u64)) {
    let fixture = Fixture::shared();
    let mut keeper = Keeper::start(&fixture.domain).unwrap();
    let (old, mut waiter) = Bus::join(&fixture.domain, Daemon::ScheduleEval).unwrap();
    let publisher = old.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1, 1000);
    assert_eq!(keeper.renew_if_damaged().unwrap(), None, "{what}: nothing was done yet");
    harm(&fixture, old.generation());
    let missing = eventually(what, || {
        waiter.wait(Duration::from_millis(10)).unwrap();
        keeper.renew_if_damaged().unwrap()
    });
    assert!(keeper.generation() > old.generation(), "{what}: {}", missing.display());
    eventually(what, || Some(waiter.wait(Duration::from_millis(10)).unwrap()).filter(|wake| wake.superseded));
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    assert_eq!(producer.bus.generation(), keeper.generation(), "{what}");
    let again = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&again, 2, 1000);
    let (bus, mut at_consumer) = Bus::join(&fixture.domain, Daemon::Rasterize).unwrap();
    sample_of(&mut at_consumer, &bus.subscriber(topics::ScheduleState).unwrap(), 2);
    drop((old, publisher, waiter));
    keeper.tick().unwrap();
    assert_eq!(keeper.renew_if_damaged().unwrap(), None, "{what}: the new generation is whole");
    let old_prefix = format!("{}{}_", fixture.prefix(), keeper.generation() - 1);
    let is_old = |segment: &PathBuf| segment.file_name().unwrap().to_string_lossy().starts_with(&old_prefix);
    assert!(!fixture.segments().iter().any(is_old), "{what}: segments of the old generation are left");
}

/// The first segment whose name ends so.
fn segment(fixture: &Fixture, suffix: &str) -> PathBuf {
    fixture.segments().into_iter().find(|s| s.to_string_lossy().ends_with(suffix)).unwrap()
}

#[test]
fn segments_that_are_deleted_lead_to_a_new_generation() {
    leads_to_a_new_generation("all segments", |fixture, _| {
        fixture.segments().iter().for_each(|segment| fs::remove_file(segment).unwrap());
    });
    for suffix in [".global_mgmt", ".dynamic"] {
        leads_to_a_new_generation(suffix, |fixture, _| fs::remove_file(segment(fixture, suffix)).unwrap());
    }
}

#[test]
fn a_deleted_segment_of_a_publisher_leads_to_a_new_generation() {
    leads_to_a_new_generation("a publisher's segment", |fixture, _| {
        fs::remove_file(segment(fixture, "__mgmt.data")).unwrap();
    });
}

#[test]
fn a_folder_that_is_deleted_is_made_again_with_a_new_generation() {
    leads_to_a_new_generation("the folder", |fixture, _| {
        fs::remove_dir_all(fixture.root()).unwrap();
    });
    leads_to_a_new_generation("folder and segments", |fixture, _| {
        fs::remove_dir_all(fixture.root()).unwrap();
        fixture.segments().iter().for_each(|segment| fs::remove_file(segment).unwrap());
    });
    leads_to_a_new_generation("the folder, which others make", |fixture, _| {
        fs::remove_dir_all(fixture.root()).unwrap();
        fs::create_dir(fixture.root()).unwrap();
    });
}

#[test]
fn files_of_the_folder_that_are_deleted_or_replaced_lead_to_a_new_generation() {
    leads_to_a_new_generation("the generation's folder", |fixture, n| {
        fs::remove_dir_all(fixture.root().join(n.to_string())).unwrap();
    });
    let replaced = |path: &Path| {
        fs::remove_file(path).unwrap();
        fs::write(path, "").unwrap();
    };
    leads_to_a_new_generation("the file that names it", |fixture, _| {
        fs::remove_file(fixture.root().join("generation")).unwrap();
    });
    leads_to_a_new_generation("another generation", |fixture, _| {
        fs::write(fixture.root().join("generation"), "nonsense").unwrap();
    });
    leads_to_a_new_generation("the keeper's lock", |fixture, _| replaced(&fixture.root().join("keeper.lock")));
    leads_to_a_new_generation("the members' lock", |fixture, n| {
        replaced(&fixture.root().join(format!("{n}.lock")));
    });
}

#[test]
fn a_keeper_leaves_when_another_one_has_made_the_folder_anew() {
    let fixture = Fixture::shared();
    let mut keeper = Keeper::start(&fixture.domain).unwrap();
    fs::remove_dir_all(fixture.root()).unwrap();
    let other = Keeper::start(&fixture.domain).unwrap();
    assert!(other.generation() > keeper.generation(), "segments of the first are left");
    assert!(matches!(keeper.renew_if_damaged(), Err(DomainError::KeeperRuns { .. })));
    drop(keeper);
    assert!(Bus::join(&fixture.domain, Daemon::Robot).is_ok_and(|(bus, _)| bus.generation() == other.generation()));
}

#[test]
fn the_bus_is_for_its_user_alone() {
    let fixture = Fixture::shared();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let set = |path: &Path, mode| fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
    set(fixture.root(), 0o755);
    let keeper = Keeper::start(&fixture.domain).unwrap();
    assert_eq!(mode(fixture.root()), 0o700);
    let modes = |fixture: &Fixture| fixture.segments().iter().map(|s| mode(s) & 0o077).max();
    assert_eq!(modes(&fixture), Some(0));
    set(&segment(&fixture, ".global_mgmt"), 0o666);
    set(fixture.root(), 0o750);
    keeper.tick().unwrap();
    assert_eq!(mode(fixture.root()), 0o700, "also when a service manager opened it again");
    assert_eq!((modes(&fixture), mode(&segment(&fixture, ".global_mgmt"))), (Some(0), 0o600));
    let (_bus, _waiter) = Bus::join(&fixture.domain, Daemon::Robot).unwrap();
    assert_eq!(modes(&fixture), Some(0));
}

#[test]
fn a_folder_that_others_use_is_refused() {
    let fixture = Fixture::shared();
    let shared = fixture.root().join("shared");
    fs::create_dir(&shared).unwrap();
    fs::set_permissions(&shared, Permissions::from_mode(0o755)).unwrap();
    fs::write(shared.join("others.pid"), "1").unwrap();
    let domain = Domain::shared(fixture.prefix(), &shared).unwrap();
    let refused = Keeper::start(&domain).map(|_| ()).unwrap_err();
    assert!(
        matches!(&refused, DomainError::RootInUse { .. }) && refused.to_string().contains("others.pid"),
        "{refused}"
    );
    assert_eq!(fs::metadata(&shared).unwrap().permissions().mode() & 0o777, 0o755);
}
