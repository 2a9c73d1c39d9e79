//! The rasterize service: redraws and publishes the grids that a schedule state changes.

use crate::drawing_settings::{DrawingSettings, TriedSettings};
use bus::{Bus, CheckedSample, GridSlot, Origin, PublishError, Publisher, topics};
use daemon::facts::RasterizeFacts;
use daemon::{
    Asked, Caller, CurrentActivity, Done, Epochs, Event, Failure, History, HistoryEvent, HistoryKind, Published,
    RasterizeAnswer, RasterizeRequest, Service, SiteConfig, Standing,
};
use messages::{Activity, InputHashes, RobotProfile, ScheduleStateHead};
use raster::Rasterizer;
use rayon::prelude::*;
use tracing::{info, warn};

daemon::inputs! {
    /// What grids are made from.
    pub enum RasterizeInput { Site, ScheduleState }
}

/// Makes grids for one robot at one resolution.
pub struct RasterizeService {
    settings: DrawingSettings,
    history: History,
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
    last_inputs: InputHashes,
    /// Epochs of the site and of the schedule state that it shows.
    last_epochs: [u64; 2],
    last_plan_time_s: i64,
}

impl RasterizeService {
    /// From the configuration and the settings that were kept.
    ///
    /// # Errors
    /// A robot profile, a resolution or state that cannot be used.
    pub fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let service = Self {
            settings: DrawingSettings::open(&config.state, &config.robot)?,
            history: History::at(&config.state),
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
            last_inputs: InputHashes::default(),
            last_epochs: [0; 2],
            last_plan_time_s: ScheduleStateHead::NO_TIME,
        };
        if service.settings.were_edited() {
            service.record(None);
        }
        Ok(service)
    }

    fn handle_site(&mut self, site: CheckedSample<topics::Site>) -> Result<Done, Failure> {
        match &mut self.site {
            Some((drawn, _)) if drawn.content_hash() == site.content_hash() => {
                let epoch = site.bytes().header().epoch;
                (*drawn, self.next_site) = (site, None);
                if self.last_inputs.site == drawn.content_hash() {
                    self.last_epochs[0] = epoch;
                }
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
            match self.prepared(&site, &self.settings.robot().profile, self.settings.resolution_m()) {
                Ok(rasterizer) => {
                    self.published = vec![None; rasterizer.n_storeys()];
                    (self.site, self.error) = (Some((site, rasterizer)), None);
                }
                Err(why) => {
                    self.activity.set(Activity::Idle);
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

    fn prepared(
        &self,
        site: &CheckedSample<topics::Site>,
        robot: &RobotProfile,
        resolution_m: f64,
    ) -> Result<Rasterizer, Failure> {
        self.activity.set(Activity::Reading);
        let rasterizer = Rasterizer::new(&site.view(), robot, resolution_m)?;
        let n = rasterizer.n_storeys();
        if n > GridSlot::COUNT {
            return Err(format!("the site has {n} map storeys, the bus has room for {}", GridSlot::COUNT).into());
        }
        Ok(rasterizer)
    }

    /// Draws for another robot or resolution: prepared, on disk, published. What fails leaves everything as it was.
    fn redraw(&mut self, tried: TriedSettings) -> Result<Done, Failure> {
        let prepared = match &self.site {
            Some((site, _)) => Some(self.prepared(site, &tried.robot.profile, tried.resolution_m)?),
            None => None,
        };
        let before = self.settings.keep(tried)?;
        let rasterizer = self.replace_rasterizer(prepared);
        match self.draw() {
            // A site that could not be drawn may be drawn now; why it still cannot be stands in the status.
            Ok(done) if self.error.is_some() => Ok(self.take_next().unwrap_or(done)),
            Ok(done) => Ok(done),
            Err(why) => {
                self.settings.keep(before)?;
                self.replace_rasterizer(rasterizer);
                Err(why)
            }
        }
    }

    /// What was drawn with; nothing is published of the other one yet.
    fn replace_rasterizer(&mut self, other: Option<Rasterizer>) -> Option<Rasterizer> {
        let ((_, rasterizer), other) = (self.site.as_mut()?, other?);
        self.published.fill(None);
        Some(std::mem::replace(rasterizer, other))
    }

    /// Takes the edits of the site's file.
    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        let Some(tried) = self.settings.edited(&config.robot)? else { return Ok(Done::default()) };
        let done = self.redraw(tried)?;
        self.record(None);
        Ok(done)
    }

    fn record(&self, by: Option<Caller>) {
        let (robot, resolution_m) = (self.settings.robot_summary(), self.settings.resolution_m());
        let from = self.settings.robot_in_force().value;
        let summary = format!("{robot} ({from}), at {resolution_m} m a cell");
        if let Err(why) = self.history.record(HistoryEvent { kind: HistoryKind::Robot, by, summary }) {
            warn!(service = "rasterize", error = daemon::chain(&why), "the history cannot be written");
        }
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
        let epochs = [site.bytes().header().epoch, schedule_state.bytes().header().epoch];
        let (site, schedule_state) = (site.view(), schedule_state.view());
        if schedule_state.head.site_hash != site.content_hash() {
            // One of them is older; the other will come.
            return Ok(Done::default());
        }
        schedule_state.check_site(&site)?;
        self.activity.set(Activity::Writing);
        self.is_pending = true;
        rasterizer.draw(&site, &schedule_state);
        let robot = self.settings.robot();
        let inputs = InputHashes {
            site: site.content_hash(),
            schedule_state: schedule_state.content_hash(),
            robot: xxhash_rust::xxh3::xxh3_64(bytemuck::bytes_of::<RobotProfile>(&robot.profile)),
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
            let mut loan = publisher.loan(grid.archive.len())?;
            grid.copy_into(loan.bytes_mut());
            loan.publish(Origin { epoch, frame_epoch, inputs })?;
            *published = Some(grid.content_hash);
            Ok::<(), PublishError>(())
        })?;
        let n_published = self.next_epochs.iter().flatten().count();
        let storeys = rasterizer.n_storeys();
        let index = rasterizer.index(&site, &schedule_state, &robot.name, &robot.footprint_m);
        let epoch = self.epochs.take()?;
        let publisher = self.index.as_ref().ok_or("it is not attached to a bus")?;
        let sent = publisher.publish(&index, Origin { epoch, frame_epoch, inputs })?;
        info!(service = "rasterize", epoch, storeys, published = n_published, "grids published");
        self.activity.set(Activity::Published);
        self.is_pending = false;
        self.last = Published { content_hash: sent.content_hash, epoch };
        (self.last_inputs, self.last_epochs) = (inputs, epochs);
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

    fn answer(&mut self, request: RasterizeRequest, asked: &Asked) -> Result<Done<RasterizeAnswer>, Failure> {
        let RasterizeRequest::SetRobot { profile } = request;
        let done = self.redraw(self.settings.commanded(profile, asked.by.uid)?)?;
        self.record(Some(asked.by));
        let answer = RasterizeAnswer {
            grids: done.published,
            robot: self.settings.robot_summary(),
            resolution_m: self.settings.resolution_m(),
            setting: self.settings.robot_in_force(),
        };
        Ok(done.answered(answer))
    }

    fn standing(&self) -> Standing {
        Standing { error: self.error.clone(), warning: self.settings.warning().map(str::to_owned) }
    }

    fn facts(&self) -> RasterizeFacts {
        RasterizeFacts {
            grids: self.last,
            plan_time_s: Some(self.last_plan_time_s).filter(|at_s| *at_s != ScheduleStateHead::NO_TIME),
            site_hash: self.last_inputs.site,
            site_epoch: self.last_epochs[0],
            state_epoch: self.last_epochs[1],
            state_hash: self.last_inputs.schedule_state,
            storeys: self.published.len(),
            robot: self.settings.robot().name.clone(),
            resolution_m: self.settings.resolution_m(),
            settings: self.settings.in_force(),
        }
    }
}
