//! A holder of sets and a judge of maps that were passed on never contradict each other.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::{Daemon, Stamp};
use messages::{ContentHash, GridSlotRecord, GridsHead, RobotProfile, ScheduleStateBuilder, ScheduleStateHead};
use proptest::prelude::*;
use site_view::{
    ClockTime, ConsistentSet, FRESH_TOLERANCE, Freshness, MapState, MapVerdict, MapsInUse, NextState, NoMapReason,
};
use std::collections::BTreeSet;
use std::time::Duration;

/// Something that a consumer hears.
#[derive(Debug, Clone)]
enum Event {
    Heartbeat(Daemon),
    /// Of this hash and site.
    State(u64, u64),
    /// Of a schedule state and a site, with one grid of its own.
    Index(u64, u64),
    /// In milliseconds from the beginning.
    Due(i64),
    ClockDistrust,
    PlanTimeStands,
    Milliseconds(u64),
}

fn event() -> impl Strategy<Value = Event> {
    let (hash, site) = (1..4u64, prop_oneof![9 => Just(1u64), 1 => Just(2u64)]);
    prop_oneof![
        6 => (0..Daemon::ALL.len()).prop_map(|n| Event::Heartbeat(Daemon::ALL[n])),
        4 => (hash.clone(), site.clone()).prop_map(|(hash, site)| Event::State(hash, site)),
        4 => (hash, site).prop_map(|(state, site)| Event::Index(state, site)),
        1 => (0..20_000i64).prop_map(Event::Due),
        1 => Just(Event::ClockDistrust),
        2 => Just(Event::PlanTimeStands),
        9 => (0..1_500u64).prop_map(Event::Milliseconds),
    ]
}

/// Both consumers in the same generation of the bus; the second one passes maps on as soon as their index is there.
struct Both {
    set: ConsistentSet<()>,
    freshness: Freshness,
    began: Stamp,
    now: Stamp,
    /// When the set last said that its maps are current; the beginning before that.
    current_at: Stamp,
}

impl Both {
    fn new() -> Self {
        let began = Stamp(1_000_000_000_000);
        let mut freshness = Freshness::default();
        freshness.joined(began);
        Self { set: ConsistentSet::new(began), freshness, began, now: began, current_at: began }
    }

    fn hear(&mut self, event: &Event) {
        let set_next_state = |both: &mut Self, next: NextState| {
            both.set.set_next_state(next.clone());
            both.freshness.set_next_state(next);
        };
        match *event {
            Event::Heartbeat(daemon) => {
                self.set.insert_heartbeat(self.now, daemon);
                self.freshness.on_heartbeat(self.now, daemon);
            }
            Event::State(hash, site) => {
                let site_hash = ContentHash::from_bits(site);
                let everything = ScheduleStateBuilder::everything_built(site_hash, 0, 0).head;
                // A hash is that of the content, its site included.
                let (hash, head) =
                    (ContentHash::from_bits(10 * site + hash), ScheduleStateHead { site_hash, ..everything });
                self.set.insert_schedule_state(self.now, hash, &head, ());
                self.freshness.on_schedule_state(self.now, hash, &head);
            }
            Event::Index(state, site) => {
                let [site_hash, schedule_state_hash, index_hash] =
                    [site, 10 * site + state, 100 + 10 * site + state].map(ContentHash::from_bits);
                let robot = RobotProfile::DEFAULT;
                let head = GridsHead { site_hash, schedule_state_hash, plan_time_s: 0, robot };
                let content_hash = schedule_state_hash;
                let grids = vec![GridSlotRecord { map_storey: 0, cell_tenths: 500, content_hash }];
                self.set.insert_grid(self.now, bus::GridSlot::new(0).unwrap(), content_hash, ());
                self.set.insert_index(self.now, index_hash, &head, &grids, ());
                self.freshness.on_index(self.now, &head, grids.clone());
                self.freshness.on_maps(MapsInUse { epoch: 1, site_hash, grids });
            }
            Event::Due(ms) => set_next_state(self, NextState::Due { utc_ms: ms }),
            Event::ClockDistrust => set_next_state(self, NextState::Unknown { why: "clock_untrusted".to_owned() }),
            Event::PlanTimeStands => set_next_state(self, NextState::None),
            Event::Milliseconds(ms) => self.now = self.now + Duration::from_millis(ms),
        }
    }

    fn check(&mut self) -> Result<(), TestCaseError> {
        let utc_ms = self.now.since(self.began).as_millis() as i64;
        let verdict = self.set.verdict(self.now, ClockTime::Machine(utc_ms));
        let state = self.freshness.state(self.now, utc_ms);
        if verdict == MapVerdict::Current {
            self.current_at = self.now;
        }
        let is_stale = matches!(state, MapState::Stale { .. });
        let tolerated = self.now.since(self.current_at) < FRESH_TOLERANCE;
        match &verdict {
            MapVerdict::Current => {
                prop_assert_eq!(&state, &MapState::Fresh { outdated_storeys: BTreeSet::new() });
            }
            MapVerdict::Overtaken => {
                prop_assert!(state == MapState::Unknown || is_stale && !tolerated, "{:?}", state);
            }
            MapVerdict::Hold => prop_assert!(is_stale, "{:?}", state),
            MapVerdict::NoMap(NoMapReason::Incomplete) => {
                prop_assert!(state == MapState::Unknown && tolerated || is_stale && !tolerated, "{:?}", state);
            }
            MapVerdict::NoMap(reason) => prop_assert_eq!(&state, &MapState::Stale { reason: reason.to_string() }),
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn a_set_and_maps_that_were_passed_on_at_once_are_used_and_held_alike(events in prop::collection::vec(event(), 1..60)) {
        let mut both = Both::new();
        both.check()?;
        for event in &events {
            both.hear(event);
            both.check()?;
        }
    }
}
