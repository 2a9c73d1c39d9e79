//! Schedule evaluation as a daemon: holds the plan time, publishes the phase.

use crate::{Edits, Period, Rules, Timeline, evaluate};
use bus::{Bus, Origin, Publisher, Topic};
use daemon::{Answer, Done, Epochs, Event, Failure, Request, Service, SiteConfig, Stages, StateFile};
use frames::PlanTime;
use messages::{ArchiveBuffer, InputHashes, Phase, Site, Stage};
use tracing::info;

/// Holds the plan time; its file in the state folder is what counts after a restart.
pub struct ScheduleService {
    rules: Rules,
    plan_time: StateFile,
    plan_time_s: Option<i64>,
    epochs: Epochs,
    stages: Stages,
    publisher: Option<Publisher>,
    site: Option<Evaluated>,
    last: Option<(ArchiveBuffer, Origin)>,
}

/// The schedule of the site at hand.
struct Evaluated {
    timeline: Timeline,
    site_hash: u64,
    frame_epoch: u64,
}

impl ScheduleService {
    /// From the configuration and what survived.
    ///
    /// # Errors
    /// Rules, a plan time or state that cannot be used.
    pub fn new(config: &SiteConfig, stages: Stages) -> Result<Self, Failure> {
        let rules = config.schedule.rules.as_ref().map_or(Ok(Rules::default()), |path| -> Result<Rules, Failure> {
            let text = std::fs::read_to_string(path).map_err(|e| format!("rules {}: {e}", path.display()))?;
            Rules::parse(&text).map_err(|e| format!("rules {}: {}", path.display(), daemon::chain(&e)).into())
        })?;
        let first = config.schedule.plan_time.as_deref().map(str::parse::<PlanTime>).transpose()?;
        let plan_time = StateFile::at(&config.state, "plan-time.json")?;
        let plan_time_s = plan_time.load::<i64>()?.or(first.map(PlanTime::civil_seconds));
        let epochs = Epochs::at(&config.state, "schedule-eval-epochs.json")?;
        Ok(Self { rules, plan_time, plan_time_s, epochs, stages, publisher: None, site: None, last: None })
    }

    fn set_plan_time(&mut self, at_s: i64) -> Result<Done, Failure> {
        // On disk before anybody sees it: a map must never go back in time because a process died.
        self.plan_time.save(&at_s)?;
        self.plan_time_s = Some(at_s);
        self.publish()
    }

    fn next_change(&mut self) -> Result<Done, Failure> {
        let site = self.site.as_ref().ok_or("there is no site yet")?;
        let next = |now: i64| site.timeline.instants_s().iter().find(|s| **s > now).copied();
        let next_s = next(self.plan_time_s.unwrap_or(i64::MIN)).ok_or("nothing changes any more")?;
        self.set_plan_time(next_s)
    }

    /// The phase at the plan time, if there is a site.
    fn publish(&mut self) -> Result<Done, Failure> {
        let (Some(site), Some(publisher)) = (&self.site, &self.publisher) else { return Ok(self.done()) };
        self.stages.set(Stage::Writing);
        let phase = match self.plan_time_s {
            Some(at_s) => site.timeline.phase(Period::instant(at_s)),
            None => site.timeline.everything_built(),
        };
        let phase = phase.finish();
        let inputs = InputHashes { site: site.site_hash, ..InputHashes::default() };
        let origin = Origin { epoch: self.epochs.take()?, frame_epoch: site.frame_epoch, inputs };
        publisher.publish_copy(phase.bytes(), origin)?;
        info!(service = "schedule-eval", epoch = origin.epoch, bytes = phase.bytes().len(), "phase published");
        self.last = Some((phase, origin));
        self.stages.set(Stage::Published);
        Ok(self.done())
    }

    fn done(&self) -> Done {
        let (content_hash, epoch) = self.last.as_ref().map_or((0, 0), |(phase, origin)| {
            (Phase::open(phase.bytes()).map_or(0, |p| p.content_hash()), origin.epoch)
        });
        Done { answer: Answer { content_hash, epoch, plan_time_s: self.plan_time_s } }
    }
}

impl Service for ScheduleService {
    fn inputs(&self) -> &'static [Topic] {
        &[Topic::Site]
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.publisher = None;
        let publisher = bus.publisher(Topic::Phase, self.last.as_ref().map_or(1 << 16, |(p, _)| p.bytes().len()))?;
        if let Some((phase, origin)) = &self.last {
            publisher.publish_copy(phase.bytes(), *origin)?;
        }
        self.publisher = Some(publisher);
        Ok(())
    }

    fn handle(&mut self, event: Event) -> Result<Done, Failure> {
        match event {
            Event::Input(_, sample) => {
                self.stages.set(Stage::Reading);
                let site = Site::open(sample.bytes())?;
                let site_hash = site.content_hash();
                if self.site.as_ref().is_some_and(|s| s.site_hash == site_hash) {
                    self.stages.set(Stage::Published);
                    return Ok(Done::default());
                }
                let timeline = evaluate(&site, &self.rules, &Edits::default())?;
                info!(
                    service = "schedule-eval",
                    tasks = site.tasks.len(),
                    changes = timeline.instants_s().len(),
                    "schedule evaluated"
                );
                self.site = Some(Evaluated { timeline, site_hash, frame_epoch: sample.header().frame_epoch });
                self.publish()
            }
            Event::Request(Request::SetPlanTime { at_s }) => self.set_plan_time(at_s),
            Event::Request(Request::NextChange) => self.next_change(),
            Event::Request(_) => Err("schedule-eval holds the plan time and nothing else".into()),
            Event::Attached | Event::Tick => Ok(Done::default()),
        }
    }
}
