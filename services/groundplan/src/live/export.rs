//! The files of `convert`, made from what the daemons publish.

use super::join;
use crate::cli::ExportArgs;
use crate::failure::Failure;
use bus::{Bus, GridSlot, Sample, Topic, Waiter};
use daemon::{Robot, SiteConfig};
use export::{ExportInput, OutputFolder};
use messages::{Grid, Grids, Phase, Plan, Site};
use rasterize::Rasterizer;
use std::time::{Duration, Instant};

/// Samples that belong together are waited for.
const PATIENCE: Duration = Duration::from_secs(30);
const LOOK: Duration = Duration::from_millis(50);

/// Writes the output folder at the plan time that the daemons hold: the same bytes as `convert --date` at that instant.
///
/// # Errors
/// No daemons, samples that do not come together, a folder that cannot be written.
pub fn export(arguments: &ExportArgs) -> Result<String, Failure> {
    let config = arguments.site.config()?;
    let folder = OutputFolder::at(&arguments.out).map_err(Failure::usage)?;
    let (bus, mut waiter) = join(&config)?;
    let set = Set::take(&bus, &mut waiter)?;
    write(&config, &set, &folder)?;
    Ok(String::new())
}

/// Samples of one state of the site.
struct Set {
    site: Sample,
    phase: Sample,
    index: Sample,
    grids: Vec<Sample>,
}

impl Set {
    fn take(bus: &Bus, waiter: &mut Waiter) -> Result<Self, Failure> {
        let subscriber = |topic| bus.subscriber(topic).map_err(Failure::work);
        let (sites, phases, indices) = (subscriber(Topic::Site)?, subscriber(Topic::Phase)?, subscriber(Topic::Grids)?);
        let slots = GridSlot::all().map(|slot| subscriber(Topic::Grid(slot))).collect::<Result<Vec<_>, _>>()?;
        let (mut site, mut phase, mut index) = (None, None, None);
        let mut grids: Vec<Option<Sample>> = slots.iter().map(|_| None).collect();
        let begun = Instant::now();
        loop {
            site = sites.take().map_err(Failure::work)?.or(site);
            phase = phases.take().map_err(Failure::work)?.or(phase);
            index = indices.take().map_err(Failure::work)?.or(index);
            for (slot, grid) in slots.iter().zip(&mut grids) {
                if let Some(newer) = slot.take().map_err(Failure::work)? {
                    *grid = Some(newer);
                }
            }
            if is_one_set(site.as_ref(), phase.as_ref(), index.as_ref(), &grids)
                && let (Some(site), Some(phase), Some(index)) = (site.take(), phase.take(), index.take())
            {
                let n_slots = Grids::open(index.bytes()).map_err(Failure::work)?.slots.len();
                let grids = grids.into_iter().flatten().take(n_slots).collect();
                return Ok(Self { site, phase, index, grids });
            }
            if begun.elapsed() > PATIENCE {
                return Err(Failure::work("site, phase and grids do not come together: see groundplan status"));
            }
            waiter.wait(LOOK).map_err(Failure::work)?;
        }
    }
}

/// True if the index names the site, the phase and every grid.
fn is_one_set(site: Option<&Sample>, phase: Option<&Sample>, index: Option<&Sample>, grids: &[Option<Sample>]) -> bool {
    let (Some(site), Some(phase), Some(index)) = (site, phase, index) else { return false };
    let Ok(named) = Grids::open(index.bytes()) else { return false };
    let hash = |sample: &Sample| sample.header().content_hash;
    let mut slots = named.slots.iter().zip(grids);
    named.head.site_hash == hash(site)
        && named.head.phase_hash == hash(phase)
        && slots.all(|(slot, grid)| grid.as_ref().is_some_and(|g| hash(g) == slot.content_hash))
}

fn write(config: &SiteConfig, set: &Set, folder: &OutputFolder) -> Result<(), Failure> {
    let site = Site::open(set.site.bytes()).map_err(Failure::work)?;
    let phase = Phase::open(set.phase.bytes()).map_err(Failure::work)?;
    let index = Grids::open(set.index.bytes()).map_err(Failure::work)?;
    let grids: Vec<Grid<'_>> =
        set.grids.iter().map(|g| Grid::open(g.bytes())).collect::<Result<_, _>>().map_err(Failure::work)?;
    let profile = index.head.robot;
    // Footprints are not on the bus: cutting gives the same again.
    let rasterizer = Rasterizer::new(&site, &profile, config.robot.resolution_m).map_err(Failure::work)?;
    let footprints: Vec<_> = (0..grids.len()).map(|k| rasterizer.footprints(k)).collect();
    let plan = waypoint_gen::plan(&site, &phase, &grids, &profile);
    let plan = Plan::open(plan.bytes()).map_err(Failure::work)?;
    // Of the robot in use only the outline is not in the index.
    let configured = config.robot.profile.as_deref().map(Robot::read).transpose().map_err(Failure::usage)?;
    let outline =
        configured.filter(|robot| robot.profile == profile).map(|robot| robot.footprint_m).unwrap_or_default();
    let input = ExportInput {
        site: &site,
        phase: &phase,
        index: &index,
        grids: &grids,
        plan: &plan,
        footprints: &footprints,
        resolution_m: config.robot.resolution_m,
        robot_footprint_m: &outline,
        with_geometry: false,
    };
    folder.replace(&export::files(&input)).map_err(Failure::work)
}
