//! Plans all storeys, and reuses the results of storeys whose inputs did not change.

use crate::barriers::{BarriersOfParts, Obstacle, barriers};
use crate::changed_elements::{cells_of, changed_elements};
use crate::flight::{FlightPlan, flight_plan};
use crate::floor_parts::{PartProperties, first_part, floor_parts, part_properties};
use crate::free_space::FreeSpace;
use crate::ground_crossings::ground_crossings;
use crate::input::MissionPlanInput;
use crate::mission_plan_archive::{add_flight, assemble};
use crate::portal::Portal;
use crate::portals::portals;
use crate::reachability::Reachability;
use crate::scan_budget::within_budget;
use crate::scan_growth::GrownScan;
use crate::set_cover_instance::SetCoverInstance;
use crate::space_centre::StoreyInputs;
use crate::spaces::{Refusal, refused};
use crate::steps::steps;
use crate::storey_planner::{PlannedStorey, StoreySurvey, instance_of, plan_storey, survey_storey, without_waypoints};
use crate::tour_stops::StoreyRequest;
use messages::{
    ArchiveBuffer, ContentHash, DoorPassageRecord, FloorKind, MapGrids, NoWaypoint, StoreyEntry, space_flags,
};
use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3;

/// Storeys of more cells are planned one after the other.
const MAX_CELLS_AT_ONCE: usize = 20_000_000;

/// A planner that caches free space and plan of each storey by the hash of their inputs.
///
/// A mission plan is a function of its input: the cache has no influence on the result.
#[derive(Default)]
pub struct MissionPlanner {
    /// Each with the hash of its inputs.
    free_spaces: Vec<(ContentHash, FreeSpace)>,
    storeys: Vec<(ContentHash, PlannedStorey)>,
    /// With the hash of its inputs.
    flight: Option<(ContentHash, FlightPlan)>,
}

/// The set-cover instance of a storey, for comparing solvers.
#[derive(Debug)]
pub struct StoreyInstance {
    /// Map storey of the site.
    pub map_storey: u32,
    /// Visible faces of each candidate pose, and the coverage goals.
    pub instance: SetCoverInstance,
    /// Sets whose places are centres of spaces.
    pub centroids: Vec<u32>,
    /// Area of the reachable free space.
    pub reached_m2: f64,
}

impl MissionPlanner {
    /// The set-cover instance of each storey.
    pub fn instances(&mut self, input: &MissionPlanInput<'_>) -> Vec<StoreyInstance> {
        self.plan(input);
        let MissionPlanInput { site, schedule_state, options, .. } = *input;
        let free_spaces: Vec<&FreeSpace> = self.free_spaces.iter().map(|g| &g.1).collect();
        let portals = find_portals(input, &free_spaces);
        let (reached, _) = reached(input, &free_spaces, &portals);
        let refusals: Vec<Option<Refusal>> =
            (0..site.spaces.len()).map(|k| refused(site, schedule_state, options, k)).collect();
        let changed = options.changed_since_s.map(|since_s| changed_elements(site, schedule_state, since_s));
        let ways = Ways {
            reached: &reached,
            portals: &portals,
            barriers: &barriers(input, &free_spaces, &portals, &reached),
            free_spaces: &free_spaces,
        };
        let planned = (0..input.grids.count()).filter(|&at| input.grids.head(at).floor != FloorKind::Ground);
        let jobs = planned.map(|at| StoreyJob::new(input, at, &refusals, &ways, changed.as_deref()));
        jobs.map(|job| {
            let (instance, centroids) = job.with(input, free_spaces[job.at], instance_of);
            let map_storey = input.grids.head(job.at).map_storey;
            StoreyInstance { map_storey, instance, centroids, reached_m2: self.storeys[job.at].1.reached_m2 }
        })
        .collect()
    }

    /// Makes the mission plan. Storeys whose map, spaces or entries changed are planned again, the others are taken
    /// from the cache.
    pub fn plan(&mut self, input: &MissionPlanInput<'_>) -> ArchiveBuffer {
        let MissionPlanInput { site, schedule_state, grids, options, .. } = *input;
        self.update_free_spaces(input);
        let free_spaces: Vec<&FreeSpace> = self.free_spaces.iter().map(|g| &g.1).collect();
        let portals = find_portals(input, &free_spaces);
        let (reached, properties) = reached(input, &free_spaces, &portals);
        let refusals: Vec<Option<Refusal>> =
            (0..site.spaces.len()).map(|k| refused(site, schedule_state, options, k)).collect();
        let changed = options.changed_since_s.map(|since_s| changed_elements(site, schedule_state, since_s));
        let ways = Ways {
            reached: &reached,
            portals: &portals,
            barriers: &barriers(input, &free_spaces, &portals, &reached),
            free_spaces: &free_spaces,
        };
        let jobs: Vec<StoreyJob<'_>> =
            (0..grids.count()).map(|at| StoreyJob::new(input, at, &refusals, &ways, changed.as_deref())).collect();
        let kept = &mut self.storeys;
        kept.resize_with(jobs.len(), || (ContentHash::NONE, PlannedStorey::default()));
        let old: Vec<(ContentHash, PlannedStorey)> = std::mem::take(kept);
        *kept = if options.plans_scans() && options.has_budget() {
            planned_within_budget(input, &jobs, &free_spaces, old)
        } else {
            at_each_storey(grids, jobs.iter().zip(old).collect(), |(job, old)| {
                job.planned(input, free_spaces[job.at], old)
            })
        };
        let planned_storeys: Vec<&PlannedStorey> = kept.iter().map(|k| &k.1).collect();
        let parts = floor_parts(input, &free_spaces, &reached, &properties);
        let mut builder = assemble(input, &free_spaces, &planned_storeys, refusals, &reached, &portals, parts);
        self.flight = self.flight.take().filter(|(of, _)| *of == flight_hash(input));
        if let Some(options) = &options.flight {
            let (_, flight) = self.flight.get_or_insert_with(|| (flight_hash(input), flight_plan(input, options)));
            add_flight(&mut builder, flight);
        }
        builder.finish()
    }

    fn update_free_spaces(&mut self, input: &MissionPlanInput<'_>) {
        let (grids, robot) = (input.grids, &input.index.head.robot);
        let old = std::mem::take(&mut self.free_spaces);
        let mut old: Vec<Option<(ContentHash, FreeSpace)>> = old.into_iter().map(Some).collect();
        old.resize_with(grids.count(), || None);
        let free_space = |(at, old): (usize, Option<(ContentHash, FreeSpace)>)| {
            let inputs = grids.content_hash(at).to_bits() ^ robot.radius_m.to_bits().rotate_left(17);
            let layer = input.safety_layer(at);
            let kept_off = layer.as_ref().map_or(0, |layer| layer.content_hash().to_bits());
            let input_hash = ContentHash::from_bits(inputs ^ kept_off.rotate_left(31));
            let made = || grids.with(at, |grid| FreeSpace::of(grid, robot.radius_m)).keeping_off(layer.as_ref());
            old.filter(|o| o.0 == input_hash).unwrap_or_else(|| (input_hash, made()))
        };
        self.free_spaces = at_each_storey(grids, old.into_iter().enumerate().collect(), free_space);
    }
}

/// Hash of all that flight waypoints depend on.
fn flight_hash(input: &MissionPlanInput<'_>) -> ContentHash {
    let MissionPlanInput { site, schedule_state, grids, options, .. } = *input;
    let mut hash = Xxh3::new();
    let archives = [site.content_hash(), schedule_state.content_hash()].into_iter();
    let archives = archives.chain((0..grids.count()).map(|at| grids.content_hash(at)));
    archives.for_each(|of| hash.update(&of.to_bits().to_le_bytes()));
    hash.update(format!("{:?}", (&options.flight, &options.spaces, &options.storeys)).as_bytes());
    ContentHash::from_bits(hash.digest())
}

/// The results of work on each storey: on all threads, or one after the other if they are large, because a storey takes up to
/// twenty bytes a cell while it is worked on.
fn at_each_storey<I: Send, T: Send>(grids: &dyn MapGrids, inputs: Vec<I>, work: impl Fn(I) -> T + Sync) -> Vec<T> {
    if grids.heads().any(|head| head.spec().n_cells() > MAX_CELLS_AT_ONCE) {
        inputs.into_iter().map(work).collect()
    } else {
        inputs.into_par_iter().map(&work).collect()
    }
}

/// Portals between storeys: stairs, ramps, lifts and steps.
fn find_portals(input: &MissionPlanInput<'_>, free_spaces: &[&FreeSpace]) -> Vec<Portal> {
    let MissionPlanInput { site, schedule_state, index, grids, options } = *input;
    let robot = &index.head.robot;
    let mut tour_distances = portals(site, schedule_state, robot, options, free_spaces);
    tour_distances.extend(steps(site, schedule_state, robot, grids, free_spaces));
    tour_distances.extend(ground_crossings(input, free_spaces));
    tour_distances
}

/// Reachability, and the properties of each storey's parts.
fn reached(
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    portals: &[Portal],
) -> (Reachability, Vec<Vec<PartProperties>>) {
    let properties: Vec<Vec<PartProperties>> = free_spaces
        .iter()
        .enumerate()
        .map(|(storey, free_space)| {
            input.grids.with(storey, |grid| part_properties(input, storey, grid, free_space, portals))
        })
        .collect();
    let first: Vec<u32> = free_spaces
        .iter()
        .zip(&properties)
        .map(|(free_space, properties)| first_part(free_space, properties))
        .collect();
    let mut reached = Reachability::of(free_spaces, portals, &first, input.options.start);
    for (entry, (properties, &first)) in reached.entered.iter_mut().zip(properties.iter().zip(&first)) {
        if *entry == StoreyEntry::Placed && properties[first as usize].has_outer_door {
            *entry = StoreyEntry::OuterDoor;
        }
    }
    (reached, properties)
}

/// The plans of all storeys, each with the hash of the inputs of all: what a storey gets of a budget depends on the others.
fn planned_within_budget(
    input: &MissionPlanInput<'_>,
    jobs: &[StoreyJob<'_>],
    free_spaces: &[&FreeSpace],
    old: Vec<(ContentHash, PlannedStorey)>,
) -> Vec<(ContentHash, PlannedStorey)> {
    let mut hash = Xxh3::new();
    jobs.iter().for_each(|job| hash.update(&job.input_hash(input).to_le_bytes()));
    let now = ContentHash::from_bits(hash.digest());
    if old.iter().all(|(input_hash, _)| *input_hash == now) {
        return old;
    }
    let surveys: Vec<StoreySurvey> =
        at_each_storey(input.grids, jobs.iter().collect(), |job| job.with(input, free_spaces[job.at], survey_storey));
    let growths: Vec<&[GrownScan]> = surveys.iter().map(StoreySurvey::growth_to_goal).collect();
    let plan = |counts: &[usize]| {
        at_each_storey(input.grids, jobs.iter().zip(&surveys).zip(counts).collect(), |((job, survey), &n)| {
            job.with(input, free_spaces[job.at], |storey, request| plan_storey(storey, request, survey, Some(n)))
        })
    };
    within_budget(input.options, &growths, plan).into_iter().map(|planned| (now, planned)).collect()
}

/// Where the robot gets to, and what keeps it from the rest.
struct Ways<'a> {
    reached: &'a Reachability,
    portals: &'a [Portal],
    /// By storey.
    barriers: &'a [BarriersOfParts],
    free_spaces: &'a [&'a FreeSpace],
}

/// The inputs of planning one storey.
struct StoreyJob<'a> {
    at: usize,
    map_storey: u32,
    /// Hash of its grid.
    grid_hash: ContentHash,
    /// Hash of the distances that the robot keeps, if it does.
    kept_off: Option<ContentHash>,
    spaces: Vec<usize>,
    others: Vec<usize>,
    may_scan: Vec<bool>,
    passages: Vec<DoorPassageRecord>,
    reached: &'a [bool],
    barriers: &'a BarriersOfParts,
    entries: &'a [frames::Point2<frames::Map>],
    stagings: Vec<(usize, u32)>,
    changed: Option<&'a [usize]>,
}

impl<'a> StoreyJob<'a> {
    fn new(
        input: &MissionPlanInput<'a>,
        at: usize,
        refusals: &[Option<Refusal>],
        ways: &Ways<'a>,
        changed: Option<&'a [usize]>,
    ) -> Self {
        let (site, map_storey) = (input.site, input.grids.head(at).map_storey);
        let is_here = |space: usize| site.spaces[space].map_storey == map_storey;
        let needs_none =
            |r: &Refusal| matches!(r.why, NoWaypoint::External | NoWaypoint::Closing | NoWaypoint::NotAsked);
        // Scans outside of spaces are allowed unless spaces are selected.
        let mut may_scan = vec![input.options.spaces.is_empty(); site.spaces.len() + 1];
        for (space, refusal) in refusals.iter().enumerate() {
            let is_open = |r: &Refusal| r.why == NoWaypoint::MetadataOnly && input.options.spaces.is_empty();
            may_scan[space + 1] =
                refusal.as_ref().is_none_or(is_open) && !site.spaces[space].has(space_flags::EXTERNAL);
        }
        let ends = ways.portals.iter().flat_map(|p| p.ends.map(|end| (end, p.element as u32)));
        let mut stagings: Vec<(usize, u32)> =
            ends.filter(|(end, _)| end.storey == at).map(|(end, element)| (end.cell, element)).collect();
        stagings.sort_unstable();
        stagings.dedup();
        Self {
            at,
            map_storey,
            grid_hash: input.grids.content_hash(at),
            kept_off: ways.free_spaces[at].kept_off_hash(),
            spaces: (0..site.spaces.len()).filter(|&k| refusals[k].is_none() && is_here(k)).collect(),
            others: (0..site.spaces.len())
                .filter(|&k| refusals[k].as_ref().is_some_and(needs_none) && is_here(k))
                .collect(),
            may_scan,
            passages: input.passages_at(at),
            reached: &ways.reached.parts[at],
            barriers: &ways.barriers[at],
            entries: &ways.reached.entries[at],
            stagings,
            changed,
        }
    }

    /// Hash of all inputs of the storey's plan.
    fn input_hash(&self, input: &MissionPlanInput<'_>) -> ContentHash {
        let mut hash = Xxh3::new();
        let numbers = |list: &mut dyn Iterator<Item = u64>, hash: &mut Xxh3| {
            let mut n = 0u64;
            for number in list {
                hash.update(&number.to_le_bytes());
                n += 1;
            }
            hash.update(&n.to_le_bytes());
        };
        numbers(&mut [input.site.content_hash(), self.grid_hash].map(ContentHash::to_bits).into_iter(), &mut hash);
        hash.update(bytemuck::bytes_of(&input.index.head.robot));
        self.kept_off.into_iter().for_each(|kept_off| hash.update(&kept_off.to_bits().to_le_bytes()));
        hash.update(format!("{:?}", input.options).as_bytes());
        hash.update(bytemuck::cast_slice(&self.passages));
        numbers(&mut self.spaces.iter().map(|&k| k as u64), &mut hash);
        numbers(&mut self.others.iter().map(|&k| k as u64), &mut hash);
        hash.update(format!("{:?}", self.barriers).as_bytes());
        // The reason of a room names why rooms on the way are blocked.
        for obstacle in self.barriers.iter().flatten() {
            if let Obstacle::Space(space) = obstacle {
                input.schedule_state.why(*space).for_each(|why| hash.update(why.as_bytes()));
            }
        }
        let is_here =
            |space: &usize| space.checked_sub(1).is_none_or(|s| input.site.spaces[s].map_storey == self.map_storey);
        let may_scan = self.may_scan.iter().enumerate().filter(|(space, _)| is_here(space));
        numbers(&mut may_scan.map(|(_, &b)| u64::from(b)), &mut hash);
        numbers(&mut self.reached.iter().map(|&b| u64::from(b)), &mut hash);
        numbers(&mut self.entries.iter().flat_map(|p| [p.x_m().to_bits(), p.y_m().to_bits()]), &mut hash);
        numbers(&mut self.stagings.iter().flat_map(|&(cell, element)| [cell as u64, u64::from(element)]), &mut hash);
        numbers(&mut self.changed.unwrap_or_default().iter().map(|&k| k as u64), &mut hash);
        if input.options.mesh_check {
            // The mesh check depends on more than the map.
            let states = (0..input.site.elements.len()).map(|element| input.schedule_state.effective(element) as u64);
            numbers(&mut states.into_iter(), &mut hash);
        }
        ContentHash::from_bits(hash.digest())
    }

    /// The plan with the hash of its inputs: the old one if that is the same.
    fn planned(
        &self,
        input: &MissionPlanInput<'_>,
        free_space: &FreeSpace,
        old: (ContentHash, PlannedStorey),
    ) -> (ContentHash, PlannedStorey) {
        let now = self.input_hash(input);
        if old.0 == now {
            return old;
        }
        // Outdoors ways are between places to which portals lead, and nothing is scanned.
        if self.stagings.is_empty() && input.grids.head(self.at).floor == FloorKind::Ground {
            return (now, without_waypoints(free_space, self.reached, input.site.spaces.len()));
        }
        let planned = self.with(input, free_space, |storey, request| {
            plan_storey(storey, request, &survey_storey(storey, request), None)
        });
        (now, planned)
    }

    fn with<T>(
        &self,
        input: &MissionPlanInput<'_>,
        free_space: &FreeSpace,
        work: impl Fn(&StoreyInputs<'_>, &StoreyRequest<'_>) -> T,
    ) -> T {
        input.grids.with(self.at, |grid| {
            let targets = self.changed.map(|elements| cells_of(input.site, grid, elements));
            let storey = StoreyInputs {
                site: input.site,
                schedule_state: input.schedule_state,
                grid,
                free_space,
                sight: &free_space.sight(),
                robot: &input.index.head.robot,
                passages: &self.passages,
                reached: self.reached,
                barriers: self.barriers,
            };
            let request = StoreyRequest {
                options: input.options,
                spaces: &self.spaces,
                others: &self.others,
                may_scan: &self.may_scan,
                changed: self.changed,
                targets: targets.as_deref(),
                entries: self.entries,
                stagings: &self.stagings,
            };
            work(&storey, &request)
        })
    }
}
