//! The running site: its newest samples, and the moment at which a question is answered.

use crate::problem::{Problem, ProblemKind};
use answers::deviations::{SeenDeviations, seen_deviations};
use answers::{AnswerBasis, Circumstances, Epochs, MapUse, Situation, date_text, optional_date_text};
use bus::{CheckedSample, topics};
use daemon::{Robot, SiteConfig, WaypointOptions, chain};
use jiff::Timestamp;
use messages::{ContentHash, MissionPlan};
use schedule::{Period, Timeline};
use schemars::JsonSchema;
use serde::Serialize;
use site_answers::{
    Answer, Drawing, DrawingProgress, KeptRasterizer, Question, circumstances_of, map_use, options_of, period_of,
    situation_of, start_is_known,
};
use site_schedule::{ScheduleInForce, schedule_in_force};
use site_view::{FRESH_TOLERANCE, SiteSample, SiteSamples, SiteSet, SiteViews};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use waypoints::MissionPlanOptions;

/// Time for maps of other dates in an answer: the search for a change ends then.
const DRAWING_TIME: Duration = Duration::from_secs(20);
/// The rasterizer of the last such answer is kept for so long.
const KEEP_RASTERIZER: Duration = Duration::from_secs(300);

/// The newest samples of a site, and what was made of them for the last answers.
pub(crate) struct Site {
    config: Mutex<Arc<SiteConfig>>,
    /// For answers at once, and for those that maps are drawn for.
    lanes: [Samples; 2],
    deviations: Mutex<Option<CheckedSample<topics::Deviations>>>,
    schedule: Mutex<Option<(ScheduleKey, Arc<ScheduleInForce>)>>,
    /// The rasterizer of the last answer that maps were drawn for, and when that was.
    drawing: Mutex<(KeptRasterizer, Instant)>,
    /// When the bus was last looked at.
    looked: Mutex<Option<Instant>>,
}

/// How an answer is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lane {
    /// Of what is published.
    AtOnce = 0,
    /// By drawing maps, which takes its time.
    Drawing = 1,
}

/// Samples for answers of a lane. Whoever answers holds the newest of its moment; so that who takes samples of the bus does not
/// wait for an answer, they come into `pending`.
#[derive(Default)]
struct Samples {
    shown: Mutex<SiteSamples>,
    pending: Mutex<SiteSamples>,
}

impl Samples {
    /// The newest ones.
    fn newest(&self) -> MutexGuard<'_, SiteSamples> {
        let mut shown = locked(&self.shown);
        self.show(&mut shown);
        shown
    }

    /// What has come is shown, if nobody answers.
    fn renew(&self) {
        if let Ok(mut shown) = self.shown.try_lock() {
            self.show(&mut shown);
        }
    }

    fn show(&self, shown: &mut SiteSamples) {
        let mut newest = std::mem::take(&mut *locked(&self.pending));
        newest.take_back(std::mem::take(shown));
        *shown = newest;
    }

    fn forget(&self) {
        *locked(&self.pending) = SiteSamples::default();
        *locked(&self.shown) = SiteSamples::default();
    }
}

/// What a schedule in force is of: the site, its tasks and its state.
type ScheduleKey = [ContentHash; 3];

/// What the running site shows now, beside any answer.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Running {
    /// When this was answered, by the clock of the machine: RFC 3339 in UTC.
    answered_at: String,
    /// Plan time of the maps; null if everything is built.
    plan_time: Option<String>,
    /// Next change of the schedule; null if there is none.
    valid_until: Option<String>,
    /// Epochs of what is published.
    epochs: Epochs,
    /// Whether the maps may be used.
    maps: MapUse,
}

/// A moment of a site, which stays as it is while a question is answered.
pub(crate) struct Moment<'a> {
    pub(crate) config: &'a SiteConfig,
    pub(crate) views: &'a SiteViews<'a>,
    pub(crate) circumstances: Circumstances,
    pub(crate) running: Running,
    schedule: Result<Arc<ScheduleInForce>, String>,
    robot: Robot,
    resolution_m: f64,
    options: MissionPlanOptions,
    has_options: bool,
    site: &'a Site,
}

/// What a lock guards, also after a panic of another thread: values are replaced whole.
fn locked<T>(kept: &Mutex<T>) -> MutexGuard<'_, T> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Site {
    /// A site of which no sample has come.
    pub(crate) fn of(config: &SiteConfig) -> Self {
        Self {
            config: Mutex::new(Arc::new(config.clone())),
            lanes: Default::default(),
            deviations: Mutex::default(),
            schedule: Mutex::default(),
            drawing: Mutex::new((KeptRasterizer::default(), Instant::now())),
            looked: Mutex::default(),
        }
    }

    /// Takes another configuration.
    pub(crate) fn set_config(&self, config: SiteConfig) {
        *locked(&self.config) = Arc::new(config);
        *locked(&self.schedule) = None;
    }

    /// Takes a sample for the answers of a lane.
    pub(crate) fn insert(&self, lane: Lane, sample: SiteSample) {
        locked(&self.lanes[lane as usize].pending).insert(sample);
    }

    /// Takes deviations.
    pub(crate) fn insert_deviations(&self, deviations: CheckedSample<topics::Deviations>) {
        *locked(&self.deviations) = Some(deviations);
    }

    /// The bus was looked at now. What has come is shown as soon as nobody answers; what nobody asks for any more is given up.
    pub(crate) fn looked(&self) {
        *locked(&self.looked) = Some(Instant::now());
        self.lanes.iter().for_each(Samples::renew);
        if let Ok(mut drawing) = self.drawing.try_lock()
            && drawing.1.elapsed() >= KEEP_RASTERIZER
        {
            drawing.0.clear();
        }
    }

    /// Samples belong to a generation of the bus that is gone; they come again.
    pub(crate) fn forget(&self) {
        self.lanes.iter().for_each(Samples::forget);
        *locked(&self.deviations) = None;
    }

    /// Works at this moment of the site.
    ///
    /// # Errors
    /// Those of the work; no maps yet, or archives that cannot be read.
    pub(crate) fn at_this_moment<T>(
        &self,
        lane: Lane,
        work: impl FnOnce(&Moment<'_>) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let config = Arc::clone(&locked(&self.config));
        let samples = self.lanes[lane as usize].newest();
        let set = samples.set().filter(|set| set.has_tasks() && set.mission_plan.is_some());
        let not_yet = || {
            let why = "the daemons have no maps yet, or are at work on newer ones: ask again";
            Problem::of(ProblemKind::NotYet, why)
        };
        let set = set.ok_or_else(not_yet)?;
        let views = set.views().map_err(|why| Problem::of(ProblemKind::Failed, chain(&why)))?;
        work(&self.moment(&config, &set, &views)?)
    }

    fn moment<'a>(
        &'a self,
        config: &'a SiteConfig,
        set: &SiteSet<'_>,
        views: &'a SiteViews<'a>,
    ) -> Result<Moment<'a>, Problem> {
        let SiteViews { site, index, grids, mission_plan, .. } = views;
        let circumstances = circumstances_of(set, views, self.maps(config, set));
        let mission_plan = mission_plan.as_ref().ok_or_else(|| Problem::of(ProblemKind::NotYet, "no waypoints yet"))?;
        let options = options_in_force(config);
        let (has_options, options) = match options {
            Some(options) => (true, options),
            None => (false, options_of(site, mission_plan)),
        };
        Ok(Moment {
            config,
            views,
            running: Running::of(&circumstances, views),
            circumstances,
            schedule: self.schedule(config, set, views),
            robot: Robot::of_index(index),
            resolution_m: grids.first().map_or(config.robot.resolution_m, |grid| grid.spec().resolution_m()),
            options,
            has_options,
            site: self,
        })
    }

    /// Whether the maps of a set may be used now.
    fn maps(&self, config: &SiteConfig, set: &SiteSet<'_>) -> MapUse {
        match *locked(&self.looked) {
            Some(looked) if looked.elapsed() < FRESH_TOLERANCE => {}
            _ => return MapUse::of(Some("groundplan-ask has not looked for newer maps for a while".to_owned())),
        }
        map_use(set, config).unwrap_or_else(|why| MapUse::of(Some(chain(&why))))
    }

    fn schedule(
        &self,
        config: &SiteConfig,
        set: &SiteSet<'_>,
        views: &SiteViews<'_>,
    ) -> Result<Arc<ScheduleInForce>, String> {
        let tasks = set.tasks.map_or(ContentHash::NONE, CheckedSample::content_hash);
        let key = [set.site.content_hash(), tasks, set.state.content_hash()];
        let mut kept = locked(&self.schedule);
        if let Some((_, schedule)) = kept.as_ref().filter(|(known, _)| *known == key) {
            return Ok(Arc::clone(schedule));
        }
        let schedule = schedule_in_force(config, &views.site, &views.state).map_err(|why| chain(&why))?;
        let schedule = Arc::new(schedule);
        *kept = Some((key, Arc::clone(&schedule)));
        Ok(schedule)
    }

    /// The rasterizer: one answer is drawn at a time.
    fn rasterizer(&self) -> MutexGuard<'_, (KeptRasterizer, Instant)> {
        let mut drawing = self.drawing.lock().unwrap_or_else(|poisoned| {
            // A thread panicked while it drew: it is made anew.
            let mut drawing = poisoned.into_inner();
            drawing.0.clear();
            self.drawing.clear_poison();
            drawing
        });
        drawing.1 = Instant::now();
        drawing
    }
}

/// The options of the mission plan that are in force; `None` where they are not known here: on a robot that follows a server, and
/// for users who cannot read the state folder.
fn options_in_force(config: &SiteConfig) -> Option<MissionPlanOptions> {
    if config.follow.is_some() {
        return None;
    }
    let options = WaypointOptions::in_force(config, MissionPlanOptions::parse).ok()?;
    let parsed = options.parse(MissionPlanOptions::parse).ok()?;
    // Of flight waypoints no answer tells; what a command asks for beside the file is about scans alone.
    Some(MissionPlanOptions { flight: None, ..parsed })
}

impl Running {
    fn of(circumstances: &Circumstances, views: &SiteViews<'_>) -> Self {
        Self {
            answered_at: Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string(),
            plan_time: circumstances.plan_time.clone(),
            valid_until: optional_date_text(views.state.head.valid_until_s),
            epochs: circumstances.epochs.unwrap_or(Epochs { site: 0, schedule_state: 0, grids: 0, mission_plan: 0 }),
            maps: circumstances.maps.clone().unwrap_or_else(|| MapUse::of(None)),
        }
    }
}

/// Stops the search for changes when its time is over.
struct Until(Instant);

impl DrawingProgress for Until {
    fn stage(&self, _stage: &'static str) {}

    fn step(&self, _stage: &'static str, _done: usize, _total: usize) -> bool {
        Instant::now() < self.0
    }
}

impl Moment<'_> {
    /// The schedule in force.
    ///
    /// # Errors
    /// That it is not known here, and why.
    pub(crate) fn schedule(&self) -> Result<&ScheduleInForce, Problem> {
        self.schedule.as_deref().map_err(|why| {
            let why = format!("the schedule in force is not known, so that no other date is: {why}");
            Problem::of(ProblemKind::NotKnown, why)
        })
    }

    /// The schedule, where it is known.
    pub(crate) fn timeline(&self) -> Option<&Timeline> {
        self.schedule.as_deref().ok().map(|schedule| &schedule.timeline)
    }

    /// What the robot of these maps saw; `None` if nothing was compared with this site.
    pub(crate) fn seen_deviations(&self) -> Option<SeenDeviations> {
        let deviations = locked(&self.site.deviations);
        deviations.as_ref().and_then(|sample| seen_deviations(&self.views.site, &sample.view()))
    }

    /// The period of a date: a day, or an instant.
    ///
    /// # Errors
    /// A text that is no date; a schedule that is not known.
    pub(crate) fn period(&self, date: &str) -> Result<Period, Problem> {
        Ok(period_of(date, None, self.schedule()?.site_zone.as_ref())?)
    }

    /// The instant of a date: a day counts from its midnight.
    ///
    /// # Errors
    /// As [`Moment::period`].
    pub(crate) fn instant_s(&self, date: &str) -> Result<i64, Problem> {
        Ok(self.period(date)?.from_s)
    }

    /// The situation of the maps that are published.
    pub(crate) fn situation(&self) -> Result<Situation<'_>, Problem> {
        let situation = situation_of(self.views, self.timeline(), &self.circumstances);
        situation.ok_or_else(|| Problem::of(ProblemKind::NotYet, "there are no waypoints yet: ask again"))
    }

    /// The answer to a question, of the maps that are published or at a date; `later`: also when it changes.
    ///
    /// # Errors
    /// Names that stand for nothing or for several things, a date that cannot be used, too many questions.
    pub(crate) fn answer<Q: Question>(
        &self,
        question: &Q,
        date: Option<&str>,
        later: bool,
    ) -> Result<Q::Answer, Problem> {
        let found = question.find(&self.views.site)?;
        let until = Until(Instant::now() + DRAWING_TIME);
        let knows_start = self.has_options || !question.depends_on_start() || self.plan().is_some_and(start_is_known);
        let only_now = match (later, knows_start, &self.schedule) {
            (false, ..) => Some("it was not asked for: `later`".to_owned()),
            (_, false, _) => Some(NO_START.to_owned()),
            (.., Err(why)) => Some(format!("the schedule in force is not known: {why}")),
            _ => None,
        };
        self.draw(only_now.as_deref(), &until, |drawing| {
            if let Some(date) = date {
                if !knows_start {
                    return Err(Problem::of(ProblemKind::NotKnown, NO_START));
                }
                let period = self.period(date)?;
                let mut kept = self.site.rasterizer();
                return Ok(drawing.answer(question, &found, Some(period), &mut kept.0)?);
            }
            let mut answer = question.answer(&self.situation()?, &found);
            if answer.wants_later() {
                let after_s = self.views.state.head.plan_time().map(|at| at.civil_seconds());
                let after_s = after_s.ok_or("everything is built, because the site has no plan time");
                let (mut turn, mut unused) = (None, KeptRasterizer::default());
                let kept = match only_now {
                    None => &mut turn.insert(self.site.rasterizer()).0,
                    Some(_) => &mut unused,
                };
                let changes = drawing.changes(question, &found, (after_s, &answer), &self.circumstances, kept)?;
                answer.set_changes(changes);
            }
            Ok(answer)
        })
    }

    /// Draws maps of other dates.
    pub(crate) fn with_rasterizer<T>(
        &self,
        work: impl FnOnce(&Drawing<'_>, &mut KeptRasterizer) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let until = Until(Instant::now() + DRAWING_TIME);
        let mut kept = self.site.rasterizer();
        self.draw(None, &until, |drawing| work(drawing, &mut kept.0))
    }

    fn draw<T>(
        &self,
        only_now: Option<&str>,
        until: &Until,
        work: impl FnOnce(&Drawing<'_>) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        work(&Drawing {
            site: &self.views.site,
            timeline: self.timeline(),
            robot: &self.robot,
            resolution_m: self.resolution_m,
            options: &self.options,
            basis: AnswerBasis::RunningSiteAtDate,
            only_now,
            progress: until,
        })
    }

    /// The circumstances of what the schedule alone says of a period.
    pub(crate) fn circumstances_at(&self, period: Period) -> Circumstances {
        Circumstances {
            of: AnswerBasis::RunningSiteAtDate,
            plan_time: Some(date_text(period.from_s)),
            plan_until: period.until_s.map(date_text),
            valid_until: self.next_change(period),
            epochs: None,
            maps: None,
            resolution_m: None,
            ..self.circumstances.clone()
        }
    }

    fn next_change(&self, period: Period) -> Option<String> {
        let last_s = period.until_s.map_or(period.from_s, |until_s| until_s - 1);
        let instants_s = self.timeline()?.instants_s();
        instants_s.get(instants_s.partition_point(|at_s| *at_s <= last_s)).map(|at_s| date_text(*at_s))
    }

    fn plan(&self) -> Option<&MissionPlan<'_>> {
        self.views.mission_plan.as_ref()
    }
}

const NO_START: &str = "where the robot starts is not known here, and maps of other dates need it";
