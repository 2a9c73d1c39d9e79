//! The newest site, schedule state, grids and mission plan that belong together, and whether a robot may use them. Samples of
//! topics arrive in any order; no bus and no clock inside: times are arguments.
//!
//! Samples arrive in any order. This is logic without a bus and without a clock of its own.

use crate::latched::RawSample;
use crate::names::{Daemon, GridSlot, TopicName};
use crate::stamp::Stamp;
use messages::{
    ArchiveError, GridSlotRecord, Grids, GridsHead, MissionPlan, MissionPlanHead, ScheduleState, ScheduleStateHead,
};
use std::time::Duration;

/// A newer schedule state without its grids stops the robot after this long.
pub const GRIDS_LATE: Duration = Duration::from_secs(1);

/// Heartbeats come this often.
pub const HEARTBEAT_PERIOD: Duration = Duration::from_secs(1);

/// Heartbeats that may be missed: at this many there is no map.
pub const MISSED_HEARTBEATS: u32 = 3;

/// Daemons without which maps grow old unnoticed.
const WATCHED: [Daemon; 2] = [Daemon::ScheduleEval, Daemon::Rasterize];

/// How a robot may use the maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapVerdict {
    /// The set is of the newest schedule state: use it.
    Current,
    /// A newer schedule state is here, its grids are not yet: use the set, but do not enter what
    /// [`ConsistentSet::newest_schedule_state`] blocks.
    Overtaken,
    /// The grids of the newest schedule state are late: stand still.
    Hold,
    /// There is no map.
    NoMap(NoMapReason),
}

/// Why there is no map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoMapReason {
    /// Schedule state, index and grids have never matched yet.
    #[error("grids, index and schedule state have not come together yet")]
    Incomplete,
    /// The plan time has passed the end of the newest schedule state.
    #[error("the plan time is past the validity of the schedule state, and no newer schedule state has come")]
    Expired,
    /// A daemon that keeps the map up to date is silent.
    #[error("{daemon} has missed {MISSED_HEARTBEATS} heartbeats")]
    Silent {
        /// Which.
        daemon: Daemon,
    },
}

/// Key of a schedule state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ScheduleStateKey {
    hash: u64,
    site: u64,
    valid_until_s: i64,
    at: Stamp,
}

/// Key of an index.
#[derive(Debug)]
struct IndexKey {
    hash: u64,
    schedule_state: u64,
    site: u64,
    grids: Vec<u64>,
}

/// Key of a mission plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct MissionPlanKey {
    grids: u64,
    schedule_state: u64,
    site: u64,
}

/// A sample with the key by which it is matched.
#[derive(Debug)]
struct KeyedSample<F, T> {
    key: F,
    sample: T,
}

/// Two samples of a topic: the one in the set, and the newest if it is not in the set yet.
#[derive(Debug)]
struct TopicSamples<F, T> {
    used: Option<KeyedSample<F, T>>,
    newest: Option<KeyedSample<F, T>>,
}

impl<F, T> TopicSamples<F, T> {
    const EMPTY: Self = Self { used: None, newest: None };

    fn insert(&mut self, key: F, sample: T) {
        self.newest = Some(KeyedSample { key, sample });
    }

    fn newest(&self) -> Option<&KeyedSample<F, T>> {
        self.newest.as_ref().or(self.used.as_ref())
    }

    /// True if one of the two fits.
    fn has(&self, fits: impl Fn(&F) -> bool) -> bool {
        self.newest.iter().chain(&self.used).any(|s| fits(&s.key))
    }

    /// Moves the newest into the set if it fits; else the one in the set stays.
    fn promote(&mut self, fits: impl Fn(&F) -> bool) {
        if self.newest.as_ref().is_some_and(|s| fits(&s.key)) {
            self.used = self.newest.take();
        }
    }
}

/// Holds the last set of schedule state, index and grids that match, while newer samples arrive one by one.
///
/// `T` is what stands for a sample: [`RawSample`] for a consumer, anything in a test. At most two samples of a topic
/// are held. A set that is complete stays until the next one is.
#[derive(Debug)]
pub struct ConsistentSet<T> {
    schedule_state: TopicSamples<ScheduleStateKey, T>,
    index: TopicSamples<IndexKey, T>,
    grids: [TopicSamples<u64, T>; GridSlot::COUNT],
    mission_plan: TopicSamples<MissionPlanKey, T>,
    heard: [Stamp; WATCHED.len()],
}

impl<T> ConsistentSet<T> {
    /// Nothing seen; heartbeats count from `now`.
    pub fn new(now: Stamp) -> Self {
        Self {
            schedule_state: TopicSamples::EMPTY,
            index: TopicSamples::EMPTY,
            grids: [const { TopicSamples::EMPTY }; GridSlot::COUNT],
            mission_plan: TopicSamples::EMPTY,
            heard: [now; WATCHED.len()],
        }
    }

    /// A schedule state has come; `hash` is its content hash. One that says the same as the last one is not new.
    pub fn insert_schedule_state(&mut self, now: Stamp, hash: u64, head: &ScheduleStateHead, sample: T) {
        let key = ScheduleStateKey { hash, site: head.site_hash, valid_until_s: head.valid_until_s, at: now };
        // A restarted producer repeats itself; a set in use stays what it is.
        if self.schedule_state.newest().is_none_or(|s| s.key.hash != hash) {
            self.schedule_state.insert(key, sample);
            self.advance();
        }
    }

    /// An index of grids has come; `hash` is its content hash. Its n-th record speaks of slot n; there are never more
    /// than [`GridSlot::COUNT`].
    pub fn insert_index(&mut self, hash: u64, head: &GridsHead, slots: &[GridSlotRecord], sample: T) {
        let grids = slots.iter().map(|s| s.content_hash).collect();
        self.index
            .insert(IndexKey { hash, schedule_state: head.schedule_state_hash, site: head.site_hash, grids }, sample);
        self.advance();
    }

    /// A grid has come; `hash` is its content hash.
    pub fn insert_grid(&mut self, slot: GridSlot, hash: u64, sample: T) {
        self.grids[slot.index()].insert(hash, sample);
        self.advance();
    }

    /// A mission plan has come; `grids_hash` is the content hash of the index that it was made from, as in its sample's
    /// header.
    pub fn insert_mission_plan(&mut self, grids_hash: u64, head: &MissionPlanHead, sample: T) {
        self.mission_plan.insert(
            MissionPlanKey { grids: grids_hash, schedule_state: head.schedule_state_hash, site: head.site_hash },
            sample,
        );
        self.advance();
    }

    /// A heartbeat has come.
    pub fn insert_heartbeat(&mut self, now: Stamp, daemon: Daemon) {
        for (heard, watched) in self.heard.iter_mut().zip(WATCHED) {
            if watched == daemon {
                *heard = now;
            }
        }
    }

    /// What the consumer may do. `plan_time_s` is the plan time in civil seconds; `None` if the clock stands.
    pub fn verdict(&self, now: Stamp, plan_time_s: Option<i64>) -> MapVerdict {
        for (heard, daemon) in self.heard.iter().zip(WATCHED) {
            if now.since(*heard) >= HEARTBEAT_PERIOD * MISSED_HEARTBEATS {
                return MapVerdict::NoMap(NoMapReason::Silent { daemon });
            }
        }
        let (Some(used), Some(newest)) = (&self.schedule_state.used, self.schedule_state.newest()) else {
            return MapVerdict::NoMap(NoMapReason::Incomplete);
        };
        let until = newest.key.valid_until_s;
        if until != ScheduleStateHead::NO_TIME && plan_time_s.is_some_and(|now| now > until) {
            return MapVerdict::NoMap(NoMapReason::Expired);
        }
        if newest.key.hash == used.key.hash {
            MapVerdict::Current
        } else if now.since(newest.key.at) < GRIDS_LATE {
            MapVerdict::Overtaken
        } else {
            MapVerdict::Hold
        }
    }

    /// When to ask for the verdict again if nothing comes before.
    pub fn next_change(&self, now: Stamp) -> Stamp {
        let silent = self.heard.iter().map(|heard| *heard + HEARTBEAT_PERIOD * MISSED_HEARTBEATS);
        let late = self.schedule_state.newest.iter().map(|s| s.key.at + GRIDS_LATE);
        silent.chain(late).filter(|at| *at > now).min().unwrap_or(now + HEARTBEAT_PERIOD)
    }

    /// The schedule state of the set.
    pub fn schedule_state(&self) -> Option<&T> {
        self.schedule_state.used.as_ref().map(|s| &s.sample)
    }

    /// The newest schedule state: spaces that it blocks must not be entered, also if those of the set are open.
    pub fn newest_schedule_state(&self) -> Option<&T> {
        self.schedule_state.newest().map(|s| &s.sample)
    }

    /// The index of the set.
    pub fn index(&self) -> Option<&T> {
        self.index.used.as_ref().map(|s| &s.sample)
    }

    /// A grid of the set.
    pub fn grid(&self, slot: GridSlot) -> Option<&T> {
        self.grids[slot.index()].used.as_ref().map(|s| &s.sample)
    }

    /// The mission plan, if it is of the set's schedule state and grids.
    pub fn mission_plan(&self) -> Option<&T> {
        let mission_plan = self.mission_plan.used.as_ref()?;
        is_of(&mission_plan.key, &self.schedule_state.used, &self.index.used).then_some(&mission_plan.sample)
    }

    /// Makes the newest samples the set, if they match.
    fn advance(&mut self) {
        if self.is_complete() {
            self.schedule_state.promote(|_| true);
            self.index.promote(|_| true);
            let wanted = self.index.used.as_ref().map_or(&[][..], |s| &s.key.grids);
            for (slot, held) in self.grids.iter_mut().enumerate() {
                match wanted.get(slot) {
                    Some(hash) => held.promote(|h| h == hash),
                    None => held.used = None,
                }
            }
        }
        self.mission_plan.promote(|p| is_of(p, &self.schedule_state.used, &self.index.used));
    }

    /// True if the newest schedule state, the newest index and grids at hand match, and are not the set already.
    fn is_complete(&self) -> bool {
        let (Some(schedule_state), Some(index)) = (self.schedule_state.newest(), self.index.newest()) else {
            return false;
        };
        let matches = index.key.schedule_state == schedule_state.key.hash && index.key.site == schedule_state.key.site;
        let grids = &index.key.grids;
        let all_there = self.grids.iter().zip(grids).all(|(held, hash)| held.has(|h| h == hash));
        matches && grids.len() <= GridSlot::COUNT && all_there
    }
}

fn is_of<T>(
    mission_plan: &MissionPlanKey,
    schedule_state: &Option<KeyedSample<ScheduleStateKey, T>>,
    index: &Option<KeyedSample<IndexKey, T>>,
) -> bool {
    let (Some(schedule_state), Some(index)) = (schedule_state, index) else { return false };
    (mission_plan.site, mission_plan.schedule_state, mission_plan.grids)
        == (schedule_state.key.site, schedule_state.key.hash, index.key.hash)
}

impl ConsistentSet<RawSample> {
    /// A sample of a topic has come; one of a topic that has no part in the set is dropped.
    ///
    /// # Errors
    /// A damaged archive: the set stays as it is. Grids are not looked into, their views do that.
    pub fn insert(&mut self, now: Stamp, sample: RawSample) -> Result<(), ArchiveError> {
        let header = *sample.header();
        match sample.topic() {
            TopicName::ScheduleState => {
                let head = *ScheduleState::open(sample.bytes())?.head;
                self.insert_schedule_state(now, header.content_hash, &head, sample);
            }
            TopicName::Grids => {
                let grids = Grids::open(sample.bytes())?;
                let (head, slots) = (*grids.head, grids.slots.to_vec());
                self.insert_index(header.content_hash, &head, &slots, sample);
            }
            TopicName::Grid(slot) => self.insert_grid(slot, header.content_hash, sample),
            TopicName::MissionPlan => {
                let head = *MissionPlan::open(sample.bytes())?.head;
                self.insert_mission_plan(header.inputs.grids, &head, sample);
            }
            TopicName::Site | TopicName::Tasks | TopicName::SlamMap | TopicName::Alignment | TopicName::Deviations => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{RobotProfile, ScheduleStateBuilder};

    const SITE: u64 = 1;

    fn slot(index: usize) -> GridSlot {
        GridSlot::new(index).unwrap()
    }

    fn at(milliseconds: u64) -> Stamp {
        Stamp(1_000_000_000_000) + Duration::from_millis(milliseconds)
    }

    /// A set with heartbeats of all daemons until `until_ms`.
    struct TestSet {
        set: ConsistentSet<String>,
    }

    impl TestSet {
        fn new() -> Self {
            Self { set: ConsistentSet::new(at(0)) }
        }

        fn schedule_state(&mut self, ms: u64, hash: u64, valid_until_s: i64) -> &mut Self {
            let everything = ScheduleStateBuilder::everything_built(SITE, 0, 0).head;
            let head = ScheduleStateHead { valid_until_s, ..everything };
            self.set.insert_schedule_state(at(ms), hash, &head, format!("schedule state {hash}"));
            self
        }

        fn grid(&mut self, index: usize, hash: u64) -> &mut Self {
            self.set.insert_grid(slot(index), hash, format!("grid {hash}"));
            self
        }

        fn index(&mut self, schedule_state: u64, hashes: &[u64]) -> &mut Self {
            let head = GridsHead {
                site_hash: SITE,
                schedule_state_hash: schedule_state,
                plan_time_s: 0,
                robot: RobotProfile::DEFAULT,
            };
            let record = |&content_hash| GridSlotRecord { map_storey: 0, cell_tenths: 500, content_hash };
            let slots: Vec<_> = hashes.iter().map(record).collect();
            self.set.insert_index(schedule_state + 100, &head, &slots, format!("index {schedule_state}"));
            self
        }

        fn mission_plan(&mut self, schedule_state: u64) -> &mut Self {
            let head = MissionPlanHead { site_hash: SITE, schedule_state_hash: schedule_state, ..Zeroable::zeroed() };
            self.set.insert_mission_plan(schedule_state + 100, &head, format!("mission plan {schedule_state}"));
            self
        }

        fn heartbeat(&mut self, ms: u64) -> &mut Self {
            for daemon in Daemon::ALL {
                self.set.insert_heartbeat(at(ms), daemon);
            }
            self
        }

        fn expect_verdict(&mut self, ms: u64, verdict: MapVerdict) -> &mut Self {
            assert_eq!(self.set.verdict(at(ms), Some(50)), verdict);
            self
        }

        fn holds(&mut self, schedule_state: &str, grids: &[&str], mission_plan: Option<&str>) -> &mut Self {
            assert_eq!(self.set.schedule_state().map(String::as_str), Some(schedule_state));
            let found: Vec<_> = GridSlot::all().filter_map(|s| self.set.grid(s)).collect();
            assert_eq!(found, grids);
            assert_eq!(self.set.mission_plan().map(String::as_str), mission_plan);
            self
        }
    }

    fn complete() -> TestSet {
        let mut test_set = TestSet::new();
        test_set.schedule_state(0, 10, 100).grid(0, 20).grid(1, 21).index(10, &[20, 21]).mission_plan(10);
        test_set
    }

    #[test]
    fn a_set_is_used_when_all_its_parts_are_there_in_any_order() {
        complete().expect_verdict(1, MapVerdict::Current).holds(
            "schedule state 10",
            &["grid 20", "grid 21"],
            Some("mission plan 10"),
        );
        let mut test_set = TestSet::new();
        test_set
            .mission_plan(10)
            .index(10, &[20, 21])
            .grid(1, 21)
            .expect_verdict(1, MapVerdict::NoMap(NoMapReason::Incomplete));
        test_set.schedule_state(2, 10, 100).expect_verdict(2, MapVerdict::NoMap(NoMapReason::Incomplete));
        test_set.grid(0, 20).expect_verdict(3, MapVerdict::Current).holds(
            "schedule state 10",
            &["grid 20", "grid 21"],
            Some("mission plan 10"),
        );
    }

    #[test]
    fn grids_that_come_before_their_index_do_not_disturb_the_set() {
        let mut test_set = complete();
        test_set.schedule_state(10, 11, 200).grid(0, 30).expect_verdict(20, MapVerdict::Overtaken);
        test_set.holds("schedule state 10", &["grid 20", "grid 21"], Some("mission plan 10"));
        assert_eq!(test_set.set.newest_schedule_state().map(String::as_str), Some("schedule state 11"));
        // The storey that did not change is not sent again.
        test_set.index(11, &[30, 21]).expect_verdict(30, MapVerdict::Current);
        test_set.holds("schedule state 11", &["grid 30", "grid 21"], None);
        test_set.mission_plan(11).holds("schedule state 11", &["grid 30", "grid 21"], Some("mission plan 11"));
    }

    #[test]
    fn a_plan_that_comes_before_its_grids_waits_for_them() {
        let mut test_set = complete();
        test_set.schedule_state(10, 11, 200).mission_plan(11).holds(
            "schedule state 10",
            &["grid 20", "grid 21"],
            Some("mission plan 10"),
        );
        test_set.grid(0, 30).index(11, &[30, 21]).holds(
            "schedule state 11",
            &["grid 30", "grid 21"],
            Some("mission plan 11"),
        );
    }

    #[test]
    fn a_plan_of_other_grids_of_the_same_schedule_state_is_none() {
        let mut test_set = complete();
        let head = MissionPlanHead { site_hash: SITE, schedule_state_hash: 10, ..Zeroable::zeroed() };
        test_set.set.insert_mission_plan(999, &head, "other robot".to_owned());
        test_set.holds("schedule state 10", &["grid 20", "grid 21"], Some("mission plan 10"));
    }

    #[test]
    fn late_grids_make_the_robot_stand_still_until_they_come() {
        let mut test_set = complete();
        test_set
            .schedule_state(10, 11, 200)
            .expect_verdict(1009, MapVerdict::Overtaken)
            .expect_verdict(1010, MapVerdict::Hold);
        assert_eq!(test_set.set.next_change(at(500)), at(1010));
        // Grids of yet another schedule state do not help.
        test_set.grid(0, 30).index(9, &[30, 21]).expect_verdict(1020, MapVerdict::Hold);
        test_set.schedule_state(1100, 12, 200).expect_verdict(1100, MapVerdict::Overtaken);
        test_set.index(12, &[30, 21]).expect_verdict(1200, MapVerdict::Current).holds(
            "schedule state 12",
            &["grid 30", "grid 21"],
            None,
        );
    }

    #[test]
    fn a_schedule_state_that_is_sent_again_is_not_newer() {
        let mut test_set = complete();
        test_set.schedule_state(500, 10, 100).expect_verdict(2000, MapVerdict::Current).holds(
            "schedule state 10",
            &["grid 20", "grid 21"],
            Some("mission plan 10"),
        );
        test_set.index(10, &[20, 21]).grid(0, 20).expect_verdict(2000, MapVerdict::Current);
    }

    #[test]
    fn another_site_is_another_set() {
        let mut test_set = TestSet::new();
        test_set.schedule_state(0, 10, 100).grid(0, 20);
        let head = GridsHead { site_hash: 2, schedule_state_hash: 10, plan_time_s: 0, robot: RobotProfile::DEFAULT };
        test_set.set.insert_index(110, &head, &[], "other site".to_owned());
        test_set.expect_verdict(1, MapVerdict::NoMap(NoMapReason::Incomplete));
    }

    #[test]
    fn a_building_with_fewer_storeys_leaves_no_old_grid_behind() {
        let mut test_set = complete();
        test_set.schedule_state(10, 11, 200).index(11, &[20]).expect_verdict(20, MapVerdict::Current).holds(
            "schedule state 11",
            &["grid 20"],
            None,
        );
    }

    #[test]
    fn a_schedule_state_past_its_validity_is_no_map() {
        let mut test_set = TestSet::new();
        test_set.schedule_state(0, 10, 49).index(10, &[]).expect_verdict(1, MapVerdict::NoMap(NoMapReason::Expired));
        test_set.schedule_state(2, 11, 50).index(11, &[]).expect_verdict(3, MapVerdict::Current);
        test_set
            .schedule_state(4, 12, ScheduleStateHead::NO_TIME)
            .index(12, &[])
            .expect_verdict(5, MapVerdict::Current);
        test_set.schedule_state(6, 13, 49);
        assert_eq!(test_set.set.verdict(at(7), None), MapVerdict::Overtaken, "a clock that stands passes nothing");
    }

    #[test]
    fn three_missed_heartbeats_are_no_map() {
        let mut test_set = complete();
        test_set
            .expect_verdict(2999, MapVerdict::Current)
            .expect_verdict(3000, MapVerdict::NoMap(NoMapReason::Silent { daemon: Daemon::ScheduleEval }));
        test_set.heartbeat(2900).expect_verdict(3000, MapVerdict::Current).expect_verdict(5899, MapVerdict::Current);
        test_set.set.insert_heartbeat(at(5000), Daemon::ScheduleEval);
        test_set.expect_verdict(5900, MapVerdict::NoMap(NoMapReason::Silent { daemon: Daemon::Rasterize }));
        assert_eq!(test_set.set.next_change(at(5000)), at(5900));
        test_set.heartbeat(6000).expect_verdict(6000, MapVerdict::Current);
    }
}
