//! Planning of waypoints as a daemon: plans again the storeys that new grids change.

use bus::{Bus, GridSlot, Origin, Publisher, Sample, Subscriber, Topic};
use daemon::{Answer, Done, Epochs, Event, Failure, Request, Service, SiteConfig, Stages, StateFile};
use messages::{ArchiveBuffer, Checked, Grid, Grids, InputHashes, Phase, Plan, Stage, payload};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Instant;
use tracing::info;
use waypoints::{PlanInput, PlanOptions, Planner, check_names};

/// Plans for what is published.
pub(crate) struct WaypointService {
    /// Options of the configuration.
    configured: Option<PathBuf>,
    /// What a client asked for.
    asked: Asked,
    options: PlanOptions,
    state: StateFile,
    epochs: Epochs,
    stages: Stages,
    publisher: Option<Publisher>,
    slots: Vec<Subscriber>,
    site: Option<Checked<payload::Site, Sample>>,
    phase: Option<Sample>,
    index: Option<Sample>,
    grids: Vec<Option<Sample>>,
    planner: Planner,
    last: Option<Published>,
    /// True from a change until it is published: what fails for want of room is tried again.
    is_pending: bool,
}

/// What a client asked for goes before the configuration, and survives the daemon.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Asked {
    options: Option<PathBuf>,
    spaces: Vec<String>,
    changed_since_s: Option<i64>,
}

struct Published {
    plan: ArchiveBuffer,
    content_hash: u64,
    origin: Origin,
}

impl WaypointService {
    /// From the configuration and what survived: what a client asked for goes before what is configured.
    ///
    /// # Errors
    /// Options or state that cannot be used.
    pub(crate) fn new(config: &SiteConfig, stages: Stages) -> Result<Self, Failure> {
        let state = StateFile::at(&config.state, "waypoints.json")?;
        let asked: Asked = state.load()?.unwrap_or_default();
        Ok(Self {
            options: options_of(config.waypoints.options.as_deref(), &asked)?,
            configured: config.waypoints.options.clone(),
            asked,
            state,
            epochs: Epochs::at(&config.state, "waypoint-gen-epochs.json")?,
            stages,
            publisher: None,
            slots: Vec::new(),
            site: None,
            phase: None,
            index: None,
            grids: Vec::new(),
            planner: Planner::default(),
            last: None,
            is_pending: false,
        })
    }

    /// Other options: on disk before anybody sees a plan of them.
    fn ask(&mut self, asked: Asked) -> Result<Done, Failure> {
        let options = options_of(self.configured.as_deref(), &asked)?;
        if let Some(site) = &self.site {
            check_names(&site.view(), &options)?;
        }
        self.check_start(&options)?;
        self.state.save(&asked)?;
        (self.asked, self.options) = (asked, options);
        self.plan()
    }

    /// Refuses a start that the robot could have and where it cannot stand, on the maps that are held.
    fn check_start(&self, options: &PlanOptions) -> Result<(), Failure> {
        let (Some(start), Some(site), Some(phase), Some(index)) = (options.start, &self.site, &self.phase, &self.index)
        else {
            return Ok(());
        };
        let (view, phase, index) = (site.view(), Phase::open(phase.bytes())?, Grids::open(index.bytes())?);
        let held = self.grids.iter().take(index.slots.len()).flatten();
        let grids: Vec<Grid<'_>> = held.map(|g| Grid::open(g.bytes())).collect::<Result<_, _>>()?;
        grids.iter().try_for_each(|grid| grid.check_site(&view))?;
        let input = PlanInput { site: &view, phase: &phase, index: &index, grids: &grids, options };
        waypoints::check_start(&input, start)?;
        Ok(())
    }

    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        let options = options_of(config.waypoints.options.as_deref(), &self.asked)?;
        self.configured.clone_from(&config.waypoints.options);
        if options == self.options {
            return Ok(Done::default());
        }
        self.options = options;
        self.plan()
    }

    /// Plans for the newest samples, if they belong together; if not, those that are missing are on their way.
    fn plan(&mut self) -> Result<Done, Failure> {
        for (held, subscriber) in self.grids.iter_mut().zip(&self.slots) {
            if let Some(newer) = subscriber.take()? {
                *held = Some(newer);
            }
        }
        let (Some(site), Some(phase), Some(index)) = (&self.site, &self.phase, &self.index) else {
            return Ok(self.done());
        };
        let hash = |sample: &Sample| sample.header().content_hash;
        let origin = |grids: &Grids<'_>| InputHashes {
            site: grids.head.site_hash,
            phase: grids.head.phase_hash,
            grids: hash(index),
            robot: index.header().inputs.robot,
            ..InputHashes::default()
        };
        let grids = Grids::open(index.bytes())?;
        let slots = || grids.slots.iter().zip(&self.grids);
        let is_here = slots().all(|(slot, held)| held.as_ref().is_some_and(|g| hash(g) == slot.content_hash));
        let is_one_set = grids.head.site_hash == hash(site.bytes())
            && grids.head.phase_hash == hash(phase)
            && grids.slots.len() <= self.grids.len()
            && is_here;
        if !is_one_set {
            return Ok(Done::default());
        }
        check_names(&site.view(), &self.options)?;
        self.stages.set(Stage::Writing);
        self.is_pending = true;
        let begun = Instant::now();
        let (view, phase) = (site.view(), Phase::open(phase.bytes())?);
        phase.check_site(&view)?;
        grids.check_site(&view)?;
        let maps: Vec<Grid<'_>> =
            slots().filter_map(|(_, held)| held.as_ref()).map(|g| Grid::open(g.bytes())).collect::<Result<_, _>>()?;
        maps.iter().try_for_each(|map| map.check_site(&view))?;
        let input = PlanInput { site: &view, phase: &phase, index: &grids, grids: &maps, options: &self.options };
        let plan = self.planner.plan(&input);
        let opened = Plan::open(plan.bytes())?;
        let (content_hash, waypoints, scans) =
            (opened.content_hash(), opened.waypoints.len(), opened.storeys.iter().map(|s| s.n_scans).sum::<u32>());
        let frame_epoch = site.bytes().header().frame_epoch;
        let origin = Origin { epoch: self.epochs.take()?, frame_epoch, inputs: origin(&grids) };
        let publisher = self.publisher.as_ref().ok_or("it is not attached to a bus")?;
        publisher.publish_copy(plan.bytes(), origin)?;
        let elapsed_us = u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX);
        info!(service = "waypoint-gen", epoch = origin.epoch, waypoints, scans, elapsed_us, "plan published");
        self.last = Some(Published { plan, content_hash, origin });
        self.is_pending = false;
        self.stages.set(Stage::Published);
        Ok(self.done())
    }

    fn done(&self) -> Done {
        let (content_hash, epoch) = self.last.as_ref().map_or((0, 0), |last| (last.content_hash, last.origin.epoch));
        Done { answer: Answer { content_hash, epoch, ..Answer::default() }, ..Done::default() }
    }
}

fn options_of(configured: Option<&Path>, asked: &Asked) -> Result<PlanOptions, Failure> {
    let file = asked.options.as_deref().or(configured);
    let mut options = file.map_or_else(
        || Ok(PlanOptions::default()),
        |path| daemon::read_parsed("options of waypoints", path, PlanOptions::parse),
    )?;
    if !asked.spaces.is_empty() {
        options.spaces.clone_from(&asked.spaces);
    }
    options.changed_since_s = asked.changed_since_s.or(options.changed_since_s);
    Ok(options)
}

impl Service for WaypointService {
    fn inputs(&self) -> &'static [Topic] {
        // The index is published after its grids: they are taken when it comes.
        &[Topic::Site, Topic::Phase, Topic::Grids]
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // Samples belong to a generation of the bus that is gone; they come again.
        (self.publisher, self.site, self.phase, self.index) = (None, None, None, None);
        self.slots = GridSlot::all().map(|slot| bus.subscriber(Topic::Grid(slot))).collect::<Result<_, _>>()?;
        self.grids = self.slots.iter().map(|_| None).collect();
        let publisher = bus.publisher(Topic::Plan, self.last.as_ref().map_or(1 << 16, |p| p.plan.bytes().len()))?;
        if let Some(last) = &self.last {
            publisher.publish_copy(last.plan.bytes(), last.origin)?;
        }
        self.publisher = Some(publisher);
        Ok(())
    }

    fn handle(&mut self, event: Event) -> Result<Done, Failure> {
        match event {
            Event::Input(topic, sample) => {
                match topic {
                    Topic::Site => self.site = Some(Checked::new(sample)?),
                    Topic::Phase => self.phase = Some(sample),
                    _ => self.index = Some(sample),
                }
                self.plan()
            }
            Event::Request(Request::SetWaypoints { options, spaces, changed_since_s }) => {
                self.ask(Asked { options, spaces, changed_since_s })
            }
            Event::Request(_) => Err("waypoint-gen plans waypoints and nothing else".into()),
            Event::Configuration(config) => self.configure(&config),
            Event::Tick if self.is_pending => self.plan(),
            Event::Attached | Event::Tick => Ok(Done::default()),
        }
    }
}
