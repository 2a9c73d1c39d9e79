//! The newest samples of a site that belong together, and the files of them.

use crate::failure::Failure;
use crate::maps::world_files;
use bus::{Bus, GridSlot, Sample, Subscriber, Topic};
use daemon::{Robot, SiteConfig};
use export::{ExportFile, ExportInput};
use messages::{Grid, Grids, Phase, Plan, Site};
use raster::Rasterizer;
use world::WorldOptions;

/// The newest samples, and whether they are of one state of the site.
pub(super) struct Sets {
    subscribers: [Subscriber; 4],
    slots: Vec<Subscriber>,
    site: Option<Sample>,
    phase: Option<Sample>,
    index: Option<Sample>,
    plan: Option<Sample>,
    grids: Vec<Option<Sample>>,
    /// Footprints are not on the bus: cutting gives the same again. With the hashes of what it was made from.
    cut: Option<([u64; 2], Rasterizer)>,
}

impl Sets {
    pub(super) fn of(bus: &Bus) -> Result<Self, Failure> {
        let subscriber = |topic| bus.subscriber(topic).map_err(Failure::work);
        let [site, phase, grids, plan] = [Topic::Site, Topic::Phase, Topic::Grids, Topic::Plan].map(subscriber);
        let subscribers = [site?, phase?, grids?, plan?];
        let slots = GridSlot::all().map(|slot| subscriber(Topic::Grid(slot))).collect::<Result<Vec<_>, _>>()?;
        let grids = slots.iter().map(|_| None).collect();
        Ok(Self { subscribers, slots, site: None, phase: None, index: None, plan: None, grids, cut: None })
    }

    /// Takes what has come; true if the newest samples belong together.
    pub(super) fn take(&mut self) -> Result<bool, Failure> {
        let newest =
            [&mut self.site, &mut self.phase, &mut self.index, &mut self.plan].into_iter().zip(&self.subscribers);
        for (sample, subscriber) in newest.chain(self.grids.iter_mut().zip(&self.slots)) {
            if let Some(newer) = subscriber.take().map_err(Failure::work)? {
                *sample = Some(newer);
            }
        }
        let index = self.index.as_ref();
        let is_of_index = |plan: &Sample| index.is_some_and(|i| plan.header().inputs.grids == i.header().content_hash);
        Ok(self.plan.as_ref().is_some_and(is_of_index)
            && is_one_set(self.site.as_ref(), self.phase.as_ref(), index, &self.grids))
    }

    /// Epoch of the plan, which is the last of a set.
    pub(super) fn epoch(&self) -> Option<u64> {
        self.plan.as_ref().map(|plan| plan.header().epoch)
    }

    /// The files of the samples, which belong together.
    pub(super) fn files(
        &mut self,
        config: &SiteConfig,
        world: Option<&WorldOptions>,
    ) -> Result<Vec<ExportFile>, Failure> {
        let (Some(site), Some(phase), Some(index), Some(plan)) = (&self.site, &self.phase, &self.index, &self.plan)
        else {
            return Err(Failure::work("there are no maps yet"));
        };
        let site = Site::open(site.bytes()).map_err(Failure::work)?;
        let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
        let inputs = index.header().inputs;
        let index = Grids::open(index.bytes()).map_err(Failure::work)?;
        let grids = self.grids.iter().flatten().take(index.slots.len()).map(|g| Grid::open(g.bytes()));
        let grids: Vec<Grid<'_>> = grids.collect::<Result<_, _>>().map_err(Failure::work)?;
        phase.check_site(&site).map_err(Failure::work)?;
        index.check_site(&site).map_err(Failure::work)?;
        grids.iter().try_for_each(|grid| grid.check_site(&site)).map_err(Failure::work)?;
        let profile = index.head.robot;
        let made_from = [inputs.site, inputs.robot];
        if self.cut.as_ref().is_none_or(|(of, _)| *of != made_from) {
            let rasterizer = Rasterizer::new(&site, &profile, config.robot.resolution_m).map_err(Failure::work)?;
            self.cut = Some((made_from, rasterizer));
        }
        let footprints: Vec<_> =
            self.cut.iter().flat_map(|(_, cut)| (0..grids.len()).map(|k| cut.footprints(k))).collect();
        let plan = Plan::open(plan.bytes()).map_err(Failure::work)?;
        plan.check_site(&site).map_err(Failure::work)?;
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
        Ok(export::files(&input, world_files(&input, world)))
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
