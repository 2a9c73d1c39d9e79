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
    /// Site and schedule state that are drawn; they belong together.
    site: Option<(CheckedSample<topics::Site>, Rasterizer)>,
    schedule_state: Option<CheckedSample<topics::ScheduleState>>,
    /// Newer ones of which the other is not there yet: until then what is drawn stays.
    next_site: Option<CheckedSample<topics::Site>>,
    next_state: Option<CheckedSample<topics::ScheduleState>>,
    /// Why the newest site cannot be drawn.
    error: Option<String>,
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
            next_site: None,
            next_state: None,
            error: None,
            published: Vec::new(),
            next_epochs: Vec::new(),
            is_pending: false,
            last: Published::default(),
            last_plan_time_s: ScheduleStateHead::NO_TIME,
        })
    }

    fn handle_site(&mut self, site: CheckedSample<topics::Site>) -> Result<Done, Failure> {
        match &mut self.site {
            Some((drawn, _)) if drawn.content_hash() == site.content_hash() => {
                (*drawn, self.next_site) = (site, None);
                Ok(Done::default())
            }
            _ => {
                self.next_site = Some(site);
                self.take_next()
            }
        }
    }

    /// Draws the newest site and schedule state as soon as they belong together: a revision takes effect as a whole.
    fn take_next(&mut self) -> Result<Done, Failure> {
        let Some(state) = &self.next_state else { return Ok(Done::default()) };
        let site_hash = state.view().head.site_hash;
        if let Some(site) = self.next_site.take_if(|site| site.content_hash() == site_hash) {
            match self.prepared(&site) {
                Ok(rasterizer) => {
                    self.published = vec![None; rasterizer.n_storeys()];
                    (self.site, self.error) = (Some((site, rasterizer)), None);
                }
                Err(why) => {
                    self.error = Some(daemon::chain(why.as_ref()));
                    self.next_site = Some(site);
                    return Err(why);
                }
            }
        }
        // Another site is drawn: the one of this state will come.
        if self.site.as_ref().is_none_or(|(site, _)| site.content_hash() != site_hash) {
            return Ok(Done::default());
        }
        self.schedule_state = self.next_state.take();
        self.draw()
    }

    fn prepared(&self, site: &CheckedSample<topics::Site>) -> Result<Rasterizer, Failure> {
        self.activity.set(Activity::Reading);
        let rasterizer = Rasterizer::new(&site.view(), &self.robot.profile, self.resolution_m)?;
        let n = rasterizer.n_storeys();
        if n > GridSlot::COUNT {
            return Err(format!("the site has {n} map storeys, the bus has room for {}", GridSlot::COUNT).into());
        }
        Ok(rasterizer)
    }

    fn set_robot(&mut self, profile: &Path) -> Result<Done, Failure> {
        self.robot = self.saved.set(profile)?;
        self.warning = None;
        self.prepare_and_draw()
    }

    /// Prepares the site for the robot, and draws it.
    fn prepare_and_draw(&mut self) -> Result<Done, Failure> {
        let mut done = self.done();
        if let Some((site, rasterizer)) = &mut self.site {
            self.activity.set(Activity::Reading);
            *rasterizer = Rasterizer::new(&site.view(), &self.robot.profile, self.resolution_m)?;
            self.published.fill(None);
            done = self.draw()?;
        }
        // A site that could not be drawn may be drawn now.
        if self.error.is_some() { self.take_next() } else { Ok(done) }
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
        (self.next_site, self.next_state) = (None, None);
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
                self.next_state = Some(schedule_state);
                self.take_next()
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
        Standing { error: self.error.clone(), warning: self.warning.clone() }
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
