//! Plans all storeys and reuses results of unchanged ones.

use crate::centre::Storey;
use crate::changed::{cells_of, changed_elements};
use crate::floor_parts::{PartFacts, first_part, floor_parts, part_facts};
use crate::ground::Ground;
use crate::input::PlanInput;
use crate::instance::Instance;
use crate::plan_archive::assemble;
use crate::portal::Portal;
use crate::portals::portals;
use crate::reachability::Reached;
use crate::spaces::{Refusal, refused};
use crate::steps::steps;
use crate::stops::Wanted;
use crate::storey_plan::{StoreyPlan, instance_of, plan_storey};
use messages::{ArchiveBuffer, DoorPassageRecord, Grid, NoWaypoint, RobotProfile, space_flags};
use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3;

/// Plans, and keeps what only a part of the next input can change.
///
/// A plan is a function of its input: what is kept is used only where it was made from the same.
#[derive(Default)]
pub struct Planner {
    /// With the hash of what each was made from.
    grounds: Vec<(u64, Ground)>,
    storeys: Vec<(u64, StoreyPlan)>,
}

/// Where scans of a storey could be made, for whoever compares choices.
#[derive(Debug)]
pub struct StoreyInstance {
    /// Map storey of the site.
    pub map_storey: u32,
    /// The faces that a scan from each place sees, and how many are to be seen.
    pub instance: Instance,
    /// Places at the centroids of spaces that the robot can stand at.
    pub centroids: Vec<u32>,
    /// Floor that the middle of the robot can get to.
    pub reached_m2: f64,
}

impl Planner {
    /// What the scans of each storey are chosen from.
    pub fn instances(&mut self, input: &PlanInput<'_>) -> Vec<StoreyInstance> {
        self.plan(input);
        let PlanInput { site, phase, options, .. } = *input;
        let grounds: Vec<&Ground> = self.grounds.iter().map(|g| &g.1).collect();
        let portals = ways_between(input, &grounds);
        let (reached, _) = reached(input, &grounds, &portals);
        let refusals: Vec<Option<Refusal>> = (0..site.spaces.len()).map(|k| refused(site, phase, options, k)).collect();
        let changed = options.changed_since_s.map(|since_s| changed_elements(site, phase, since_s));
        let jobs = input.grids.iter().enumerate();
        let jobs = jobs.map(|(at, grid)| Job::new(input, at, grid, &refusals, &reached, &portals, changed.as_deref()));
        jobs.zip(&self.storeys)
            .map(|(job, (_, plan))| {
                let (instance, centroids) = job.with(input, grounds[job.at], instance_of);
                let map_storey = job.grid.head.map_storey;
                StoreyInstance { map_storey, instance, centroids, reached_m2: plan.reached_m2 }
            })
            .collect()
    }

    /// Makes the plan. What is planned anew is whole storeys: those whose map, spaces or ways in changed.
    pub fn plan(&mut self, input: &PlanInput<'_>) -> ArchiveBuffer {
        let PlanInput { site, phase, index, grids, options } = *input;
        let robot = &index.head.robot;
        self.see_grounds(grids, robot);
        let grounds: Vec<&Ground> = self.grounds.iter().map(|g| &g.1).collect();
        let portals = ways_between(input, &grounds);
        let (reached, facts) = reached(input, &grounds, &portals);
        let refusals: Vec<Option<Refusal>> = (0..site.spaces.len()).map(|k| refused(site, phase, options, k)).collect();
        let changed = options.changed_since_s.map(|since_s| changed_elements(site, phase, since_s));
        let jobs: Vec<Job<'_>> = grids
            .iter()
            .enumerate()
            .map(|(at, grid)| Job::new(input, at, grid, &refusals, &reached, &portals, changed.as_deref()))
            .collect();
        let kept = &mut self.storeys;
        kept.resize_with(jobs.len(), || (0, StoreyPlan::default()));
        let old: Vec<(u64, StoreyPlan)> = std::mem::take(kept);
        *kept = jobs
            .par_iter()
            .zip(old)
            .map(|(job, (made_from, plan))| {
                let now = job.made_from(input);
                (now, if now == made_from { plan } else { job.plan(input, grounds[job.at]) })
            })
            .collect();
        let plans: Vec<&StoreyPlan> = kept.iter().map(|k| &k.1).collect();
        let parts = floor_parts(input, &grounds, &reached, &facts);
        assemble(input, &grounds, &plans, refusals, &reached, &portals, parts).finish()
    }

    fn see_grounds(&mut self, grids: &[Grid<'_>], robot: &RobotProfile) {
        let old = std::mem::take(&mut self.grounds);
        let mut old: Vec<Option<(u64, Ground)>> = old.into_iter().map(Some).collect();
        old.resize_with(grids.len(), || None);
        self.grounds = grids
            .par_iter()
            .zip(old)
            .map(|(grid, old)| {
                let made_from = grid.content_hash() ^ robot.radius_m.to_bits().rotate_left(17);
                old.filter(|o| o.0 == made_from).unwrap_or_else(|| (made_from, Ground::of(grid, robot.radius_m)))
            })
            .collect();
    }
}

/// Stairs, ramps, lifts and steps from storey to storey.
fn ways_between(input: &PlanInput<'_>, grounds: &[&Ground]) -> Vec<Portal> {
    let PlanInput { site, phase, index, grids, options } = *input;
    let robot = &index.head.robot;
    let mut ways = portals(site, phase, robot, options, grounds);
    ways.extend(steps(site, phase, robot, grids, grounds));
    ways
}

/// What the robot gets to, and the facts of each storey's parts.
fn reached(input: &PlanInput<'_>, grounds: &[&Ground], portals: &[Portal]) -> (Reached, Vec<Vec<PartFacts>>) {
    let facts: Vec<Vec<PartFacts>> =
        grounds.iter().enumerate().map(|(storey, ground)| part_facts(input, storey, ground, portals)).collect();
    let first: Vec<u32> = grounds.iter().zip(&facts).map(|(ground, facts)| first_part(ground, facts)).collect();
    (Reached::of(grounds, portals, &first, input.options.start), facts)
}

/// What is to be done on a storey.
struct Job<'a> {
    at: usize,
    grid: &'a Grid<'a>,
    spaces: Vec<usize>,
    may_scan: Vec<bool>,
    passages: Vec<DoorPassageRecord>,
    reached: &'a [bool],
    entries: &'a [frames::Point2<frames::Map>],
    stagings: Vec<(usize, u32)>,
    changed: Option<&'a [usize]>,
}

impl<'a> Job<'a> {
    fn new(
        input: &PlanInput<'a>,
        at: usize,
        grid: &'a Grid<'a>,
        refusals: &[Option<Refusal>],
        reached: &'a Reached,
        portals: &[Portal],
        changed: Option<&'a [usize]>,
    ) -> Self {
        let site = input.site;
        let is_here = |space: usize| site.spaces[space].map_storey == grid.head.map_storey;
        // Outside of spaces it may scan, unless somebody asked for some spaces.
        let mut may_scan = vec![input.options.spaces.is_empty(); site.spaces.len() + 1];
        for (space, refusal) in refusals.iter().enumerate() {
            let is_open = |r: &Refusal| r.why == NoWaypoint::MetadataOnly && input.options.spaces.is_empty();
            may_scan[space + 1] =
                refusal.as_ref().is_none_or(is_open) && !site.spaces[space].has(space_flags::EXTERNAL);
        }
        let ends = portals.iter().flat_map(|p| p.ends.map(|end| (end, p.element as u32)));
        let mut stagings: Vec<(usize, u32)> =
            ends.filter(|(end, _)| end.storey == at).map(|(end, element)| (end.cell, element)).collect();
        stagings.sort_unstable();
        stagings.dedup();
        Self {
            at,
            grid,
            spaces: (0..site.spaces.len()).filter(|&k| refusals[k].is_none() && is_here(k)).collect(),
            may_scan,
            passages: input.index.doors.iter().filter(|d| d.map_storey == grid.head.map_storey).copied().collect(),
            reached: &reached.parts[at],
            entries: &reached.entries[at],
            stagings,
            changed,
        }
    }

    /// Hash of everything that the storey's plan is a function of.
    fn made_from(&self, input: &PlanInput<'_>) -> u64 {
        let mut hash = Xxh3::new();
        let numbers = |list: &mut dyn Iterator<Item = u64>, hash: &mut Xxh3| {
            let mut n = 0u64;
            for number in list {
                hash.update(&number.to_le_bytes());
                n += 1;
            }
            hash.update(&n.to_le_bytes());
        };
        numbers(&mut [input.site.content_hash(), self.grid.content_hash()].into_iter(), &mut hash);
        hash.update(bytemuck::bytes_of(&input.index.head.robot));
        hash.update(format!("{:?}", input.options).as_bytes());
        hash.update(bytemuck::cast_slice(&self.passages));
        numbers(&mut self.spaces.iter().map(|&k| k as u64), &mut hash);
        let is_here = |space: &usize| {
            space.checked_sub(1).is_none_or(|s| input.site.spaces[s].map_storey == self.grid.head.map_storey)
        };
        let may_scan = self.may_scan.iter().enumerate().filter(|(space, _)| is_here(space));
        numbers(&mut may_scan.map(|(_, &b)| u64::from(b)), &mut hash);
        numbers(&mut self.reached.iter().map(|&b| u64::from(b)), &mut hash);
        numbers(&mut self.entries.iter().flat_map(|p| [p.x_m.to_bits(), p.y_m.to_bits()]), &mut hash);
        numbers(&mut self.stagings.iter().flat_map(|&(cell, element)| [cell as u64, u64::from(element)]), &mut hash);
        numbers(&mut self.changed.unwrap_or_default().iter().map(|&k| k as u64), &mut hash);
        if input.options.mesh_check {
            // It sees more than the map shows.
            let states = (0..input.site.elements.len()).map(|element| input.phase.effective(element) as u64);
            numbers(&mut states.into_iter(), &mut hash);
        }
        hash.digest()
    }

    fn plan(&self, input: &PlanInput<'_>, ground: &Ground) -> StoreyPlan {
        self.with(input, ground, plan_storey)
    }

    fn with<T>(&self, input: &PlanInput<'_>, ground: &Ground, work: fn(&Storey<'_>, &Wanted<'_>) -> T) -> T {
        let targets = self.changed.map(|elements| cells_of(input.site, self.grid, elements));
        let storey = Storey {
            site: input.site,
            phase: input.phase,
            grid: self.grid,
            ground,
            robot: &input.index.head.robot,
            passages: &self.passages,
            reached: self.reached,
        };
        let wanted = Wanted {
            options: input.options,
            spaces: &self.spaces,
            may_scan: &self.may_scan,
            changed: self.changed,
            targets: targets.as_deref(),
            entries: self.entries,
            stagings: &self.stagings,
        };
        work(&storey, &wanted)
    }
}
