//! The waypoint-gen service: replans the storeys that new grids change.

use crate::options_setting::{self, WaypointOptions};
use bus::{Bus, GridSlot, RawSubscriber, SiteSample, SiteSamples, SiteViews, TopicName, topics};
use daemon::facts::WaypointFacts;
use daemon::{
    Asked, Caller, CurrentActivity, Done, Epochs, Event, Failure, History, HistoryEvent, HistoryKind, KeptSetting,
    LatchedOutput, Service, Setting, SiteConfig, Standing, WaypointAnswer, WaypointRequest,
};
use messages::{Activity, Checked, InputHashes};
use std::collections::BTreeSet;
use std::time::Instant;
use tracing::{info, warn};
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner, check_names};

daemon::inputs! {
    /// What waypoints are planned on. The index is published after its grids: they are taken when it comes.
    pub(crate) enum WaypointInput { Site, ScheduleState, Grids }
}

/// Plans for what is published.
pub(crate) struct WaypointService {
    setting: Setting<WaypointOptions>,
    /// What the setting says.
    options: MissionPlanOptions,
    /// A name in the options that the newest site does not have.
    unknown_name: Option<String>,
    history: History,
    epochs: Epochs,
    activity: CurrentActivity,
    output: LatchedOutput<topics::MissionPlan>,
    grids: Vec<RawSubscriber>,
    samples: SiteSamples,
    planner: MissionPlanner,
}

impl WaypointService {
    /// From the configuration and the options that were kept.
    ///
    /// # Errors
    /// Options or state that cannot be used.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let setting = options_setting::open(config)?;
        let service = Self {
            options: setting.value().parse()?,
            setting,
            unknown_name: None,
            history: History::at(&config.state),
            epochs: Epochs::at(&config.state, "waypoint-gen-epochs.json")?,
            activity,
            output: LatchedOutput::new(topics::MissionPlan),
            grids: Vec::new(),
            samples: SiteSamples::default(),
            planner: MissionPlanner::default(),
        };
        if service.setting.was_edited() {
            service.record(None);
        }
        Ok(service)
    }

    /// Plans with other options: tried, on disk, published. What fails leaves everything as it was.
    fn replan(&mut self, tried: KeptSetting<WaypointOptions>) -> Result<Done, Failure> {
        let options = tried.value().parse()?;
        if let Some(site) = self.samples.site() {
            check_names(&site.view(), &options)?;
        }
        self.check_start(&options)?;
        let before = self.setting.keep(tried)?;
        let options = std::mem::replace(&mut self.options, options);
        self.plan().or_else(|why| {
            self.setting.keep(before)?;
            self.options = options;
            // What was in force before is published again as soon as there is room.
            if let Err(again) = self.plan() {
                warn!(service = "waypoint-gen", error = daemon::chain(again.as_ref()), "it is tried again");
            }
            Err(why)
        })
    }

    fn record(&self, by: Option<Caller>) {
        let summary = format!("waypoints of {}", self.setting.value().words());
        if let Err(why) = self.history.record(HistoryEvent { kind: HistoryKind::Waypoints, by, summary }) {
            warn!(service = "waypoint-gen", error = daemon::chain(&why), "the history cannot be written");
        }
    }

    /// Refuses a start that the robot could have and where it cannot stand, on the maps that are there.
    fn check_start(&self, options: &MissionPlanOptions) -> Result<(), Failure> {
        let (Some(start), Some(set)) = (options.start, self.samples.set()) else { return Ok(()) };
        let SiteViews { site, state, index, grids, .. } = set.views()?;
        let input = MissionPlanInput { site: &site, schedule_state: &state, index: &index, grids: &grids, options };
        waypoints::check_start(&input, start)?;
        Ok(())
    }

    /// Takes the edits of the site's file.
    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        let edited = self.setting.edited(options_setting::configured(config))?;
        if edited == self.setting.as_kept() {
            return Ok(Done::default());
        }
        let done = self.replan(edited)?;
        self.record(None);
        Ok(done)
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
        self.unknown_name = check_names(&site, &self.options).err().map(|why| why.to_string());
        if self.unknown_name.is_some() {
            return Ok(Done::default());
        }
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

    fn answer(&mut self, request: WaypointRequest, asked: &Asked) -> Result<Done<WaypointAnswer>, Failure> {
        let WaypointRequest::SetWaypoints { options, spaces, changed_since_s } = request;
        if !spaces.is_empty() && self.samples.site().is_none() {
            return Err("there is no site yet whose spaces could be meant: try again when it is published".into());
        }
        let in_site_toml = self.setting.without_command();
        let tried = if options.is_none() && spaces.is_empty() && changed_since_s.is_none() {
            in_site_toml
        } else {
            let wanted = WaypointOptions::of_command(options, spaces, changed_since_s, in_site_toml.value())?;
            self.setting.commanded(wanted, asked.by.uid)
        };
        let done = self.replan(tried)?;
        self.record(Some(asked.by));
        let setting = self.setting.in_force(WaypointOptions::words);
        // Without maps that belong together there is no mission plan of these options yet.
        let plan = self.output.last().filter(|_| done.published.epoch > 0).map(Checked::view);
        let storeys = plan.iter().flat_map(|plan| plan.waypoints).map(|waypoint| waypoint.map_storey);
        let answer = WaypointAnswer {
            mission_plan: done.published,
            storeys: storeys.collect::<BTreeSet<_>>().len(),
            waypoints: plan.as_ref().map_or(0, |plan| plan.waypoints.len()),
            scans: plan.as_ref().map_or(0, |plan| plan.storeys.iter().map(|storey| storey.n_scans).sum()),
            mission_s: plan.as_ref().map_or(0.0, |plan| plan.head.mission_s.iter().sum()),
            setting,
        };
        Ok(done.answered(answer))
    }

    fn standing(&self) -> Standing {
        Standing { error: self.unknown_name.clone(), warning: self.setting.warning().map(str::to_owned) }
    }

    fn facts(&self) -> WaypointFacts {
        let last = self.output.last().map(Checked::view);
        WaypointFacts {
            mission_plan: self.output.published(),
            grids_hash: self.output.inputs().grids,
            waypoints: last.as_ref().map_or(0, |plan| plan.waypoints.len()),
            scans: last.as_ref().map_or(0, |plan| plan.storeys.iter().map(|storey| storey.n_scans).sum()),
            settings: vec![self.setting.in_force(WaypointOptions::words)],
        }
    }
}
