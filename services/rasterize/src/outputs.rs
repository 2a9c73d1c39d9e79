//! The topics of rasterize: a grid for each map storey, and their index, drawn into the memory of the bus.

use crate::drawing_settings::DrawingSettings;
use bus::{Bus, CheckedSample, GridSlot, Origin, PublishError, Publisher, topics};
use daemon::{Decide, Epochs, Failure, Outputs, Published, Robot};
use messages::{ContentHash, InputHashes, RobotProfile, ScheduleStateHead};
use raster::Rasterizer;
use rayon::prelude::*;
use std::sync::Arc;
use tracing::{info, warn};

/// What grids are to be drawn.
pub struct Drawing {
    /// Of which site and schedule state.
    pub(crate) of: Which,
    /// For which robot, at which resolution.
    pub(crate) settings: Arc<DrawingSettings>,
    /// What draws them; `None` where the outputs [have](GridOutputs::can_draw) one.
    pub(crate) prepared: Option<Box<Prepared>>,
}

/// Which site and schedule state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Which {
    /// The newest.
    Newest,
    /// Those that are drawn.
    Drawn,
}

/// Site and schedule state that belong together.
#[derive(Clone, Copy)]
pub(crate) struct Pair<'a> {
    pub(crate) site: &'a CheckedSample<topics::Site>,
    pub(crate) state: &'a CheckedSample<topics::ScheduleState>,
}

/// Who has what grids are drawn of.
pub(crate) trait Drawn {
    /// Site and schedule state that belong together, if there are such.
    fn pair(&self, which: Which) -> Option<Pair<'_>>;

    /// The settings in force.
    fn settings(&self) -> &DrawingSettings;
}

/// A rasterizer, and what it was made for.
pub(crate) struct Prepared {
    site: ContentHash,
    profile: RobotProfile,
    resolution_m: f64,
    rasterizer: Rasterizer,
}

impl Prepared {
    pub(crate) fn new(site: ContentHash, settings: &DrawingSettings, rasterizer: Rasterizer) -> Self {
        let (profile, resolution_m) = (settings.robot().profile, settings.resolution_m());
        Self { site, profile, resolution_m, rasterizer }
    }

    fn is_for(&self, site: ContentHash, settings: &DrawingSettings) -> bool {
        (self.site, self.profile, self.resolution_m) == (site, settings.robot().profile, settings.resolution_m())
    }
}

/// The ends of the topics.
#[derive(Default)]
pub struct GridOutputs {
    bus: Option<Bus>,
    index: Option<Publisher<topics::Grids>>,
    grids: Vec<Publisher<topics::Grid>>,
    /// What draws what is published.
    rasterizer: Option<Box<Prepared>>,
    /// The one before, or one whose grids had no room: it need not be made again.
    spare: Option<Box<Prepared>>,
    /// True while the rasterizer is that of a decision that is not settled.
    is_swapped: bool,
    /// Content hash of what was published of each storey; `None` for nothing.
    published: Vec<Option<ContentHash>>,
    /// Epoch of what is to be published of each storey; `None` where nothing changed.
    next_epochs: Vec<Option<u64>>,
    /// True while what is published is not whole.
    is_pending: bool,
    last: Last,
}

/// What was published last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Last {
    pub(crate) grids: Published,
    pub(crate) inputs: InputHashes,
    /// Epochs of the site and of the schedule state that it shows.
    pub(crate) epochs: [u64; 2],
    pub(crate) plan_time_s: i64,
}

impl Default for Last {
    fn default() -> Self {
        let (grids, inputs) = (Published::default(), InputHashes::default());
        Self { grids, inputs, epochs: [0; 2], plan_time_s: ScheduleStateHead::NO_TIME }
    }
}

impl GridOutputs {
    /// What was published last.
    pub(crate) fn last(&self) -> &Last {
        &self.last
    }

    /// Map storeys of what is published.
    pub(crate) fn n_storeys(&self) -> usize {
        self.published.len()
    }

    /// True if a rasterizer for this is at hand.
    pub(crate) fn can_draw(&self, site: ContentHash, settings: &DrawingSettings) -> bool {
        [&self.rasterizer, &self.spare].into_iter().flatten().any(|prepared| prepared.is_for(site, settings))
    }

    /// Makes the rasterizer for this the one that draws.
    fn prepare(&mut self, site: ContentHash, settings: &DrawingSettings, prepared: Option<Box<Prepared>>) {
        if self.rasterizer.as_ref().is_some_and(|prepared| prepared.is_for(site, settings)) {
            return;
        }
        if prepared.is_some() {
            self.spare = prepared;
        }
        self.swap();
        self.is_swapped = true;
    }

    /// Draws with the other rasterizer; nothing is published of its grids yet.
    fn swap(&mut self) {
        std::mem::swap(&mut self.rasterizer, &mut self.spare);
        let n_storeys = self.rasterizer.as_ref().map_or(0, |prepared| prepared.rasterizer.n_storeys());
        self.published.clear();
        self.published.resize(n_storeys, None);
    }

    /// Draws what differs from what is published, publishes those storeys, then the index that names them.
    ///
    /// Once every schedule state was seen this allocates nothing: what it needs is kept by the rasterizer.
    fn draw(&mut self, pair: &Pair<'_>, settings: &DrawingSettings, epochs: &mut Epochs) -> Result<(), Failure> {
        let (Some(bus), Some(index), Some(prepared)) = (&self.bus, &self.index, &mut self.rasterizer) else {
            return Err("it is not attached to a bus".into());
        };
        let rasterizer = &mut prepared.rasterizer;
        let [of_site, of_state] = [pair.site.bytes().header(), pair.state.bytes().header()];
        let (frame_epoch, epochs_in) = (of_site.frame_epoch, [of_site.epoch, of_state.epoch]);
        let (site, schedule_state) = (pair.site.view(), pair.state.view());
        schedule_state.check_site(&site)?;
        self.is_pending = true;
        rasterizer.draw(&site, &schedule_state);
        let robot = settings.robot();
        let inputs = InputHashes {
            site: site.content_hash(),
            schedule_state: schedule_state.content_hash(),
            robot: hash_of(robot),
            ..InputHashes::default()
        };
        self.next_epochs.clear();
        for (storey, grid) in rasterizer.drawn().enumerate() {
            if self.grids.len() == storey {
                let slot = GridSlot::new(storey).ok_or("there are more storeys than slots")?;
                self.grids.push(bus.publisher(topics::Grid(slot), grid.archive.len())?);
            }
            let is_new = self.published[storey] != Some(grid.content_hash);
            self.next_epochs.push(if is_new { Some(epochs.take()?) } else { None });
        }
        let slots = self.grids.par_iter().zip(&self.next_epochs).zip(&mut self.published);
        slots.zip(rasterizer.par_drawn()).try_for_each(|(((publisher, epoch), published), grid)| {
            let Some(epoch) = *epoch else { return Ok(()) };
            let inputs = InputHashes { own: grid.input_hash, ..inputs };
            let mut loan = publisher.loan(grid.archive.len())?;
            grid.copy_into(loan.bytes_mut());
            loan.publish(Origin { epoch, frame_epoch, inputs })?;
            *published = Some(grid.content_hash);
            Ok::<(), PublishError>(())
        })?;
        let n_published = self.next_epochs.iter().flatten().count();
        let storeys = rasterizer.n_storeys();
        let archive = rasterizer.index(&site, &schedule_state, &robot.name, &robot.footprint_m, &robot.safety);
        let epoch = epochs.take()?;
        let sent = index.publish(&archive, Origin { epoch, frame_epoch, inputs })?;
        info!(service = "rasterize", epoch, storeys, published = n_published, "grids published");
        self.is_pending = false;
        let grids = Published { content_hash: sent.content_hash, epoch };
        self.last = Last { grids, inputs, epochs: epochs_in, plan_time_s: schedule_state.head.plan_time_s };
        Ok(())
    }
}

impl<D: Decide + Drawn> Outputs<D> for GridOutputs {
    type Publication = Drawing;

    fn attach(&mut self, bus: &Bus, _: &mut Epochs) -> Result<(), Failure> {
        // Ports of an earlier generation cannot be used; what is published in this one begins with its inputs.
        self.index = None;
        self.grids.clear();
        self.published.fill(None);
        self.is_pending = false;
        self.index = Some(bus.publisher(topics::Grids, 1 << 16)?);
        self.bus = Some(bus.clone());
        Ok(())
    }

    fn publish(&mut self, drawing: Drawing, decider: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        let Drawing { of, settings, prepared } = drawing;
        let pair = decider.pair(of).ok_or("site and schedule state do not belong together")?;
        self.prepare(pair.site.content_hash(), &settings, prepared);
        self.draw(&pair, &settings, epochs)
    }

    fn settle(&mut self) {
        self.is_swapped = false;
    }

    fn go_back(&mut self, decider: &D, epochs: &mut Epochs) {
        if std::mem::take(&mut self.is_swapped) {
            self.swap();
        }
        if let Err(why) = self.retry(decider, epochs) {
            warn!(service = "rasterize", error = daemon::chain(why.as_ref()), "what was drawn before has no room yet");
        }
    }

    fn retry(&mut self, decider: &D, epochs: &mut Epochs) -> Result<bool, Failure> {
        let Some(pair) = decider.pair(Which::Drawn).filter(|_| self.is_pending) else { return Ok(false) };
        self.draw(&pair, decider.settings(), epochs)?;
        Ok(true)
    }

    fn published(&self) -> Published {
        self.last.grids
    }
}

/// Hash of what the products of a robot depend on; of one without safety rules that of its measures alone.
fn hash_of(robot: &Robot) -> ContentHash {
    let measures = bytemuck::bytes_of::<RobotProfile>(&robot.profile);
    if robot.safety.records().is_empty() {
        return ContentHash::of(measures);
    }
    let mut bytes = measures.to_vec();
    bytes.extend_from_slice(bytemuck::cast_slice(robot.safety.records()));
    bytes.extend_from_slice(robot.safety.materials());
    ContentHash::of(&bytes)
}
