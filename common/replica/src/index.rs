//! The index of a site: what there is at one epoch, and which blobs it is made of.

use crate::objects::SiteName;
use messages::{ContentHash, ContentId};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What of a document of a store is read before all else: the version of its form.
#[derive(Debug, Deserialize)]
pub(crate) struct Form {
    pub(crate) format: u32,
}

/// The index of a site at an epoch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SiteIndex {
    /// Version of this form: [`SiteIndex::FORMAT`].
    pub format: u32,
    /// The site.
    pub site: SiteName,
    /// Number of this index; it rises by one.
    pub epoch: u64,
    /// When the server made it by its clock, RFC 3339 in UTC. Robots show it and decide nothing by it.
    pub published: String,
    /// Layout version of the archives.
    pub layout_version: u32,
    /// Counts the changes of the map frame of the site.
    pub frame_epoch: u64,
    /// How the plan time moves.
    pub clock: IndexClock,
    /// The `site` archive.
    pub site_archive: ArchiveEntry,
    /// The `tasks` archive, where the schedule is one of schedule files.
    pub tasks: Option<ArchiveEntry>,
    /// Maps of the present plan time, then of later ones, in their order; at least one.
    pub sets: Vec<PlanSet>,
    /// Why there are none of later plan times, where the plan time moves.
    pub why_no_later: Option<String>,
}

/// How the plan time of a site moves.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum IndexClock {
    /// It stands, or only the server knows how it moves: robots show the first set.
    ByServer,
    /// It is the civil time of a zone: robots go on to later sets by their own clock.
    Wall {
        /// Name of the zone, of the IANA database.
        zone: String,
    },
}

/// What there is of one plan time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanSet {
    /// Civil seconds since 1970; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// The instant after which it is not valid; `None` if it is for good.
    pub valid_until_s: Option<i64>,
    /// The `schedule-state` archive.
    pub schedule_state: ArchiveEntry,
    /// Maps of each robot of the server: `robot` for one without a name.
    pub robots: BTreeMap<String, RobotMaps>,
}

/// The maps of a robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotMaps {
    /// The `grids` archive.
    pub grids: ArchiveEntry,
    /// The `mission-plan` archive; `None` while it is planned.
    pub mission_plan: Option<ArchiveEntry>,
    /// Hash of what the maps depend on of the robot, as in the headers of samples.
    pub robot_hash: ContentHash,
    /// The storeys, in the order of the `grids` archive.
    pub storeys: Vec<StoreyMap>,
    /// Exported files; `None` where none are asked for, and until they are made.
    pub files: Option<RobotFiles>,
}

/// Files that were exported of the maps of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotFiles {
    /// The blob that lists them: [`crate::FileList`].
    pub list: BlobEntry,
    /// Bytes of all of them.
    pub bytes: u64,
    /// Which formats they have, with which options, of which version: other ones are other files.
    pub made_with: ContentId,
    /// The blob that tells how maps and zone sets of VDA 5050 are downloaded from the store, and when they are to be enabled.
    pub vda5050_maps: Option<BlobEntry>,
}

/// The map of a storey.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoreyMap {
    /// Map storey of the site.
    pub map_storey: u32,
    /// Name.
    pub name: String,
    /// GlobalId of the storey; empty where the site has none.
    pub global_id: String,
    /// Hash of what alone can change the grid, as in its header.
    pub input_hash: ContentHash,
    /// The `grid` archive.
    pub grid: ArchiveEntry,
}

/// An archive in a store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArchiveEntry {
    /// sha256 of its bytes.
    pub id: ContentId,
    /// The content hash that it has in itself: by it the server finds an archive again without its bytes.
    pub content_hash: ContentHash,
    /// Its length.
    pub bytes: u64,
    /// The blob that tells its blocks.
    pub recipe: BlobEntry,
}

/// A blob in a store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlobEntry {
    /// sha256 of its bytes.
    pub id: ContentId,
    /// Its length.
    pub bytes: u64,
}

/// Which set of an index is to be shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SetChoice {
    /// Its place in [`SiteIndex::sets`].
    pub place: usize,
    /// When the next one is due, civil seconds since 1970; `None` if there is none, or the plan time does not move by itself.
    pub next_s: Option<i64>,
}

impl SiteIndex {
    /// The form that this version reads and writes.
    pub const FORMAT: u32 = 1;

    /// The set to be shown at a plan time of the robot's clock, where it has one: the last one that has begun, and never one before the
    /// first, which is the server's word for the present.
    pub fn choose(&self, plan_time_s: Option<i64>) -> SetChoice {
        let IndexClock::Wall { .. } = self.clock else { return SetChoice { place: 0, next_s: None } };
        let has_begun = |set: &PlanSet| set.plan_time_s.zip(plan_time_s).is_some_and(|(from_s, now_s)| from_s <= now_s);
        let place = self.sets.iter().rposition(has_begun).unwrap_or(0);
        SetChoice { place, next_s: self.sets.get(place + 1).and_then(|set| set.plan_time_s) }
    }

    /// All archives, each as often as it is named.
    pub fn archives(&self) -> impl Iterator<Item = &ArchiveEntry> {
        let of_sets = self.sets.iter().flat_map(|set| {
            std::iter::once(&set.schedule_state).chain(set.robots.values().flat_map(RobotMaps::archives))
        });
        std::iter::once(&self.site_archive).chain(&self.tasks).chain(of_sets)
    }
}

impl PlanSet {
    /// Exported files of the maps of a robot, where there are any.
    pub fn files_of(&self, robot: &str) -> Option<&RobotFiles> {
        self.robots.get(robot)?.files.as_ref()
    }
}

impl RobotMaps {
    fn archives(&self) -> impl Iterator<Item = &ArchiveEntry> {
        let grids = self.storeys.iter().map(|storey| &storey.grid);
        std::iter::once(&self.grids).chain(&self.mission_plan).chain(grids)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// An archive of a store, of which only the identity matters.
    pub(crate) fn entry(seed: &str) -> ArchiveEntry {
        let id = ContentId::of(seed.as_bytes());
        ArchiveEntry { id, content_hash: ContentHash::NONE, bytes: 1, recipe: BlobEntry { id, bytes: 2 } }
    }

    /// An index with sets of these plan times.
    pub(crate) fn index(epoch: u64, clock: IndexClock, plan_times_s: &[i64]) -> SiteIndex {
        let set = |at_s: &i64| PlanSet {
            plan_time_s: Some(*at_s),
            valid_until_s: None,
            schedule_state: entry(&at_s.to_string()),
            robots: BTreeMap::new(),
        };
        SiteIndex {
            format: SiteIndex::FORMAT,
            site: "tower".parse().unwrap(),
            epoch,
            published: "2026-11-28T12:00:00Z".to_owned(),
            layout_version: messages::LAYOUT_VERSION,
            frame_epoch: 1,
            clock,
            site_archive: entry("site"),
            tasks: None,
            sets: plan_times_s.iter().map(set).collect(),
            why_no_later: None,
        }
    }

    #[test]
    fn a_robot_goes_on_by_its_own_clock_and_never_before_the_servers_word() {
        let index = index(1, IndexClock::Wall { zone: "UTC".to_owned() }, &[100, 200, 300]);
        let choice = |now_s| {
            let SetChoice { place, next_s } = index.choose(now_s);
            (place, next_s)
        };
        assert_eq!(choice(Some(50)), (0, Some(200)), "the robot's clock is behind");
        assert_eq!(choice(Some(199)), (0, Some(200)));
        assert_eq!(choice(Some(200)), (1, Some(300)));
        assert_eq!(choice(Some(1_000)), (2, None));
        assert_eq!(choice(None), (0, Some(200)), "a clock that is not trusted moves nothing");
    }

    #[test]
    fn a_plan_time_that_only_the_server_moves_is_its_first_set() {
        let index = index(1, IndexClock::ByServer, &[100, 200]);
        assert_eq!(index.choose(Some(1_000)), SetChoice { place: 0, next_s: None });
    }

    #[test]
    fn an_index_survives_its_text_and_unknown_words_are_refused() {
        let index = index(3, IndexClock::Wall { zone: "Europe/Oslo".to_owned() }, &[1]);
        let text = serde_json::to_string(&index).unwrap();
        assert_eq!(serde_json::from_str::<SiteIndex>(&text).unwrap(), index);
        let other = text.replacen("\"epoch\"", "\"epoch_\"", 1);
        assert!(serde_json::from_str::<SiteIndex>(&other).is_err());
    }
}
