//! The rasterize service: redraws and publishes the grids that a schedule state changes.

use crate::saved_robot::SavedRobot;
use bus::{Bus, CheckedSample, GridSlot, Origin, PublishError, Publisher, topics};
use daemon::facts::RasterizeFacts;
use daemon::{
    Asked, CurrentActivity, Done, Epochs, Event, Failure, Published, RasterizeRequest, Robot, Service, SiteConfig,
    Standing,
};
use messages::{Activity, InputHashes, RobotProfile, ScheduleStateHead};
use raster::Rasterizer;
use rayon::prelude::*;
use std::path::Path;
use tracing::info;

daemon::inputs! {
    /// What grids are made from.
    pub enum RasterizeInput { Site, ScheduleState }
}

/// Makes grids for one robot at one resolution.
pub struct RasterizeService {
    robot: Robot,
    resolution_m: f64,
    saved: SavedRobot,
    /// What an operator should know about the robot.
    warning: Option<String>,
    epochs: Epochs,
    activity: CurrentActivity,
    bus: Option<Bus>,
    index: Option<Publisher<topics::Grids>>,
    grids: Vec<Publisher<topics::Grid>>,
    site: Option<(CheckedSample<topics::Site>, Rasterizer)>,
    schedule_state: Option<CheckedSample<topics::ScheduleState>>,
    /// Content hash of what was published of each storey; `None` for nothing.
    published: Vec<Option<u64>>,
    /// Epoch of what is to be published of each storey; `None` where nothing changed.
    next_epochs: Vec<Option<u64>>,
    /// True from a change until it is published: what fails for want of room is tried again.
    is_pending: bool,
    /// What was published last, and its plan time.
    last: Published,
    last_plan_time_s: i64,
}

impl RasterizeService {
    /// From the configuration and the persisted state: a robot that was set overrides the configured one.
    ///
    /// # Errors
    /// A robot profile, a resolution or state that cannot be used.
    pub fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let (saved, robot, warning) = SavedRobot::open(&config.state, &config.robot)?;
        grid::GridSpec::cell_tenths_of(config.robot.resolution_m)?;
        Ok(Self {
            robot,
            resolution_m: config.robot.resolution_m,
            saved,
            warning,
            epochs: Epochs::at(&config.state, "rasterize-epochs.json")?,
            activity,
            bus: None,
            index: None,
            grids: Vec::new(),
            site: None,
            schedule_state: None,
            published: Vec::new(),
            next_epochs: Vec::new(),
            is_pending: false,
            last: Published::default(),
            last_plan_time_s: ScheduleStateHead::NO_TIME,
        })
    }

    fn handle_site(&mut self, site: CheckedSample<topics::Site>) -> Result<Done, Failure> {
        self.activity.set(Activity::Reading);
        let rasterizer = Rasterizer::new(&site.view(), &self.robot.profile, self.resolution_m)?;
        if rasterizer.n_storeys() > GridSlot::COUNT {
            let n = rasterizer.n_storeys();
            return Err(format!("the site has {n} map storeys, the bus has room for {}", GridSlot::COUNT).into());
        }
        self.published = vec![None; rasterizer.n_storeys()];
        self.site = Some((site, rasterizer));
        self.draw()
    }

    fn set_robot(&mut self, profile: &Path) -> Result<Done, Failure> {
        self.robot = self.saved.set(profile)?;
        self.warning = None;
        self.prepare_and_draw()
    }

    /// Prepares the site for the robot, and draws it.
    fn prepare_and_draw(&mut self) -> Result<Done, Failure> {
        let Some((site, rasterizer)) = &mut self.site else { return Ok(self.done()) };
        self.activity.set(Activity::Reading);
        *rasterizer = Rasterizer::new(&site.view(), &self.robot.profile, self.resolution_m)?;
        self.published.fill(None);
        self.draw()
    }

    /// Another resolution; the robot is what was set last.
    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        if config.robot.resolution_m == self.resolution_m {
            return Ok(Done::default());
        }
        grid::GridSpec::cell_tenths_of(config.robot.resolution_m)?;
        self.resolution_m = config.robot.resolution_m;
        self.prepare_and_draw()
    }

    /// Draws what differs from what is published, publishes those storeys, then the index that names them.
    ///
    /// Once every schedule state was seen this allocates nothing: what it needs is kept by the rasterizer.
    fn draw(&mut self) -> Result<Done, Failure> {
        let (Some((site, rasterizer)), Some(schedule_state), Some(bus)) =
            (&mut self.site, &self.schedule_state, &self.bus)
        else {
            return Ok(self.done());
        };
        let frame_epoch = site.bytes().header().frame_epoch;
        let (site, schedule_state) = (site.view(), schedule_state.view());
        if schedule_state.head.site_hash != site.content_hash() {
            // One of them is older; the other will come.
            return Ok(Done::default());
        }
        schedule_state.check_site(&site)?;
        self.activity.set(Activity::Writing);
        self.is_pending = true;
        rasterizer.draw(&site, &schedule_state);
        let inputs = InputHashes {
            site: site.content_hash(),
            schedule_state: schedule_state.content_hash(),
            robot: xxhash_rust::xxh3::xxh3_64(bytemuck::bytes_of::<RobotProfile>(&self.robot.profile)),
            ..InputHashes::default()
        };
        self.next_epochs.clear();
        for (storey, grid) in rasterizer.drawn().enumerate() {
            if self.grids.len() == storey {
                let slot = GridSlot::new(storey).ok_or("there are more storeys than slots")?;
                self.grids.push(bus.publisher(topics::Grid(slot), grid.archive.len())?);
            }
            let is_new = self.published[storey] != Some(grid.content_hash);
            self.next_epochs.push(if is_new { Some(self.epochs.take()?) } else { None });
        }
        let slots = self.grids.par_iter().zip(&self.next_epochs).zip(&mut self.published);
        slots.zip(rasterizer.par_drawn()).try_for_each(|(((publisher, epoch), published), grid)| {
            let Some(epoch) = *epoch else { return Ok(()) };
            let inputs = InputHashes { own: grid.input_hash, ..inputs };
            publisher.publish_copy(grid.archive, Origin { epoch, frame_epoch, inputs })?;
            *published = Some(grid.content_hash);
            Ok::<(), PublishError>(())
        })?;
        let n_published = self.next_epochs.iter().flatten().count();
        let storeys = rasterizer.n_storeys();
        let index = rasterizer.index(&site, &schedule_state, &self.robot.name, &self.robot.footprint_m);
        let epoch = self.epochs.take()?;
        let publisher = self.index.as_ref().ok_or("it is not attached to a bus")?;
        let sent = publisher.publish(&index, Origin { epoch, frame_epoch, inputs })?;
        info!(service = "rasterize", epoch, storeys, published = n_published, "grids published");
        self.activity.set(Activity::Published);
        self.is_pending = false;
        self.last = Published { content_hash: sent.content_hash, epoch };
        self.last_plan_time_s = schedule_state.head.plan_time_s;
        Ok(self.done())
    }

    fn done(&self) -> Done {
        Done { published: self.last, ..Done::default() }
    }
}

impl Service for RasterizeService {
    type Input = RasterizeInput;
    type Request = RasterizeRequest;
    type Facts = RasterizeFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // Ports and samples of an earlier generation cannot be used; the inputs come again.
        (self.index, self.site, self.schedule_state) = (None, None, None);
        self.grids.clear();
        self.published.clear();
        self.index = Some(bus.publisher(topics::Grids, 1 << 16)?);
        self.bus = Some(bus.clone());
        Ok(())
    }

    fn handle(&mut self, event: Event<RasterizeInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(RasterizeInput::Site(site)) => self.handle_site(site),
            Event::Input(RasterizeInput::ScheduleState(schedule_state)) => {
                self.schedule_state = Some(schedule_state);
                self.draw()
            }
            Event::Configuration(config) => self.configure(&config),
            Event::Tick if self.is_pending => self.draw(),
            Event::Attached | Event::Tick => Ok(Done::default()),
        }
    }

    fn answer(&mut self, request: RasterizeRequest, _asked: &Asked) -> Result<Done<Published>, Failure> {
        let RasterizeRequest::SetRobot { profile } = request;
        Ok(self.set_robot(&profile)?.answered_by_published())
    }

    fn standing(&self) -> Standing {
        Standing { error: None, warning: self.warning.clone() }
    }

    fn facts(&self) -> RasterizeFacts {
        RasterizeFacts {
            grids: self.last,
            plan_time_s: Some(self.last_plan_time_s).filter(|at_s| *at_s != ScheduleStateHead::NO_TIME),
            storeys: self.published.len(),
            robot: self.robot.name.clone(),
            resolution_m: self.resolution_m,
        }
    }
}
