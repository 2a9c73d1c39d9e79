//! Maps of a plan time in words: elements, rooms, free floor, and the difference from the maps before.

use diagnostics::counted;
use messages::ContentHash;
use site_view::SiteViews;

/// Names of rooms that are listed; more are counted.
const MAX_NAMES: usize = 6;

/// What the maps of a plan time show.
pub(super) struct Look {
    storeys: Vec<StoreyLook>,
    /// Whether each element stands or is worked on.
    stands: Vec<bool>,
    /// Number or name of each room, and whether the schedule blocks it.
    rooms: Vec<(String, bool)>,
    /// 0 without a mission plan.
    n_waypoints: usize,
}

/// The map of a storey.
struct StoreyLook {
    name: String,
    size: [u32; 2],
    free_m2: f64,
    content_hash: ContentHash,
}

impl Look {
    /// Of maps that belong together.
    pub(super) fn of(views: &SiteViews<'_>) -> Self {
        let SiteViews { site, state, index, grids, mission_plan } = views;
        let storey = |(slot, grid): (&messages::GridSlotRecord, &messages::Grid<'_>)| {
            let spec = grid.spec();
            let n_free = grid.planning.iter().filter(|cell| **cell == 0).count();
            StoreyLook {
                name: site.text(site.map_storeys[slot.map_storey as usize].name).to_owned(),
                size: [spec.width, spec.height],
                free_m2: n_free as f64 * spec.resolution_m().powi(2),
                content_hash: slot.content_hash,
            }
        };
        let room = |k: usize| (site.text(site.spaces[k].name).to_owned(), state.is_blocked(k));
        Self {
            storeys: index.slots.iter().zip(grids).map(storey).collect(),
            stands: (0..site.elements.len()).map(|k| state.effective(k).is_obstacle()).collect(),
            rooms: (0..site.spaces.len()).map(room).collect(),
            n_waypoints: mission_plan.as_ref().map_or(0, |plan| plan.waypoints.len()),
        }
    }

    /// The storeys with the sizes of their maps.
    pub(super) fn storeys(&self) -> String {
        let storey = |s: &StoreyLook| format!("{} {} x {}", s.name, s.size[0], s.size[1]);
        self.storeys.iter().map(storey).collect::<Vec<_>>().join(", ")
    }

    /// The name of a map storey.
    pub(super) fn storey(&self, index: u32) -> &str {
        self.storeys.get(index as usize).map_or("", |storey| &storey.name)
    }

    /// What stands and is free.
    pub(super) fn text(&self) -> String {
        let (stands, closed) = (count(&self.stands), self.rooms.iter().filter(|(_, is_blocked)| *is_blocked).count());
        let free_m2: f64 = self.storeys.iter().map(|storey| storey.free_m2).sum();
        let (elements, rooms) = (self.stands.len(), self.rooms.len());
        format!(
            "{stands} of {elements} elements stand, the schedule closes {closed} of {rooms} rooms, {free_m2:.0} m2 are free on the maps"
        )
    }

    /// Waypoints of the mission plan.
    pub(super) fn waypoints(&self) -> String {
        counted(self.n_waypoints, "waypoint")
    }

    /// The storeys whose maps are others than before.
    pub(super) fn drawn_since(&self, before: &Self) -> String {
        let is_known = |storey: &&StoreyLook| before.storeys.iter().any(|s| s.content_hash == storey.content_hash);
        let names: Vec<&str> = self.storeys.iter().filter(|s| !is_known(s)).map(|s| s.name.as_str()).collect();
        match names.as_slice() {
            [] => "no map looks different".to_owned(),
            names => format!("drawn anew: {}", names.join(", ")),
        }
    }

    /// Elements that have come or gone, rooms that the schedule closes or no longer closes.
    pub(super) fn differs_from(&self, before: &Self) -> String {
        let only = |a: &[bool], b: &[bool]| a.iter().zip(b).filter(|(a, b)| **a && !**b).count();
        let (come, gone) = (only(&self.stands, &before.stands), only(&before.stands, &self.stands));
        let rooms = |is_blocked: bool| -> Vec<&str> {
            let pairs = self.rooms.iter().zip(&before.rooms);
            let changed = pairs.filter(|((_, now), (_, then))| *now == is_blocked && *then != is_blocked);
            changed.map(|((name, _), _)| name.as_str()).collect()
        };
        let mut text = format!("{} more", counted(come, "element"));
        if gone > 0 {
            text += &format!(", {gone} fewer");
        }
        for (what, names) in [("no longer closed", rooms(false)), ("closed", rooms(true))] {
            if !names.is_empty() {
                text += &format!("; {what}: {}", list(&names));
            }
        }
        text
    }
}

fn count(values: &[bool]) -> usize {
    values.iter().filter(|value| **value).count()
}

fn list(names: &[&str]) -> String {
    let mut text = names[..names.len().min(MAX_NAMES)].join(", ");
    if names.len() > MAX_NAMES {
        text += &format!(" and {} more", names.len() - MAX_NAMES);
    }
    text
}
