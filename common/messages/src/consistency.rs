//! Checks that archives belong to the same site.

use crate::{
    Deviations, EdgeKind, Grid, Grids, Ground, GroundBodyRecord, MissionPlan, NONE, NodeKind, RouteEdgeRecord,
    RouteNodeRecord, ScheduleState, Site, Tasks,
};

/// Archives that speak of different sites.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the {what} is of another site")]
pub struct OtherSite {
    what: &'static str,
}

fn check(belongs: bool, what: &'static str) -> Result<(), OtherSite> {
    if belongs { Ok(()) } else { Err(OtherSite { what }) }
}

impl ScheduleState<'_> {
    /// Checks that the schedule state speaks of this site: after that every element and space of the site has a state.
    ///
    /// # Errors
    /// Another site's hash, or other numbers of elements or spaces.
    pub fn check_site(&self, site: &Site<'_>) -> Result<(), OtherSite> {
        let belongs = self.head.site_hash == site.content_hash()
            && self.n_elements() == site.elements.len()
            && self.spaces.len() == site.spaces.len();
        check(belongs, "schedule state")
    }
}

impl Ground<'_> {
    /// Checks that the ground is that of this site: after that every body of it has its element or terrain.
    ///
    /// # Errors
    /// Another site's hash, or records that the site does not have.
    pub fn check_site(&self, site: &Site<'_>) -> Result<(), OtherSite> {
        let has = |b: &GroundBodyRecord| match (b.element, b.terrain) {
            (element, NONE) => (element as usize) < site.elements.len(),
            (NONE, terrain) => (terrain as usize) < site.terrains.len(),
            _ => false,
        };
        check(self.head.site_hash == site.content_hash() && self.bodies.iter().all(has), "ground")
    }
}

impl<'a> Site<'a> {
    /// The same site with the tasks of schedule files in the place of those of its models.
    ///
    /// # Errors
    /// Tasks of another site.
    pub fn with_tasks(&self, tasks: &Tasks<'a>) -> Result<Self, OtherSite> {
        tasks.check_site(self)?;
        Ok(self.with_schedule(tasks.schedule()))
    }
}

impl Tasks<'_> {
    /// Checks that the tasks work on this site: after that every link has its target.
    ///
    /// # Errors
    /// Another site's hash, or other numbers of elements, spaces or storeys.
    pub fn check_site(&self, site: &Site<'_>) -> Result<(), OtherSite> {
        let head = self.head;
        let targets = [head.n_elements, head.n_spaces, head.n_storeys].map(|n| n as usize);
        let belongs = head.site_hash == site.content_hash()
            && targets == [site.elements.len(), site.spaces.len(), site.storeys.len()];
        check(belongs, "tasks")
    }
}

impl Grids<'_> {
    /// Checks that the index speaks of this site: after that its storeys, doors and elements are those of the site.
    ///
    /// # Errors
    /// Another site's hash, or records that the site does not have.
    pub fn check_site(&self, site: &Site<'_>) -> Result<(), OtherSite> {
        let n_storeys = site.map_storeys.len();
        let has_storey = |storey: u32| (storey as usize) < n_storeys;
        let belongs = self.head.site_hash == site.content_hash()
            && self.slots.iter().all(|s| has_storey(s.map_storey))
            && self.doors.iter().all(|d| has_storey(d.map_storey) && (d.door as usize) < site.doors.len())
            && self.regions.iter().all(|r| has_storey(r.map_storey) && (r.element as usize) < site.elements.len());
        check(belongs, "index of the grids")
    }
}

impl Grid<'_> {
    /// Checks that the grid speaks of this site: after that its storey and its spaces are those of the site.
    ///
    /// # Errors
    /// Records that the site does not have. Linear in cells.
    pub fn check_site(&self, site: &Site<'_>) -> Result<(), OtherSite> {
        // The greatest of all, which the compiler finds for many cells at once.
        let last_space = self.space.iter().fold(0, |last, &space| last.max(space));
        let belongs =
            (self.head.map_storey as usize) < site.map_storeys.len() && usize::from(last_space) <= site.spaces.len();
        check(belongs, "grid")
    }
}

impl MissionPlan<'_> {
    /// Checks that the mission plan speaks of this site: after that every space of the site has a record.
    ///
    /// # Errors
    /// Another site's hash, or records that the site does not have.
    pub fn check_site(&self, site: &Site<'_>) -> Result<(), OtherSite> {
        let n_storeys = site.map_storeys.len();
        let has_storey = |storey: u32| (storey as usize) < n_storeys;
        let has_space = |space: u32| space == NONE || (space as usize) < site.spaces.len();
        let has_door = |door: u32| door == NONE || (door as usize) < site.doors.len();
        let has_element = |element: u32| (element as usize) < site.elements.len();
        let node_is_of = |n: &RouteNodeRecord| match n.kind.get() {
            NodeKind::Space => (n.of as usize) < site.spaces.len(),
            NodeKind::Door => (n.of as usize) < site.doors.len(),
            NodeKind::Staging => n.of == NONE || has_element(n.of),
            NodeKind::Junction => true,
        };
        let edge_is_of = |e: &RouteEdgeRecord| match e.kind.get() {
            EdgeKind::Floor | EdgeKind::Ground => true,
            EdgeKind::Door => (e.of as usize) < site.doors.len(),
            EdgeKind::Step => e.of == NONE || has_element(e.of),
            EdgeKind::Stair | EdgeKind::Ramp | EdgeKind::Lift | EdgeKind::Escalator => has_element(e.of),
        };
        let belongs = self.head.site_hash == site.content_hash()
            && self.spaces.len() == site.spaces.len()
            && self.spaces.iter().all(|s| has_door(s.door))
            && self.waypoints.iter().all(|w| has_storey(w.map_storey))
            && self.storeys.iter().all(|s| has_storey(s.map_storey))
            && self.floor_parts.iter().all(|p| has_storey(p.map_storey))
            && self.nodes.iter().all(|n| has_storey(n.map_storey) && has_space(n.space) && node_is_of(n))
            && self.edges.iter().all(edge_is_of);
        check(belongs, "mission plan")
    }
}

impl Deviations<'_> {
    /// Checks that the deviations speak of this site: after that their elements and spaces are those of the site.
    ///
    /// # Errors
    /// Another site's hash, or records that the site does not have.
    pub fn check_site(&self, site: &Site<'_>) -> Result<(), OtherSite> {
        let belongs = self.head.site_hash == site.content_hash()
            && (self.head.map_storey as usize) < site.map_storeys.len()
            && self.elements.iter().all(|e| (e.element as usize) < site.elements.len())
            && self.obstacles.iter().all(|o| o.space == NONE || (o.space as usize) < site.spaces.len());
        check(belongs, "list of deviations")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ContentHash, ScheduleStateBuilder, SiteBuilder};

    #[test]
    fn a_schedule_state_of_another_site_is_refused_with_a_reason() {
        let site = SiteBuilder::default().finish();
        let site = Site::open(site.bytes()).unwrap();
        let check = |hash: ContentHash, n_elements: usize| {
            let schedule_state = ScheduleStateBuilder::everything_built(hash, n_elements, 0).finish();
            ScheduleState::open(schedule_state.bytes()).unwrap().check_site(&site).map_err(|e| e.to_string())
        };
        assert_eq!(check(site.content_hash(), 0), Ok(()));
        assert_eq!(check(ContentHash::from_bits(1), 0), Err("the schedule state is of another site".to_owned()));
        assert_eq!(check(site.content_hash(), 1), Err("the schedule state is of another site".to_owned()));
    }
}
