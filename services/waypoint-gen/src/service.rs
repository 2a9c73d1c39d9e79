//! The waypoint-gen service: replans the storeys that new grids change.

use bus::{Bus, GridSlot, RawSubscriber, SiteSample, SiteSamples, SiteViews, TopicName, topics};
use daemon::facts::WaypointFacts;
use daemon::{
    Asked, CurrentActivity, Done, Epochs, Event, Failure, LatchedOutput, Published, Service, SiteConfig, StateFile,
    WaypointRequest,
};
use messages::{Activity, Checked, InputHashes};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Instant;
use tracing::info;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner, check_names};

daemon::inputs! {
    /// What waypoints are planned on. The index is published after its grids: they are taken when it comes.
    pub(crate) enum WaypointInput { Site, ScheduleState, Grids }
}

/// Plans for what is published.
pub(crate) struct WaypointService {
    /// Options of the configuration.
    configured: Option<PathBuf>,
    /// Options of the last request.
    requested: RequestedOptions,
    options: MissionPlanOptions,
    state: StateFile,
    epochs: Epochs,
    activity: CurrentActivity,
    output: LatchedOutput<topics::MissionPlan>,
    grids: Vec<RawSubscriber>,
    samples: SiteSamples,
    planner: MissionPlanner,
}

/// Options of a request. They override the configuration, and survive the daemon.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct RequestedOptions {
    options: Option<PathBuf>,
    spaces: Vec<String>,
    changed_since_s: Option<i64>,
}

impl WaypointService {
    /// From the configuration and the persisted state: requested options override configured ones.
    ///
    /// # Errors
    /// Options or state that cannot be used.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let state = StateFile::at(&config.state, "waypoints.json")?;
        let requested: RequestedOptions = state.load()?.unwrap_or_default();
        Ok(Self {
            options: options_of(config.waypoints.options.as_deref(), &requested)?,
            configured: config.waypoints.options.clone(),
            requested,
            state,
            epochs: Epochs::at(&config.state, "waypoint-gen-epochs.json")?,
            activity,
            output: LatchedOutput::new(topics::MissionPlan),
            grids: Vec::new(),
            samples: SiteSamples::default(),
            planner: MissionPlanner::default(),
        })
    }

    /// Sets other options: on disk before a mission plan of them is published.
    fn set_requested(&mut self, requested: RequestedOptions) -> Result<Done, Failure> {
        let options = options_of(self.configured.as_deref(), &requested)?;
        if let Some(site) = self.samples.site() {
            check_names(&site.view(), &options)?;
        }
        self.check_start(&options)?;
        self.state.save(&requested)?;
        (self.requested, self.options) = (requested, options);
        self.plan()
    }

    /// Refuses a start that the robot could have and where it cannot stand, on the maps that are there.
    fn check_start(&self, options: &MissionPlanOptions) -> Result<(), Failure> {
        let (Some(start), Some(set)) = (options.start, self.samples.set()) else { return Ok(()) };
        let SiteViews { site, state, index, grids, .. } = set.views()?;
        let input = MissionPlanInput { site: &site, schedule_state: &state, index: &index, grids: &grids, options };
        waypoints::check_start(&input, start)?;
        Ok(())
    }

    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        let options = options_of(config.waypoints.options.as_deref(), &self.requested)?;
        self.configured.clone_from(&config.waypoints.options);
        if options == self.options {
            return Ok(Done::default());
        }
        self.options = options;
        self.plan()
    }

    /// Plans for the newest samples, if they belong together.
    fn plan(&mut self) -> Result<Done, Failure> {
        for subscriber in &self.grids {
            if let Some(sample) = subscriber.take()? {
                SiteSample::check(sample)?.into_iter().for_each(|grid| self.samples.insert(grid));
            }
        }
        let Some(set) = self.samples.set() else { return Ok(Done::default()) };
        let SiteViews { site, state, index, grids, .. } = set.views()?;
        check_names(&site, &self.options)?;
        self.activity.set(Activity::Writing);
        let begun = Instant::now();
        let input = MissionPlanInput {
            site: &site,
            schedule_state: &state,
            index: &index,
            grids: &grids,
            options: &self.options,
        };
        let mission_plan = Checked::new(self.planner.plan(&input))?;
        let inputs = InputHashes {
            site: site.content_hash(),
            schedule_state: state.content_hash(),
            grids: index.content_hash(),
            robot: set.index.bytes().header().inputs.robot,
            ..InputHashes::default()
        };
        self.output.publish(&mut self.epochs, mission_plan, set.site.bytes().header().frame_epoch, inputs)?;
        let WaypointFacts { waypoints, scans, .. } = self.facts();
        let elapsed_us = u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX);
        info!(
            service = "waypoint-gen",
            epoch = self.output.epoch(),
            waypoints,
            scans,
            elapsed_us,
            "mission plan published"
        );
        self.activity.set(Activity::Published);
        Ok(self.done())
    }

    fn done(&self) -> Done {
        Done { published: self.output.published(), ..Done::default() }
    }
}

fn options_of(configured: Option<&Path>, requested: &RequestedOptions) -> Result<MissionPlanOptions, Failure> {
    let file = requested.options.as_deref().or(configured);
    let mut options = file.map_or_else(
        || Ok(MissionPlanOptions::default()),
        |path| daemon::read_parsed("options of waypoints", path, MissionPlanOptions::parse),
    )?;
    if !requested.spaces.is_empty() {
        options.spaces.clone_from(&requested.spaces);
    }
    options.changed_since_s = requested.changed_since_s.or(options.changed_since_s);
    Ok(options)
}

impl Service for WaypointService {
    type Input = WaypointInput;
    type Request = WaypointRequest;
    type Facts = WaypointFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // Samples belong to a generation of the bus that is gone; they come again.
        self.samples = SiteSamples::default();
        let slots = GridSlot::all().map(TopicName::Grid);
        self.grids = slots.map(|slot| bus.raw_subscriber(slot)).collect::<Result<_, _>>()?;
        self.output.attach(bus, &mut self.epochs)
    }

    fn handle(&mut self, event: Event<WaypointInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(input) => {
                self.samples.insert(match input {
                    WaypointInput::Site(site) => SiteSample::Site(site),
                    WaypointInput::ScheduleState(state) => SiteSample::ScheduleState(state),
                    WaypointInput::Grids(index) => SiteSample::Index(index),
                });
                self.plan()
            }
            Event::Configuration(config) => self.configure(&config),
            Event::Tick if self.output.is_pending() => {
                self.output.retry(&mut self.epochs)?;
                self.activity.set(Activity::Published);
                Ok(self.done())
            }
            Event::Attached | Event::Tick => Ok(Done::default()),
        }
    }

    fn answer(&mut self, request: WaypointRequest, _asked: &Asked) -> Result<Done<Published>, Failure> {
        let WaypointRequest::SetWaypoints { options, spaces, changed_since_s } = request;
        Ok(self.set_requested(RequestedOptions { options, spaces, changed_since_s })?.answered_by_published())
    }

    fn facts(&self) -> WaypointFacts {
        let last = self.output.last().map(Checked::view);
        WaypointFacts {
            mission_plan: self.output.published(),
            grids_hash: self.output.inputs().grids,
            waypoints: last.as_ref().map_or(0, |plan| plan.waypoints.len()),
            scans: last.as_ref().map_or(0, |plan| plan.storeys.iter().map(|storey| storey.n_scans).sum()),
        }
    }
}
