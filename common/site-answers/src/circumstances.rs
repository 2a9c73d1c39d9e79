//! Circumstances of the maps that a running site publishes, and what else is read off them.

use answers::{Circumstances, Epochs, MapUse};
use bus::{CheckedSample, DomainError, Stamp};
use daemon::{SiteConfig, StatusBoard};
use jiff::Timestamp;
use messages::{EdgeKind, MissionPlan, Site, StoreyEntry};
use site_view::{Freshness, MapsInUse, SiteSet, SiteViews};
use waypoints::MissionPlanOptions;

/// Epochs of the samples of a set.
pub fn epochs_of(set: &SiteSet<'_>) -> Epochs {
    Epochs {
        site: set.site.bytes().header().epoch,
        schedule_state: set.state.bytes().header().epoch,
        grids: set.index.bytes().header().epoch,
        mission_plan: set.mission_plan.map(CheckedSample::bytes).map_or(0, |sample| sample.header().epoch),
    }
}

/// The circumstances of answers about a set, whose maps may be used or not.
pub fn circumstances_of(set: &SiteSet<'_>, views: &SiteViews<'_>, maps: MapUse) -> Circumstances {
    let SiteViews { site, state, index, grids, .. } = views;
    let resolution_m = grids.first().map(|grid| grid.spec().resolution_m());
    Circumstances::of_running(site, state, index, resolution_m, (epochs_of(set), maps))
}

/// Whether the maps of a set may be used now: the rule of all readers of maps, with what the daemons last said of themselves.
///
/// # Errors
/// The status board of the site cannot be reached.
pub fn map_use(set: &SiteSet<'_>, config: &SiteConfig) -> Result<MapUse, DomainError> {
    let board = StatusBoard::of_site(config)?;
    let now = Stamp::now();
    let index = set.index.view();
    let mut freshness = Freshness::default();
    freshness.joined(Stamp(0));
    daemon::hear_daemons(&board, &mut freshness);
    freshness.on_schedule_state(now, set.state.content_hash(), set.state.view().head);
    freshness.on_index(now, index.head, index.slots.to_vec());
    freshness.on_maps(MapsInUse {
        epoch: set.index.bytes().header().epoch,
        site_hash: set.site.content_hash(),
        grids: index.slots.to_vec(),
    });
    Ok(MapUse::of(freshness.state(now, Timestamp::now().as_millisecond()).why_not()))
}

/// The options of a mission plan that say what it says: the lifts that the robot takes, and how it drives.
pub fn options_of(site: &Site<'_>, mission_plan: &MissionPlan<'_>) -> MissionPlanOptions {
    let lifts = mission_plan.edges.iter().filter(|edge| edge.kind == EdgeKind::Lift && edge.usable == 1);
    let lifts = lifts.map(|edge| site.text(site.elements[edge.of as usize].global_id).to_owned()).collect();
    MissionPlanOptions { lifts, drive: mission_plan.head.drive, ..MissionPlanOptions::default() }
}

/// True if it is known where the robot starts on maps of other dates, by the mission plan of those that are published: it has no
/// start.
pub fn start_is_known(mission_plan: &MissionPlan<'_>) -> bool {
    mission_plan.storeys.iter().all(|storey| storey.entry != StoreyEntry::Start)
}
