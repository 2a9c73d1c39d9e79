//! The newest samples of a site that belong together, and the files of them.

use crate::failure::Failure;
use crate::maps::world_files;
use bus::{Bus, CheckedSample, GridSlot, Subscriber, Topic, topics};
use daemon::{Robot, SiteConfig};
use export::{ExportFile, ExportInput};
use messages::{Checked, Grid};
use raster::Rasterizer;
use world::WorldOptions;

/// The newest samples, and whether they are of one state of the site.
pub(super) struct Sets {
    sites: Newest<topics::Site>,
    phases: Newest<topics::Phase>,
    indices: Newest<topics::Grids>,
    plans: Newest<topics::Plan>,
    grids: Vec<Newest<topics::Grid>>,
    /// Footprints are not on the bus: cutting gives the same again. With the hashes of what it was made from.
    cut: Option<([u64; 2], Rasterizer)>,
}

/// A topic with its newest sample.
struct Newest<T: Topic> {
    subscriber: Subscriber<T>,
    sample: Option<CheckedSample<T>>,
}

impl<T: Topic> Newest<T> {
    fn of(bus: &Bus, topic: T) -> Result<Self, Failure> {
        Ok(Self { subscriber: bus.subscriber(topic).map_err(Failure::work)?, sample: None })
    }

    fn take(&mut self) -> Result<(), Failure> {
        if let Some(newer) = self.subscriber.take().map_err(Failure::work)? {
            self.sample = Some(newer.check().map_err(Failure::work)?);
        }
        Ok(())
    }
}

impl Sets {
    pub(super) fn of(bus: &Bus) -> Result<Self, Failure> {
        Ok(Self {
            sites: Newest::of(bus, topics::Site)?,
            phases: Newest::of(bus, topics::Phase)?,
            indices: Newest::of(bus, topics::Grids)?,
            plans: Newest::of(bus, topics::Plan)?,
            grids: GridSlot::all().map(|slot| Newest::of(bus, topics::Grid(slot))).collect::<Result<_, _>>()?,
            cut: None,
        })
    }

    /// Takes what has come; true if the newest samples belong together.
    pub(super) fn take(&mut self) -> Result<bool, Failure> {
        self.sites.take()?;
        self.phases.take()?;
        self.indices.take()?;
        self.plans.take()?;
        self.grids.iter_mut().try_for_each(Newest::take)?;
        Ok(self.is_one_set())
    }

    /// True if the index names the site, the phase and every grid, and the plan is made from it.
    fn is_one_set(&self) -> bool {
        let (Some(site), Some(phase), Some(index), Some(plan)) =
            (&self.sites.sample, &self.phases.sample, &self.indices.sample, &self.plans.sample)
        else {
            return false;
        };
        let named = index.view();
        let mut slots = named.slots.iter().zip(&self.grids);
        plan.bytes().header().inputs.grids == index.content_hash()
            && named.head.site_hash == site.content_hash()
            && named.head.phase_hash == phase.content_hash()
            && slots.all(|(slot, grid)| grid.sample.as_ref().is_some_and(|g| g.content_hash() == slot.content_hash))
    }

    /// Epoch of the plan, which is the last of a set.
    pub(super) fn epoch(&self) -> Option<u64> {
        self.plans.sample.as_ref().map(|plan| plan.bytes().header().epoch)
    }

    /// The files of the samples, which belong together.
    pub(super) fn files(
        &mut self,
        config: &SiteConfig,
        world: Option<&WorldOptions>,
    ) -> Result<Vec<ExportFile>, Failure> {
        let (Some(site), Some(phase), Some(index), Some(plan)) =
            (&self.sites.sample, &self.phases.sample, &self.indices.sample, &self.plans.sample)
        else {
            return Err(Failure::work("there are no maps yet"));
        };
        let inputs = index.bytes().header().inputs;
        let (site, phase, index, plan) = (site.view(), phase.view(), index.view(), plan.view());
        let held = self.grids.iter().filter_map(|grid| grid.sample.as_ref());
        let grids: Vec<Grid<'_>> = held.take(index.slots.len()).map(Checked::view).collect();
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
