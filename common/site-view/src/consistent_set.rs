//! The newest site, schedule state, grids and mission plan that belong together, held with the verdict whether a robot may use
//! them. Samples of topics arrive in any order; no bus and no clock inside: times are arguments.

use crate::map_rule::MapRule;
use crate::map_verdict::MapVerdict;
use crate::plan_clock::{ClockTime, NextState};
use bus::{Daemon, GridSlot, RawSample, Stamp, TopicName};
use messages::{
    ArchiveError, ContentHash, GridSlotRecord, Grids, GridsHead, MissionPlan, MissionPlanHead, ScheduleState,
    ScheduleStateHead,
};

/// Key of a schedule state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ScheduleStateKey {
    hash: ContentHash,
    site: ContentHash,
}

/// Key of an index.
#[derive(Debug)]
struct IndexKey {
    hash: ContentHash,
    grids: Vec<ContentHash>,
}

/// Key of a mission plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct MissionPlanKey {
    grids: ContentHash,
    schedule_state: ContentHash,
    site: ContentHash,
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
    grids: [TopicSamples<ContentHash, T>; GridSlot::COUNT],
    mission_plan: TopicSamples<MissionPlanKey, T>,
    rule: MapRule,
}

impl<T> ConsistentSet<T> {
    /// Nothing seen; heartbeats count from `now`.
    pub fn new(now: Stamp) -> Self {
        let mut rule = MapRule::default();
        rule.joined(now);
        Self {
            schedule_state: TopicSamples::EMPTY,
            index: TopicSamples::EMPTY,
            grids: [const { TopicSamples::EMPTY }; GridSlot::COUNT],
            mission_plan: TopicSamples::EMPTY,
            rule,
        }
    }

    /// A schedule state has come; `hash` is its content hash. One that says the same as the last one is not new.
    pub fn insert_schedule_state(&mut self, now: Stamp, hash: ContentHash, head: &ScheduleStateHead, sample: T) {
        // A restarted producer repeats itself; a set in use stays what it is.
        if self.schedule_state.newest().is_none_or(|s| s.key.hash != hash) {
            self.schedule_state.insert(ScheduleStateKey { hash, site: head.site_hash }, sample);
        }
        self.rule.insert_schedule_state(now, hash, head);
        self.advance();
    }

    /// An index of grids has come; `hash` is its content hash. Its n-th record speaks of slot n; there are never more
    /// than [`GridSlot::COUNT`].
    pub fn insert_index(
        &mut self,
        now: Stamp,
        hash: ContentHash,
        head: &GridsHead,
        slots: &[GridSlotRecord],
        sample: T,
    ) {
        let grids = slots.iter().map(|s| s.content_hash).collect();
        self.index.insert(IndexKey { hash, grids }, sample);
        self.rule.insert_index(now, head, self.has_grids());
        self.advance();
    }

    /// A grid has come; `hash` is its content hash.
    pub fn insert_grid(&mut self, now: Stamp, slot: GridSlot, hash: ContentHash, sample: T) {
        self.grids[slot.index()].insert(hash, sample);
        self.rule.set_grids(now, self.has_grids());
        self.advance();
    }

    /// A mission plan has come; `grids_hash` is the content hash of the index that it was made from, as in its sample's
    /// header.
    pub fn insert_mission_plan(&mut self, grids_hash: ContentHash, head: &MissionPlanHead, sample: T) {
        self.mission_plan.insert(
            MissionPlanKey { grids: grids_hash, schedule_state: head.schedule_state_hash, site: head.site_hash },
            sample,
        );
        self.advance();
    }

    /// A heartbeat has come.
    pub fn insert_heartbeat(&mut self, now: Stamp, daemon: Daemon) {
        self.rule.insert_heartbeat(now, daemon);
    }

    /// When the next schedule state is due, as its producer says.
    pub fn set_next_state(&mut self, next: NextState) {
        self.rule.set_next_state(next);
    }

    /// What the consumer may do, see [`MapRule::verdict`]. Without a map the last set stays; it is not to be used.
    pub fn verdict(&self, now: Stamp, clock: ClockTime) -> MapVerdict {
        self.rule.verdict(now, clock)
    }

    /// When to ask for the verdict again if nothing comes before, see [`MapRule::next_change`].
    pub fn next_change(&self, now: Stamp) -> Stamp {
        self.rule.next_change(now)
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
        if self.rule.is_matched() {
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

    /// True if the grids that the newest index names are there, in the set or newer.
    fn has_grids(&self) -> bool {
        let Some(index) = self.index.newest() else { return false };
        let grids = &index.key.grids;
        grids.len() <= GridSlot::COUNT && self.grids.iter().zip(grids).all(|(held, hash)| held.has(|h| h == hash))
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
                self.insert_index(now, header.content_hash, &head, &slots, sample);
            }
            TopicName::Grid(slot) => self.insert_grid(now, slot, header.content_hash, sample),
            TopicName::MissionPlan => {
                let head = *MissionPlan::open(sample.bytes())?.head;
                self.insert_mission_plan(header.inputs.grids, &head, sample);
            }
            TopicName::Site
            | TopicName::Candidate
            | TopicName::Tasks
            | TopicName::SlamMap
            | TopicName::Alignment
            | TopicName::Deviations => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map_verdict::NoMapReason;
    use bytemuck::Zeroable;
    use messages::{RobotProfile, ScheduleStateBuilder};
    use std::time::Duration;

    const SITE: ContentHash = ContentHash::from_bits(1);

    fn slot(index: usize) -> GridSlot {
        GridSlot::new(index).unwrap()
    }

    fn at(milliseconds: u64) -> Stamp {
        Stamp(1_000_000_000_000) + Duration::from_millis(milliseconds)
    }

    /// A set, and the time that it was last told or asked at.
    struct TestSet {
        set: ConsistentSet<String>,
        now: Stamp,
    }

    impl TestSet {
        fn new() -> Self {
            Self { set: ConsistentSet::new(at(0)), now: at(0) }
        }

        fn schedule_state(&mut self, ms: u64, hash: u64, valid_until_s: i64) -> &mut Self {
            let everything = ScheduleStateBuilder::everything_built(SITE, 0, 0).head;
            let head = ScheduleStateHead { valid_until_s, ..everything };
            self.now = at(ms);
            self.set.insert_schedule_state(
                self.now,
                ContentHash::from_bits(hash),
                &head,
                format!("schedule state {hash}"),
            );
            self
        }

        fn grid(&mut self, index: usize, hash: u64) -> &mut Self {
            self.set.insert_grid(self.now, slot(index), ContentHash::from_bits(hash), format!("grid {hash}"));
            self
        }

        fn index(&mut self, schedule_state: u64, hashes: &[u64]) -> &mut Self {
            let head = GridsHead {
                site_hash: SITE,
                schedule_state_hash: ContentHash::from_bits(schedule_state),
                plan_time_s: 0,
                robot: RobotProfile::DEFAULT,
            };
            let record =
                |&hash| GridSlotRecord { map_storey: 0, cell_tenths: 500, content_hash: ContentHash::from_bits(hash) };
            let slots: Vec<_> = hashes.iter().map(record).collect();
            self.set.insert_index(
                self.now,
                ContentHash::from_bits(schedule_state + 100),
                &head,
                &slots,
                format!("index {schedule_state}"),
            );
            self
        }

        fn mission_plan(&mut self, schedule_state: u64) -> &mut Self {
            let schedule_state_hash = ContentHash::from_bits(schedule_state);
            let head = MissionPlanHead { site_hash: SITE, schedule_state_hash, ..Zeroable::zeroed() };
            self.set.insert_mission_plan(
                ContentHash::from_bits(schedule_state + 100),
                &head,
                format!("mission plan {schedule_state}"),
            );
            self
        }

        fn heartbeat(&mut self, ms: u64) -> &mut Self {
            // What follows a server is never on the bus of a site that is drawn.
            for daemon in Daemon::ALL.into_iter().filter(|daemon| *daemon != Daemon::SiteFollow) {
                self.set.insert_heartbeat(at(ms), daemon);
            }
            self
        }

        fn expect_verdict(&mut self, ms: u64, verdict: MapVerdict) -> &mut Self {
            self.now = at(ms);
            assert_eq!(self.set.verdict(self.now, ClockTime::Plan(50)), verdict);
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
        let head =
            MissionPlanHead { site_hash: SITE, schedule_state_hash: ContentHash::from_bits(10), ..Zeroable::zeroed() };
        test_set.set.insert_mission_plan(ContentHash::from_bits(999), &head, "other robot".to_owned());
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
    fn states_that_follow_each_other_faster_than_grids_make_the_robot_stand_still() {
        let mut test_set = complete();
        for (ms, state) in (0u64..).map(|n| 100 + 900 * n).zip(11..).take(4) {
            test_set.schedule_state(ms, state, 200).heartbeat(ms).expect_verdict(ms, MapVerdict::Overtaken);
        }
        test_set.expect_verdict(3_099, MapVerdict::Overtaken).expect_verdict(3_100, MapVerdict::Hold);
    }

    #[test]
    fn an_index_whose_grids_do_not_come_makes_the_robot_stand_still() {
        let mut test_set = complete();
        test_set.expect_verdict(100, MapVerdict::Current).index(10, &[30, 21]).heartbeat(3_000);
        test_set.expect_verdict(3_099, MapVerdict::Overtaken).expect_verdict(3_100, MapVerdict::Hold);
        test_set.grid(0, 30).expect_verdict(3_200, MapVerdict::Current);
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
        let head = GridsHead {
            site_hash: ContentHash::from_bits(2),
            schedule_state_hash: ContentHash::from_bits(10),
            plan_time_s: 0,
            robot: RobotProfile::DEFAULT,
        };
        test_set.set.insert_index(at(0), ContentHash::from_bits(110), &head, &[], "other site".to_owned());
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
        let verdict = test_set.set.verdict(at(7), ClockTime::Unknown);
        assert_eq!(verdict, MapVerdict::Overtaken, "a clock that stands passes nothing");
    }

    #[test]
    fn what_follows_a_server_is_heard_for_all_that_draw_and_named_when_it_is_silent() {
        let mut set = ConsistentSet::<()>::new(at(0));
        set.insert_heartbeat(at(2_000), Daemon::SiteFollow);
        let silent = |set: &ConsistentSet<()>, ms| match set.verdict(at(ms), ClockTime::Plan(50)) {
            MapVerdict::NoMap(NoMapReason::Silent { daemon }) => Some(daemon),
            _ => None,
        };
        assert_eq!(silent(&set, 4_999), None);
        assert_eq!(silent(&set, 5_000), Some(Daemon::SiteFollow));
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
