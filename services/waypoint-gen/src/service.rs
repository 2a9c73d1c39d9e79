//! The decisions of waypoint-gen: waypoints are planned once per set of maps and options.

use crate::options_setting;
use bus::{Bus, topics};
use daemon::facts::WaypointFacts;
use daemon::{
    Asked, Caller, Committed, CurrentActivity, Decide, Decision, Epochs, Failure, HistoryEvent, HistoryKind,
    KeptSetting, LatchedOutput, NewSample, Now, Occasion, OneTopic, Published, Setting, SiteConfig, Standing,
    WaypointAnswer, WaypointOptions, WaypointRequest, state_files,
};
use messages::{Activity, Checked, InputHashes, payload};
use site_view::{SiteReader, SiteSample, SiteSamples, SiteSet, SiteViews};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use tracing::info;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner, check_names};

daemon::inputs! {
    /// What waypoints are planned on. The index is published after its grids: they are taken before a decision.
    pub enum WaypointInput { Site, ScheduleState, Grids }
}

/// Plans for what is published.
pub struct WaypointGen {
    in_force: InForce,
    activity: CurrentActivity,
    grids: SiteReader,
    samples: SiteSamples,
    /// Keeps plans of storeys: what it plans depends on its input alone.
    planner: Mutex<MissionPlanner>,
}

/// What a decision changes.
#[derive(Clone)]
pub struct InForce {
    setting: Setting<WaypointOptions>,
    /// What the setting says.
    options: Arc<MissionPlanOptions>,
    /// A name in the options that the newest site does not have.
    unknown_name: Option<String>,
    /// The maps that were last planned on with these options, whatever came of it.
    planned_on: Option<InputHashes>,
}

impl WaypointGen {
    /// The daemon on this machine, from the configuration and the options that were kept.
    ///
    /// # Errors
    /// Options or state that cannot be used.
    pub fn start(config: &SiteConfig, activity: CurrentActivity) -> Result<Committed<Self>, Failure> {
        let setting = options_setting::open(config)?;
        let epochs = Epochs::at(&config.state, state_files::MISSION_PLAN_EPOCHS)?;
        let edit = setting.was_edited().then(|| event(setting.value(), None));
        let options = Arc::new(options_setting::parsed(setting.value())?);
        let in_force = InForce { setting, options, unknown_name: None, planned_on: None };
        let service = Self {
            in_force,
            activity: activity.clone(),
            grids: SiteReader::default(),
            samples: SiteSamples::default(),
            planner: Mutex::default(),
        };
        let output = OneTopic(LatchedOutput::new(topics::MissionPlan));
        Ok(Committed::new(service, output, epochs, &config.state, activity).recording(edit.into_iter().collect()))
    }

    /// Plans with the options of the decision, if maps are there that belong together and were not planned on.
    fn plan(&self, decision: &mut Decision<Self>) -> Result<(), Failure> {
        let Some(set) = self.samples.set() else { return Ok(()) };
        let next = &mut decision.next;
        let inputs = inputs_of(&set);
        if next.planned_on == Some(inputs) {
            return Ok(());
        }
        next.planned_on = Some(inputs);
        let SiteViews { site, state, index, grids, .. } = set.views()?;
        next.unknown_name = check_names(&site, &next.options).err().map(|why| why.to_string());
        if next.unknown_name.is_some() {
            return Ok(());
        }
        self.activity.set(Activity::Writing);
        let begun = Instant::now();
        let options = &next.options;
        let input = MissionPlanInput { site: &site, schedule_state: &state, index: &index, grids: &grids, options };
        let mut planner = self.planner.lock().unwrap_or_else(PoisonError::into_inner);
        let archive = Arc::new(Checked::<payload::MissionPlan>::new(planner.plan(&input))?);
        let waypoints = archive.view().waypoints.len();
        let elapsed_us = u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX);
        info!(service = "waypoint-gen", waypoints, elapsed_us, "waypoints planned");
        let frame_epoch = set.site.bytes().header().frame_epoch;
        decision.publish.push(NewSample { archive, frame_epoch, inputs });
        Ok(())
    }

    /// Refuses a start that the robot could have and where it cannot stand, on the maps that are there.
    fn check_start(&self, options: &MissionPlanOptions) -> Result<(), Failure> {
        let (Some(start), Some(set)) = (options.start, self.samples.set()) else { return Ok(()) };
        let SiteViews { site, state, index, grids, .. } = set.views()?;
        let input = MissionPlanInput { site: &site, schedule_state: &state, index: &index, grids: &grids, options };
        waypoints::check_start(&input, start)?;
        Ok(())
    }

    /// Takes other options.
    fn set(
        &self,
        decision: &mut Decision<Self>,
        kept: KeptSetting<WaypointOptions>,
        by: Option<Caller>,
    ) -> Result<(), Failure> {
        let options = options_setting::parsed(kept.value())?;
        if let Some(site) = self.samples.site() {
            check_names(&site.view(), &options)?;
        }
        self.check_start(&options)?;
        decision.save.extend(decision.next.setting.keep(kept)?);
        (decision.next.options, decision.next.planned_on) = (Arc::new(options), None);
        decision.history.push(event(decision.next.setting.value(), by));
        self.plan(decision)
    }

    /// The setting that a request asks for.
    fn requested(&self, request: WaypointRequest, by: Caller) -> Result<KeptSetting<WaypointOptions>, Failure> {
        let WaypointRequest::SetWaypoints { options, spaces, changed_since_s } = request;
        if !spaces.is_empty() && self.samples.site().is_none() {
            return Err("there is no site yet whose spaces could be meant: try again when it is published".into());
        }
        let in_site_toml = self.in_force.setting.without_command();
        if options.is_none() && spaces.is_empty() && changed_since_s.is_none() {
            return Ok(in_site_toml);
        }
        let wanted = WaypointOptions::of_command(
            options,
            spaces,
            changed_since_s,
            in_site_toml.value(),
            MissionPlanOptions::parse,
        )?;
        Ok(self.in_force.setting.commanded(wanted, by.uid))
    }

    /// What a client is told. Without maps that belong together there is no mission plan of its options yet.
    fn answer(&self, now: &Now<'_, Self>, is_planned: bool) -> WaypointAnswer {
        let plan = now.outputs.0.last().filter(|_| is_planned).map(Checked::view);
        let storeys = plan.iter().flat_map(|plan| plan.waypoints).map(|waypoint| waypoint.map_storey);
        WaypointAnswer {
            mission_plan: if is_planned { now.outputs.0.published() } else { Published::default() },
            storeys: storeys.collect::<BTreeSet<_>>().len(),
            waypoints: plan.as_ref().map_or(0, |plan| plan.waypoints.len()),
            scans: plan.as_ref().map_or(0, |plan| plan.storeys.iter().map(|storey| storey.n_scans).sum()),
            mission_s: plan.as_ref().map_or(0.0, |plan| plan.head.mission_s.iter().sum()),
            setting: self.in_force.setting.in_force(WaypointOptions::words),
        }
    }
}

/// What a mission plan on these maps is made from.
fn inputs_of(set: &SiteSet<'_>) -> InputHashes {
    InputHashes {
        site: set.site.content_hash(),
        schedule_state: set.state.content_hash(),
        grids: set.index.content_hash(),
        robot: set.index.bytes().header().inputs.robot,
        ..InputHashes::default()
    }
}

/// What the history says of options that come into force.
fn event(options: &WaypointOptions, by: Option<Caller>) -> HistoryEvent {
    HistoryEvent { kind: HistoryKind::Waypoints, by, summary: format!("waypoints of {}", options.words()) }
}

impl Decide for WaypointGen {
    type Input = WaypointInput;
    type Request = WaypointRequest;
    type Facts = WaypointFacts;
    type InForce = InForce;
    type Outputs = OneTopic<topics::MissionPlan>;

    fn take(&mut self, input: WaypointInput) {
        self.samples.insert(match input {
            WaypointInput::Site(site) => SiteSample::Site(site),
            WaypointInput::ScheduleState(state) => SiteSample::ScheduleState(state),
            WaypointInput::Grids(index) => SiteSample::Index(index),
        });
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.samples = SiteSamples::default();
        self.grids = SiteReader::of_grids(bus)?;
        Ok(())
    }

    fn gather(&mut self) -> Result<(), Failure> {
        Ok(self.grids.take(|grid| self.samples.insert(grid))?)
    }

    fn decide(&self, occasion: Occasion<'_, WaypointRequest>, _: &Now<'_, Self>) -> Result<Decision<Self>, Failure> {
        let mut decision = Decision::of(self.in_force.clone());
        match occasion {
            Occasion::Look => self.plan(&mut decision)?,
            Occasion::Configuration(config) => {
                let edited =
                    decision.next.setting.edited(WaypointOptions::configured(config, MissionPlanOptions::parse))?;
                if edited != self.in_force.setting.as_kept() {
                    self.set(&mut decision, edited, None)?;
                }
            }
            Occasion::Request(request, Asked { by, .. }) => {
                self.set(&mut decision, self.requested(request, *by)?, Some(*by))?;
                let is_planned = !decision.publish.is_empty();
                return Ok(decision.answered(move |service, now| service.answer(now, is_planned)));
            }
        }
        Ok(decision)
    }

    fn become_in_force(&mut self, next: InForce) {
        self.in_force = next;
    }

    fn standing(&self, _: &Now<'_, Self>) -> Standing {
        let InForce { unknown_name, setting, .. } = &self.in_force;
        Standing { error: unknown_name.clone(), warning: setting.warning().map(str::to_owned) }
    }

    fn facts(&self, now: &Now<'_, Self>) -> WaypointFacts {
        let last = now.outputs.0.last().map(Checked::view);
        WaypointFacts {
            mission_plan: now.outputs.0.published(),
            grids_hash: now.outputs.0.inputs().grids,
            waypoints: last.as_ref().map_or(0, |plan| plan.waypoints.len()),
            scans: last.as_ref().map_or(0, |plan| plan.storeys.iter().map(|storey| storey.n_scans).sum()),
            settings: vec![self.in_force.setting.in_force(WaypointOptions::words)],
        }
    }
}
