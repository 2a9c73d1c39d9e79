//! Decisions of rasterize: site and schedule state that are drawn together, the robot, the resolution.
//!
//! A schedule state is drawn with the site whose content hash is its `site_hash`: the newest, or the one that is drawn. The index comes
//! after all grids that it names (`outputs.rs`).

use crate::drawing_settings::DrawingSettings;
use crate::outputs::{Drawing, Drawn, GridOutputs, Pair, Prepared, Which};
use bus::{Bus, CheckedSample, GridSlot, topics};
use daemon::facts::RasterizeFacts;
use daemon::{
    Asked, Caller, Committed, CurrentActivity, Decide, Decision, Epochs, Failure, HistoryEvent, HistoryKind, Now,
    Occasion, RasterizeAnswer, RasterizeRequest, Save, SiteConfig, Standing, state_files,
};
use messages::{Activity, ContentHash, ScheduleStateHead};
use raster::Rasterizer;
use std::sync::Arc;

daemon::inputs! {
    /// What grids are made from.
    pub enum RasterizeInput { Site, ScheduleState }
}

/// Makes grids for one robot at one resolution.
pub struct Rasterize {
    in_force: InForce,
    activity: CurrentActivity,
    /// Site and schedule state that are drawn.
    drawn: Option<(CheckedSample<topics::Site>, CheckedSample<topics::ScheduleState>)>,
    /// Newer ones; until they belong together and are drawn, what is drawn stays: a revision takes effect as a whole.
    newest_site: Option<CheckedSample<topics::Site>>,
    newest_state: Option<CheckedSample<topics::ScheduleState>>,
}

/// What a decision changes.
#[derive(Clone)]
pub struct InForce {
    settings: Arc<DrawingSettings>,
    /// The site that cannot be drawn for this robot.
    undrawable: Option<Arc<Undrawable>>,
    /// What is drawn from then on.
    drawn: Which,
}

/// A site that cannot be drawn, and why.
struct Undrawable {
    site: ContentHash,
    why: String,
}

impl Rasterize {
    /// The daemon on this machine, from the configuration and the settings that were kept.
    ///
    /// # Errors
    /// A robot profile, a resolution or state that cannot be used.
    pub fn start(config: &SiteConfig, activity: CurrentActivity) -> Result<Committed<Self>, Failure> {
        let settings = DrawingSettings::open(&config.state, &config.robot)?;
        let epochs = Epochs::at(&config.state, state_files::GRID_EPOCHS)?;
        let edit = settings.were_edited().then(|| event(&settings, None));
        let in_force = InForce { settings: Arc::new(settings), undrawable: None, drawn: Which::Drawn };
        let shared = activity.clone();
        let service = Self { in_force, activity: shared, drawn: None, newest_site: None, newest_state: None };
        let committed = Committed::new(service, GridOutputs::default(), epochs, &config.state, activity);
        Ok(committed.recording(edit.into_iter().collect()))
    }

    /// What draws a site with these settings, if the outputs have none.
    ///
    /// # Errors
    /// A site that cannot be drawn so.
    fn prepared(
        &self,
        pair: Pair<'_>,
        settings: &DrawingSettings,
        outputs: &GridOutputs,
    ) -> Result<Option<Box<Prepared>>, Failure> {
        let site = pair.site.content_hash();
        if outputs.can_draw(site, settings) {
            return Ok(None);
        }
        self.activity.set(Activity::Reading);
        let rasterizer = Rasterizer::new(&pair.site.view(), &settings.robot().profile, settings.resolution_m())?;
        let n = rasterizer.n_storeys();
        if n > GridSlot::COUNT {
            return Err(format!("the site has {n} map storeys, the bus has room for {}", GridSlot::COUNT).into());
        }
        Ok(Some(Box::new(Prepared::new(site, settings, rasterizer))))
    }

    /// Draws the newest site and schedule state, if they belong together, and what is drawn otherwise, with the settings of the
    /// decision.
    ///
    /// # Errors
    /// What is drawn cannot be drawn so.
    fn draw(&self, decision: &mut Decision<Self>, outputs: &GridOutputs) -> Result<(), Failure> {
        let settings = &decision.next.settings;
        if let Some(newest) = self.pair(Which::Newest) {
            match self.prepared(newest, settings, outputs) {
                Ok(prepared) => {
                    let drawing = Drawing { of: Which::Newest, settings: Arc::clone(settings), prepared };
                    decision.publish.push(drawing);
                    (decision.next.undrawable, decision.next.drawn) = (None, Which::Newest);
                    return Ok(());
                }
                Err(why) => {
                    let (site, why) = (newest.site.content_hash(), daemon::chain(why.as_ref()));
                    decision.next.undrawable = Some(Arc::new(Undrawable { site, why }));
                }
            }
        }
        if let Some(drawn) = self.pair(Which::Drawn).filter(|_| !settings.draw_alike(self.settings())) {
            let prepared = self.prepared(drawn, settings, outputs)?;
            decision.publish.push(Drawing { of: Which::Drawn, settings: Arc::clone(settings), prepared });
        }
        Ok(())
    }

    /// Draws a site and a schedule state that belong together and are not drawn yet.
    fn look(&self, decision: &mut Decision<Self>, outputs: &GridOutputs) -> Result<(), Failure> {
        let Some(newest) = self.pair(Which::Newest) else { return Ok(()) };
        let site = newest.site.content_hash();
        if self.in_force.undrawable.as_ref().is_some_and(|undrawable| undrawable.site == site) {
            return Ok(());
        }
        self.draw(decision, outputs)
    }

    /// Takes other settings.
    fn set(
        &self,
        decision: &mut Decision<Self>,
        (settings, saves): (DrawingSettings, Vec<Save>),
        by: Option<Caller>,
        outputs: &GridOutputs,
    ) -> Result<(), Failure> {
        decision.save = saves;
        let is_other = !settings.draw_alike(self.settings());
        decision.next.settings = Arc::new(settings);
        if is_other || by.is_some() {
            self.draw(decision, outputs)?;
            decision.history.push(event(&decision.next.settings, by));
        }
        Ok(())
    }

    /// What a client is told once the robot is another.
    fn answer(&self, now: &Now<'_, Self>) -> RasterizeAnswer {
        let settings = self.settings();
        RasterizeAnswer {
            grids: now.outputs.last().grids,
            robot: settings.robot_summary(),
            resolution_m: settings.resolution_m(),
            setting: settings.robot_in_force(),
        }
    }
}

impl Drawn for Rasterize {
    fn pair(&self, which: Which) -> Option<Pair<'_>> {
        let drawn = self.drawn.as_ref().map(|(site, state)| Pair { site, state });
        if which == Which::Drawn {
            return drawn;
        }
        let state = self.newest_state.as_ref()?;
        let sites = self.newest_site.iter().chain(drawn.map(|drawn| drawn.site));
        let mut fitting = sites.filter(|site| site.content_hash() == state.view().head.site_hash);
        // Another site is here: the one of this state will come.
        fitting.next().map(|site| Pair { site, state })
    }

    fn settings(&self) -> &DrawingSettings {
        &self.in_force.settings
    }
}

/// What the history says of settings that come into force.
fn event(settings: &DrawingSettings, by: Option<Caller>) -> HistoryEvent {
    let (robot, resolution_m) = (settings.robot_summary(), settings.resolution_m());
    let from = settings.robot_in_force().value;
    HistoryEvent { kind: HistoryKind::Robot, by, summary: format!("{robot} ({from}), at {resolution_m} m a cell") }
}

impl Decide for Rasterize {
    type Input = RasterizeInput;
    type Request = RasterizeRequest;
    type Facts = RasterizeFacts;
    type InForce = InForce;
    type Outputs = GridOutputs;

    fn take(&mut self, input: RasterizeInput) {
        match input {
            RasterizeInput::ScheduleState(state) => self.newest_state = Some(state),
            RasterizeInput::Site(site) => match &mut self.drawn {
                // Its producer repeats itself.
                Some((drawn, _)) if drawn.content_hash() == site.content_hash() => {
                    (*drawn, self.newest_site) = (site, None);
                }
                _ => self.newest_site = Some(site),
            },
        }
    }

    fn attach(&mut self, _: &Bus) -> Result<(), Failure> {
        (self.drawn, self.newest_site, self.newest_state) = (None, None, None);
        Ok(())
    }

    fn decide(&self, occasion: Occasion<'_, RasterizeRequest>, now: &Now<'_, Self>) -> Result<Decision<Self>, Failure> {
        let mut decision = Decision::of(InForce { drawn: Which::Drawn, ..self.in_force.clone() });
        match occasion {
            Occasion::Look => self.look(&mut decision, now.outputs)?,
            Occasion::Configuration(config) => {
                self.set(&mut decision, self.settings().edited(&config.robot)?, None, now.outputs)?;
            }
            Occasion::Request(RasterizeRequest::SetRobot { profile }, Asked { by, .. }) => {
                let commanded = self.settings().commanded(profile, by.uid)?;
                self.set(&mut decision, commanded, Some(*by), now.outputs)?;
                return Ok(decision.answered(Self::answer));
            }
        }
        Ok(decision)
    }

    fn become_in_force(&mut self, next: InForce) {
        if next.drawn == Which::Newest
            && let Some(state) = self.newest_state.take()
        {
            let drawn = self.drawn.take().map(|(site, _)| site);
            let of_state = |site: &CheckedSample<topics::Site>| site.content_hash() == state.view().head.site_hash;
            let site = self.newest_site.take_if(|site| of_state(site)).or(drawn.filter(of_state));
            self.drawn = site.map(|site| (site, state));
        }
        self.in_force = next;
    }

    fn standing(&self, _: &Now<'_, Self>) -> Standing {
        let error = self.in_force.undrawable.as_ref().map(|undrawable| undrawable.why.clone());
        Standing { error, warning: self.settings().warning().map(str::to_owned) }
    }

    fn facts(&self, now: &Now<'_, Self>) -> RasterizeFacts {
        let (last, settings) = (now.outputs.last(), self.settings());
        let [site_epoch, state_epoch] = last.epochs;
        // Its producer may have repeated it since.
        let site = self.drawn.as_ref().map(|(site, _)| site).filter(|site| site.content_hash() == last.inputs.site);
        RasterizeFacts {
            grids: last.grids,
            plan_time_s: Some(last.plan_time_s).filter(|at_s| *at_s != ScheduleStateHead::NO_TIME),
            site_hash: last.inputs.site,
            site_epoch: site.map_or(site_epoch, |site| site.bytes().header().epoch),
            state_epoch,
            state_hash: last.inputs.schedule_state,
            storeys: now.outputs.n_storeys(),
            robot: settings.robot().name.clone(),
            resolution_m: settings.resolution_m(),
            settings: settings.in_force(),
        }
    }
}
