//! A judge of maps that were passed on, into a folder, to a page or to ROS 2: it compares them with those that the daemons hold. No
//! bus and no files inside, times are arguments.

use crate::limits::FRESH_TOLERANCE;
use crate::map_rule::MapRule;
use crate::map_verdict::{MapVerdict, NoMapReason};
use crate::plan_clock::{ClockTime, NextState};
use bus::{Daemon, Stamp};
use messages::{ContentHash, GridSlotRecord, GridsHead, ScheduleStateHead};
use std::collections::{BTreeMap, BTreeSet};

/// The maps that were passed on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapsInUse {
    /// Epoch of their index.
    pub epoch: u64,
    /// Content hash of their site.
    pub site_hash: ContentHash,
    /// Their grids.
    pub grids: Vec<GridSlotRecord>,
}

/// Indices of map storeys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Storeys {
    /// All there are.
    All,
    /// These.
    Only(BTreeSet<u32>),
}

impl Storeys {
    /// True if all of the others are among them.
    pub fn contains(&self, others: &Self) -> bool {
        match (self, others) {
            (Self::All, _) => true,
            (Self::Only(_), Self::All) => false,
            (Self::Only(these), Self::Only(others)) => others.is_subset(these),
        }
    }
}

/// Maps that must not be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Staleness {
    /// Why.
    pub reason: String,
    /// On which storeys.
    pub storeys: Storeys,
}

/// What is known of the maps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MapState {
    /// They are those that the daemons hold, but for these storeys, whose new maps were not passed on yet.
    Fresh {
        /// Indices of map storeys.
        outdated_storeys: BTreeSet<u32>,
    },
    /// It is unknown, and not for too long yet ([`crate::GRIDS_LATE`], [`FRESH_TOLERANCE`]): what was last known counts.
    Unknown,
    /// None of them may be used.
    Stale {
        /// Why.
        reason: String,
    },
}

impl MapState {
    /// Why the maps may not be used; `None` if they may, but for outdated storeys.
    pub fn why_not(self) -> Option<String> {
        match self {
            Self::Fresh { .. } => None,
            Self::Unknown => Some("it is not known whether they are those of the daemons".to_owned()),
            Self::Stale { reason } => Some(reason),
        }
    }
}

/// What the daemons hold, and what was passed on; nothing is known by default.
#[derive(Debug, Default)]
pub struct Freshness {
    rule: MapRule,
    maps: Option<MapsInUse>,
    schedule_state: Option<ScheduleStateHead>,
    /// Site and grids of the newest index.
    index: Option<(ContentHash, Vec<GridSlotRecord>)>,
    no_bus: Option<String>,
    /// Why there are no new maps, if it is known.
    obstacle: Option<String>,
    /// Since when it is unknown whether the maps are those of the daemons, without a break.
    unknown_since: Option<Stamp>,
    /// Since when maps of storeys are outdated, by storey.
    outdated_since: BTreeMap<u32, Stamp>,
}

/// Why maps of which the rule says that they are overtaken, or that they are to be held, are not those of the daemons.
const LATE_GRIDS: &str = "the grids of the newest schedule state have not come";

/// Why it is unknown whether maps are those of the daemons.
struct Doubt {
    reason: String,
    /// True if that makes them stale without delay.
    is_certain: bool,
}

impl Freshness {
    /// A generation of the bus was joined: samples come again, heartbeats count from now.
    pub fn joined(&mut self, now: Stamp) {
        (self.schedule_state, self.index, self.no_bus) = (None, None, None);
        self.rule.joined(now);
    }

    /// There is no bus.
    pub fn left(&mut self, why: String) {
        self.no_bus = Some(why);
    }

    /// A daemon was heard at this time.
    pub fn on_heartbeat(&mut self, at: Stamp, daemon: Daemon) {
        self.rule.insert_heartbeat(at, daemon);
    }

    /// A schedule state has come; `hash` is that of its content. One that says the same as the last one is not new.
    pub fn on_schedule_state(&mut self, now: Stamp, hash: ContentHash, head: &ScheduleStateHead) {
        self.rule.insert_schedule_state(now, hash, head);
        self.schedule_state = Some(*head);
    }

    /// An index of grids has come.
    pub fn on_index(&mut self, now: Stamp, head: &GridsHead, grids: Vec<GridSlotRecord>) {
        self.rule.insert_index(now, head, true);
        self.index = Some((head.site_hash, grids));
    }

    /// These maps were passed on.
    pub fn on_maps(&mut self, maps: MapsInUse) {
        self.maps = Some(maps);
    }

    /// Why no new maps are passed on, if it is known: part of the reason where they are missed.
    pub fn set_obstacle(&mut self, why: Option<String>) {
        self.obstacle = why;
    }

    /// When the next schedule state is due, as its producer says.
    pub fn set_next_state(&mut self, next: NextState) {
        self.rule.set_next_state(next);
    }

    /// The maps that were passed on.
    pub fn maps(&self) -> Option<&MapsInUse> {
        self.maps.as_ref()
    }

    /// The newest schedule state.
    pub fn schedule_state(&self) -> Option<&ScheduleStateHead> {
        self.schedule_state.as_ref()
    }

    /// What is known of the maps now; `utc_ms` is the machine's clock, milliseconds since 1970.
    pub fn state(&mut self, now: Stamp, utc_ms: i64) -> MapState {
        match self.outdated_storeys(now, utc_ms) {
            Ok(outdated_storeys) => {
                self.unknown_since = None;
                self.outdated_since.retain(|storey, _| outdated_storeys.contains(storey));
                outdated_storeys.iter().for_each(|storey| {
                    self.outdated_since.entry(*storey).or_insert(now);
                });
                MapState::Fresh { outdated_storeys }
            }
            Err(Doubt { reason, is_certain }) => {
                let since = *self.unknown_since.get_or_insert(now);
                if is_certain || now.since(since) >= FRESH_TOLERANCE {
                    MapState::Stale { reason }
                } else {
                    MapState::Unknown
                }
            }
        }
    }

    /// Storeys whose maps were outdated for [`FRESH_TOLERANCE`].
    pub fn late_storeys(&self, now: Stamp) -> Option<Staleness> {
        let late = self.outdated_since.iter().filter(|(_, since)| now.since(**since) >= FRESH_TOLERANCE);
        let storeys: BTreeSet<u32> = late.map(|(storey, _)| *storey).collect();
        let why = self.obstacle.as_deref().unwrap_or("new maps of some storeys were not passed on yet");
        (!storeys.is_empty()).then(|| Staleness { reason: why.to_owned(), storeys: Storeys::Only(storeys) })
    }

    /// The storeys whose maps are not those of the daemons, if the daemons hold maps of this site.
    fn outdated_storeys(&self, now: Stamp, utc_ms: i64) -> Result<BTreeSet<u32>, Doubt> {
        if let Some(why) = &self.no_bus {
            return Err(Doubt { reason: why.clone(), is_certain: false });
        }
        let (site_hash, grids) = match (self.rule.verdict(now, ClockTime::Machine(utc_ms)), &self.index) {
            (MapVerdict::Current, Some(index)) => index,
            (MapVerdict::Current, None) | (MapVerdict::Overtaken, _) => return Err(self.missing(LATE_GRIDS)),
            (MapVerdict::Hold, _) => return Err(Doubt { is_certain: true, ..self.missing(LATE_GRIDS) }),
            (MapVerdict::NoMap(reason @ NoMapReason::Incomplete), _) => return Err(self.missing(&reason.to_string())),
            (MapVerdict::NoMap(reason), _) => {
                return Err(Doubt { reason: reason.to_string(), is_certain: true });
            }
        };
        let Some(maps) = self.maps.as_ref().filter(|maps| maps.site_hash == *site_hash) else {
            return Err(self.missing("the maps of the newest site were not passed on yet"));
        };
        let held: BTreeSet<_> = grids.iter().map(key).collect();
        let passed_on: BTreeSet<_> = maps.grids.iter().map(key).collect();
        Ok(held.symmetric_difference(&passed_on).map(|(storey, _)| *storey).collect())
    }

    /// Something has not come, and why if that is known.
    fn missing(&self, what: &str) -> Doubt {
        let why = self.obstacle.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
        Doubt { reason: format!("{what}{why}"), is_certain: false }
    }
}

fn key(grid: &GridSlotRecord) -> (u32, ContentHash) {
    (grid.map_storey, grid.content_hash)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::WATCHED;
    use messages::{RobotProfile, ScheduleStateBuilder};
    use std::time::Duration;

    const SITE: ContentHash = ContentHash::from_bits(1);

    fn at(ms: u64) -> Stamp {
        Stamp(1_000_000_000_000) + Duration::from_millis(ms)
    }

    fn grids(hashes: &[u64]) -> Vec<GridSlotRecord> {
        let record = |(storey, hash): (usize, &u64)| GridSlotRecord {
            map_storey: storey as u32,
            cell_tenths: 500,
            content_hash: ContentHash::from_bits(*hash),
        };
        hashes.iter().enumerate().map(record).collect()
    }

    /// The daemons hold these grids at a schedule state.
    fn publish(freshness: &mut Freshness, state_hash: u64, hashes: &[u64]) {
        let state_hash = ContentHash::from_bits(state_hash);
        freshness.on_schedule_state(at(0), state_hash, &ScheduleStateBuilder::everything_built(SITE, 0, 0).head);
        let robot = RobotProfile::DEFAULT;
        let head = GridsHead { site_hash: SITE, schedule_state_hash: state_hash, plan_time_s: 0, robot };
        freshness.on_index(at(0), &head, grids(hashes));
    }

    fn write(freshness: &mut Freshness, hashes: &[u64]) {
        freshness.on_maps(MapsInUse { epoch: 1, site_hash: SITE, grids: grids(hashes) });
    }

    fn heartbeats(freshness: &mut Freshness, ms: u64) {
        WATCHED.into_iter().for_each(|daemon| freshness.on_heartbeat(at(ms), daemon));
    }

    /// Grids 1 and 2, in a folder and with the daemons, at 0.
    fn fresh() -> Freshness {
        let mut freshness = Freshness::default();
        freshness.joined(at(0));
        publish(&mut freshness, 7, &[1, 2]);
        write(&mut freshness, &[1, 2]);
        assert_eq!(freshness.state(at(0), 0), MapState::Fresh { outdated_storeys: BTreeSet::new() });
        freshness
    }

    fn is_stale(freshness: &mut Freshness, ms: u64) -> Option<String> {
        match freshness.state(at(ms), 0) {
            MapState::Stale { reason } => Some(reason),
            MapState::Fresh { .. } | MapState::Unknown => None,
        }
    }

    #[test]
    fn a_daemon_that_misses_its_heartbeats_makes_maps_stale_until_it_is_heard() {
        let mut freshness = fresh();
        freshness.on_heartbeat(at(2_000), Daemon::ScheduleEval);
        assert_eq!(is_stale(&mut freshness, 2_999), None);
        assert_eq!(is_stale(&mut freshness, 3_000).as_deref(), Some("rasterize has missed 3 heartbeats"));
        freshness.on_heartbeat(at(3_100), Daemon::WaypointGen);
        assert!(is_stale(&mut freshness, 3_100).is_some(), "others keep no map up to date");
        freshness.on_heartbeat(at(3_200), Daemon::Rasterize);
        assert_eq!(is_stale(&mut freshness, 3_200), None);
    }

    #[test]
    fn a_schedule_state_that_was_due_and_did_not_come_makes_maps_stale() {
        let mut freshness = fresh();
        freshness.set_next_state(NextState::Due { utc_ms: 10_000 });
        let mut is_stale = |utc_ms: i64| matches!(freshness.state(at(100), utc_ms), MapState::Stale { .. });
        assert!(!is_stale(9_000) && !is_stale(12_999), "it may take as long as a check is good");
        assert!(is_stale(13_000));
        let MapState::Stale { reason } = freshness.state(at(100), 13_000) else { panic!("they are stale") };
        assert!(reason.ends_with("the next one was due at 1970-01-01T00:00:10Z"), "{reason}");
        freshness.set_next_state(NextState::None);
        assert!(matches!(freshness.state(at(100), 13_000), MapState::Fresh { .. }));
    }

    #[test]
    fn a_clock_that_is_not_followed_makes_maps_stale_until_it_is() {
        let mut freshness = fresh();
        freshness.set_next_state(NextState::Unknown { why: "clock_untrusted".to_owned() });
        assert_eq!(is_stale(&mut freshness, 100).as_deref(), Some("clock_untrusted"));
        freshness.set_next_state(NextState::None);
        assert_eq!(is_stale(&mut freshness, 100), None);
    }

    #[test]
    fn a_bus_that_comes_back_within_the_tolerance_is_not_noticed() {
        let mut freshness = fresh();
        freshness.left("there is no bus".to_owned());
        assert_eq!(freshness.state(at(1_000), 0), MapState::Unknown);
        freshness.joined(at(2_000));
        assert_eq!(freshness.state(at(3_900), 0), MapState::Unknown, "no sample has come again");
        publish(&mut freshness, 7, &[1, 2]);
        assert_eq!(freshness.state(at(3_950), 0), MapState::Fresh { outdated_storeys: BTreeSet::new() });
        freshness.left("there is no bus".to_owned());
        assert_eq!(is_stale(&mut freshness, 5_000), None, "it counts from the last time that was well");
        assert_eq!(is_stale(&mut freshness, 8_000).as_deref(), Some("there is no bus"));
    }

    #[test]
    fn a_schedule_state_without_grids_makes_all_maps_stale() {
        let mut freshness = fresh();
        freshness.on_schedule_state(
            at(50),
            ContentHash::from_bits(8),
            &ScheduleStateBuilder::everything_built(SITE, 0, 0).head,
        );
        assert_eq!(freshness.state(at(1_049), 0), MapState::Unknown);
        assert!(is_stale(&mut freshness, 1_050).unwrap().contains("have not come"));
        heartbeats(&mut freshness, 3_000);
        publish(&mut freshness, 8, &[1, 2]);
        let same = MapState::Fresh { outdated_storeys: BTreeSet::new() };
        assert_eq!(freshness.state(at(3_200), 0), same, "a date at which no map changes needs no new files");
    }

    #[test]
    fn a_schedule_state_whose_grids_were_there_is_no_newer_one_when_its_producer_repeats_it() {
        let mut freshness = fresh();
        freshness.joined(at(2_000));
        freshness.on_schedule_state(
            at(2_000),
            ContentHash::from_bits(7),
            &ScheduleStateBuilder::everything_built(SITE, 0, 0).head,
        );
        let robot = RobotProfile::DEFAULT;
        let head = GridsHead { site_hash: SITE, schedule_state_hash: ContentHash::from_bits(6), plan_time_s: 0, robot };
        freshness.on_index(at(2_000), &head, grids(&[1, 2]));
        assert_eq!(freshness.state(at(2_100), 0), MapState::Unknown);
        heartbeats(&mut freshness, 4_000);
        assert_eq!(freshness.state(at(4_900), 0), MapState::Unknown);
        assert!(is_stale(&mut freshness, 5_100).unwrap().contains("have not come"));
    }

    #[test]
    fn only_storeys_whose_grids_changed_are_outdated_and_late_after_the_tolerance() {
        let mut freshness = fresh();
        publish(&mut freshness, 8, &[1, 9]);
        assert_eq!(freshness.state(at(100), 0), MapState::Fresh { outdated_storeys: [1].into() });
        assert_eq!(freshness.late_storeys(at(3_000)), None);
        heartbeats(&mut freshness, 3_000);
        freshness.set_obstacle(Some("the disk is full".to_owned()));
        freshness.state(at(3_100), 0);
        let late = Staleness { reason: "the disk is full".to_owned(), storeys: Storeys::Only([1].into()) };
        assert_eq!(freshness.late_storeys(at(3_100)), Some(late));
        write(&mut freshness, &[1, 9]);
        assert_eq!(freshness.state(at(3_200), 0), MapState::Fresh { outdated_storeys: BTreeSet::new() });
        assert_eq!(freshness.late_storeys(at(9_000)), None);
    }

    #[test]
    fn maps_of_another_site_are_stale_as_a_whole() {
        let mut freshness = fresh();
        let robot = RobotProfile::DEFAULT;
        freshness.on_schedule_state(
            at(0),
            ContentHash::from_bits(8),
            &ScheduleStateBuilder::everything_built(ContentHash::from_bits(2), 0, 0).head,
        );
        let head = GridsHead {
            site_hash: ContentHash::from_bits(2),
            schedule_state_hash: ContentHash::from_bits(8),
            plan_time_s: 0,
            robot,
        };
        freshness.on_index(at(0), &head, grids(&[1, 2]));
        freshness.state(at(0), 0);
        heartbeats(&mut freshness, 3_000);
        freshness.set_obstacle(Some("the disk is full".to_owned()));
        let reason = is_stale(&mut freshness, 3_000).unwrap();
        assert_eq!(reason, "the maps of the newest site were not passed on yet: the disk is full");
    }

    #[test]
    fn storeys_contain_their_subsets() {
        let only = |storeys: &[u32]| Storeys::Only(storeys.iter().copied().collect());
        assert!(Storeys::All.contains(&only(&[1])) && only(&[1, 2]).contains(&only(&[2])));
        assert!(!only(&[1]).contains(&Storeys::All) && !only(&[1]).contains(&only(&[1, 2])));
    }
}
