//! The set that a robot holds, from publishers to the verdict.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../bus/tests/common/mod.rs"]
mod common;

use bus::{Bus, Daemon, Keeper, RawSample, Stamp, TopicName, topics};
use common::{Attended, Fixture, origin, until};
use messages::{ContentHash, GridsBuilder, GridsHead, RobotProfile, ScheduleState, ScheduleStateBuilder};
use site_view::{ClockTime, ConsistentSet, MapVerdict};

#[test]
fn a_consumer_uses_what_belongs_together() {
    let fixture = Fixture::shared();
    let domain = &fixture.domain;
    let _keeper = Keeper::start(domain).unwrap();
    let eval = Attended::join(domain, Daemon::ScheduleEval);
    let schedule_states = eval.bus.publisher(topics::ScheduleState, 64).unwrap();
    let rasterize = Attended::join(domain, Daemon::Rasterize);
    let grids = rasterize.bus.publisher(topics::Grids, 64).unwrap();
    let index_of = |schedule_state_hash: ContentHash| {
        let head = GridsHead {
            site_hash: ContentHash::from_bits(3),
            schedule_state_hash,
            plan_time_s: 0,
            robot: RobotProfile::DEFAULT,
        };
        GridsBuilder::of(head, &[], "default").finish()
    };
    let archives =
        [3, 4].map(|n_spaces| ScheduleStateBuilder::everything_built(ContentHash::from_bits(3), 9, n_spaces).finish());
    let hash = |n: usize| ScheduleState::open(archives[n].bytes()).unwrap().content_hash();
    schedule_states.publish_copy(archives[0].bytes(), origin(1)).unwrap();
    grids.publish_copy(index_of(hash(0)).bytes(), origin(1)).unwrap();

    let (bus, mut waiter) = Bus::join(domain, Daemon::Robot).unwrap();
    let topics = [TopicName::ScheduleState, TopicName::Grids].map(|t| bus.raw_subscriber(t).unwrap());
    let heartbeats = bus.status_reader().unwrap();
    let mut set = ConsistentSet::new(Stamp(0));
    let mut wait_for = |verdict, clock| {
        until(&mut waiter, "the verdict", || {
            for topic in &topics {
                while let Some(sample) = topic.take().unwrap() {
                    set.insert(Stamp(1), sample).unwrap();
                }
            }
            while let Some(daemon) = heartbeats.take().unwrap().and_then(|h| Daemon::from_id(h.daemon)) {
                set.insert_heartbeat(Stamp(1), daemon);
            }
            (set.verdict(Stamp(2), clock) == verdict).then_some(())
        });
    };
    wait_for(MapVerdict::Current, ClockTime::Plan(0));
    schedule_states.publish_copy(archives[1].bytes(), origin(2)).unwrap();
    wait_for(MapVerdict::Overtaken, ClockTime::Unknown);
    grids.publish_copy(index_of(hash(1)).bytes(), origin(2)).unwrap();
    wait_for(MapVerdict::Current, ClockTime::Unknown);
    let sample = set.schedule_state().unwrap();
    assert_eq!((sample.header().epoch, ScheduleState::open(sample.bytes()).unwrap().spaces.len()), (2, 4));
}

#[test]
fn a_set_goes_to_other_threads() {
    fn is_send<T: Send>() {}
    is_send::<ConsistentSet<RawSample>>();
}
