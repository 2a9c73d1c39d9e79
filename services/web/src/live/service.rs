//! The groundplan-web service: makes documents of the newest maps, and tells browsers what has changed.

use super::live_documents::{MadeSite, date_documents, site_documents};
use super::overlays::{self, Overlays};
use super::shared_site::SharedSite;
use super::watchdog;
use crate::server::{MAX_VIEWERS, Served, router};
use crate::token;
use answers::optional_date_text;
use bus::{Bus, CheckedSample};
use daemon::facts::WebFacts;
use daemon::{Asked, CurrentActivity, Done, Event, Failure, Service, SiteConfig, Standing, WebRequest};
use messages::{Activity, ContentHash};
use serde_json::json;
use site_http::{Access, Listening, ListeningFor, ServerSettings};
use site_view::{SiteReader, SiteSample, SiteSet};
use std::sync::Arc;
use tokio::sync::Semaphore;

daemon::inputs! {
    /// What is shown.
    pub(crate) enum WebInput { Site, Tasks, ScheduleState, Grids, MissionPlan, SlamMap, Alignment, Deviations }
}

/// Shows a site in browsers.
pub(crate) struct WebService {
    config: SiteConfig,
    activity: CurrentActivity,
    shared: Arc<SharedSite>,
    listening: Listening,
    viewers: Arc<Semaphore>,
    grids: SiteReader,
    overlays: Overlays,
    /// What the documents of the site were made of.
    made_of: Option<SiteInputs>,
    instants_s: Vec<i64>,
    /// Index and mission plan that are shown.
    shown: Option<(ContentHash, Option<ContentHash>)>,
    /// Why the newest maps cannot be shown.
    error: Option<String>,
}

/// What the documents of a site depend on: site, tasks, the schedule's dates, and the robot.
#[derive(Debug, Clone, PartialEq)]
struct SiteInputs {
    site: ContentHash,
    tasks: Option<ContentHash>,
    robot: messages::RobotProfile,
    schedule: Vec<u8>,
}

impl WebService {
    /// Listens, now or as soon as its address can be had.
    ///
    /// # Errors
    /// A token that cannot be read.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let web = &config.web;
        let tls = web.certificate.clone().zip(web.key.clone());
        let access: Access = token::access_of(web.listen, &config.site_state, tls.is_some())?;
        let shared = Arc::new(SharedSite::of(config));
        let viewers = Arc::new(Semaphore::new(MAX_VIEWERS));
        let served = Served {
            source: shared.clone(),
            live: Some(shared.clone()),
            access: Arc::new(access),
            viewers: Arc::clone(&viewers),
        };
        let whose = ListeningFor { service: "groundplan-web", what: "page" };
        let router = router(served, tls.is_some());
        let listening = Listening::of(whose, ServerSettings::of(web.listen, tls), router);
        watchdog::watch(config, &shared)?;
        Ok(Self {
            config: config.clone(),
            activity,
            shared,
            listening,
            viewers,
            grids: SiteReader::default(),
            overlays: Overlays::default(),
            made_of: None,
            instants_s: Vec::new(),
            shown: None,
            error: None,
        })
    }

    fn insert(&self, sample: SiteSample) {
        self.shared.samples().insert(sample);
    }

    /// Makes the documents of the newest set, if it belongs together and is not shown.
    fn show(&mut self) -> Result<(), Failure> {
        let shared = Arc::clone(&self.shared);
        let mut samples = shared.samples();
        self.grids.take(|grid| samples.insert(grid))?;
        let Some(set) = samples.set().filter(|set| set.mission_plan.is_some()) else { return Ok(()) };
        let now = (set.index.content_hash(), set.mission_plan.map(CheckedSample::content_hash));
        if self.shown == Some(now) {
            return Ok(());
        }
        self.activity.set(Activity::Writing);
        let result = self.show_set(&set);
        self.error = result.as_ref().err().map(|why| daemon::chain(why.as_ref()));
        self.activity.set(Activity::Published);
        self.shown = Some(now);
        result
    }

    fn show_set(&mut self, set: &SiteSet<'_>) -> Result<(), Failure> {
        let inputs = SiteInputs::of(set);
        if self.made_of.as_ref() != Some(&inputs) {
            let MadeSite { head, site, calendar, tasks, timeline } = site_documents(&self.config, set)?;
            self.instants_s = timeline.as_ref().map(|known| known.instants_s().to_vec()).unwrap_or_default();
            // On a robot it is on the server, and stays there.
            let is_known = timeline.is_some() || self.config.follow.is_some();
            let mut documents = self.shared.documents();
            (documents.site, documents.calendar, documents.tiles) = (Some(site), Some(calendar), Some(head.tiles()));
            documents.tasks = Some(Arc::new(tasks));
            documents.set_schedule(timeline);
            drop(documents);
            // A schedule that is not known may be with the next maps.
            self.made_of = is_known.then_some(inputs);
            self.shared.tell("site", &json!({"site": set.site.content_hash().to_bits().to_string()}));
        }
        let epoch = set.index.bytes().header().epoch;
        let plan = set.mission_plan.map_or(ContentHash::NONE, CheckedSample::content_hash);
        let key = format!("{epoch}-{:08x}", plan.to_bits() as u32);
        let (tiles, tasks) = {
            let documents = self.shared.documents();
            let tiles = documents.tiles.ok_or("there are no tiles yet")?;
            (tiles, documents.tasks.clone().ok_or("there are no tasks yet")?)
        };
        let made = date_documents(&key, &self.config, (&tiles, &tasks), set)?;
        self.shared.documents().add_date(key.clone(), made);
        let at_s = set.state.view().head.plan_time().map(|at| at.civil_seconds());
        let stop_of = |at_s| self.instants_s.partition_point(|instant| *instant <= at_s).saturating_sub(1);
        let stop = at_s.filter(|_| !self.instants_s.is_empty()).map(stop_of);
        self.overlays.on_shown(set.index);
        self.shared.tell("date", &json!({"key": key, "at": at_s.and_then(optional_date_text), "stop": stop}));
        Ok(())
    }
}

impl SiteInputs {
    fn of(set: &SiteSet<'_>) -> Self {
        let state = set.state.view();
        // Dates of all elements: they change with rules, progress and revisions of the plan, and not with the plan time.
        let dates = (0..set.site.view().elements.len()).flat_map(|element| {
            let dates = state.schedule_of(element);
            [dates.start_s, dates.finish_s, dates.removal_start_s, dates.removal_finish_s].map(i64::to_le_bytes)
        });
        Self {
            site: set.site.content_hash(),
            tasks: set.tasks.map(CheckedSample::content_hash),
            robot: set.index.view().head.robot,
            schedule: dates.flatten().collect(),
        }
    }
}

impl Service for WebService {
    type Input = WebInput;
    type Request = WebRequest;
    type Facts = WebFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // Samples belong to a generation of the bus that is gone; they come again.
        *self.shared.samples() = site_view::SiteSamples::default();
        self.shown = None;
        self.overlays.joined();
        self.grids = SiteReader::of_grids(bus)?;
        Ok(())
    }

    fn handle(&mut self, event: Event<WebInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(WebInput::Site(site)) => self.insert(SiteSample::Site(site)),
            Event::Input(WebInput::Tasks(tasks)) => self.insert(SiteSample::Tasks(tasks)),
            Event::Input(WebInput::ScheduleState(state)) => {
                self.overlays.on_schedule_state(&state);
                self.insert(SiteSample::ScheduleState(state));
            }
            Event::Input(WebInput::Grids(index)) => {
                self.overlays.on_index(&index);
                self.insert(SiteSample::Index(index));
            }
            Event::Input(WebInput::MissionPlan(plan)) => self.insert(SiteSample::MissionPlan(plan)),
            Event::Input(WebInput::SlamMap(map)) => self.overlays.on_slam_map(&self.shared, map),
            Event::Input(WebInput::Alignment(alignment)) => self.overlays.on_alignment(&self.shared, alignment),
            Event::Input(WebInput::Deviations(deviations)) => {
                let samples = self.shared.samples();
                let site = samples.site().map(CheckedSample::view);
                if let Some(event) = site.and_then(|site| overlays::deviations(&site, &deviations.view())) {
                    drop(samples);
                    self.shared.tell("deviations", &event);
                }
            }
            Event::Configuration(config) if config.web != self.config.web => {
                return Err("[web] cannot change while groundplan-web runs: restart it".into());
            }
            Event::Configuration(config) => {
                self.config = *config;
                // Rules may have changed.
                (self.made_of, self.shown) = (None, None);
            }
            Event::Tick => {
                self.listening.keep_up();
                self.overlays.tick(&self.shared, &self.config);
                self.shared.set_checked();
            }
            Event::Attached => {}
        }
        self.show()?;
        Ok(Done::default())
    }

    fn answer(&mut self, request: WebRequest, _asked: &Asked) -> Result<Done<Option<()>>, Failure> {
        match request {}
    }

    fn standing(&self) -> Standing {
        let error = self.listening.why_not().map(str::to_owned).or_else(|| self.error.clone());
        Standing { error, warning: None }
    }

    fn facts(&self) -> WebFacts {
        WebFacts {
            url: self.listening.url().map(str::to_owned),
            viewers: MAX_VIEWERS - self.viewers.available_permits(),
        }
    }
}
