//! Sets that belong together, taken from the bus for the store as soon as every robot of the site has one.

use crate::giver::Giver;
use crate::later_sets::LaterSets;
use crate::pieces::{Piece, RobotPieces, SetKey, SetPieces, SitePieces, StoreyPiece};
use crate::publication::{Job, Publisher, Shared, Surroundings};
use crate::robots;
use crate::robots::{Robots, link_settings, rows_in_force};
use bus::{Bus, RobotName};
use daemon::facts::{ScheduleFacts, ServeFacts};
use daemon::{
    Asked, CurrentActivity, Done, Event, Failure, Report, ServeConfig, ServeRequest, Service, SiteConfig, Standing,
    StatusBoard, UNNAMED_ROBOT, chain, state_files,
};
use messages::{Activity, ContentHash, SampleHeader};
use replica::IndexClock;
use site_view::{SiteSet, SiteSetReader};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// While a newer schedule state has no maps yet, this often is looked for them.
const LOOK_INTERVAL: Duration = Duration::from_millis(100);

daemon::inputs! {
    /// What wakes it; whole sets are read beside it, of each robot.
    pub enum ServeInput { Site, ScheduleState }
}

/// What is missing for so long is told.
const TOLD_AFTER: Duration = Duration::from_secs(5);

/// What is to be done next.
enum Next {
    /// Something is missing.
    Missing(String),
    /// The newest set was given.
    Given,
    /// This is to be given, and is known as this then.
    Job(Box<Job>, (SetKey, IndexClock)),
}

/// Gives what a site has drawn to a store.
pub struct SiteServer {
    config: SiteConfig,
    serve: ServeConfig,
    activity: CurrentActivity,
    /// By the name of the robot in the index.
    readers: Vec<(String, SiteSetReader)>,
    shared: Arc<Shared>,
    robots: Arc<robots::Shared>,
    /// Gives schedule-eval what robots observed; `None` without a link with them.
    giver: Option<Arc<Giver>>,
    /// What was given to the thread last.
    given: Option<(SetKey, IndexClock)>,
    /// Since when something is missing of what is to be given next, and what.
    waits: Option<(Instant, String)>,
    /// Why a sample could not be read at the last look.
    error: Option<String>,
}

impl SiteServer {
    /// The daemon on this machine, and the thread that writes into the store.
    ///
    /// # Errors
    /// Keys or credentials that cannot be used.
    pub fn start(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let serve = config.serve.clone().ok_or("the configuration has no [serve]: nothing is published")?;
        let shared = Arc::new(Shared::default());
        let mut later = LaterSets::default();
        let draw = move |job: &Job, ahead| later.draw(&job.config, &job.site, &job.set, ahead);
        let surroundings = Surroundings::of_machine(&serve, &config.state, Box::new(draw));
        let publisher = Publisher::new(serve.clone(), &config.state, Arc::clone(&shared), surroundings)?;
        std::thread::Builder::new().name("site-server-put".to_owned()).spawn(|| {
            // Maps of this machine do not wait for those of others.
            daemon::in_background();
            publisher.run();
        })?;
        let robots = Arc::new(robots::Shared::default());
        let mut given = None;
        if let Some(link) = &serve.link {
            let document = config.site_state.join(state_files::FLEET);
            let (published, shared) = (Arc::clone(&shared), Arc::clone(&robots));
            let settings = link_settings(&serve, link);
            let giver = Arc::new(Giver::having(rows_in_force(&config.site_state, &link.robots)?));
            let (giving, board) = (Arc::clone(&giver), StatusBoard::of_own(config));
            given = Some(Arc::clone(&giver));
            let thread = Robots::new(&serve, settings, &config.state, document, published, shared, (giver, board))?;
            std::thread::Builder::new().name("site-server-give".to_owned()).spawn(move || giving.run())?;
            std::thread::Builder::new().name("site-server-hear".to_owned()).spawn(|| thread.run())?;
        }
        Ok(Self {
            config: config.clone(),
            serve,
            activity,
            readers: Vec::new(),
            shared,
            robots,
            giver: given,
            given: None,
            waits: None,
            error: None,
        })
    }

    /// Gives the thread the newest set, if every robot has it and it was not given. The answer is when to look again.
    fn publish(&mut self) -> Result<Option<Duration>, Failure> {
        for (_, reader) in &mut self.readers {
            reader.take()?;
        }
        let Some(job) = self.next_job()? else { return Ok(None) };
        match job {
            Next::Missing(what) => {
                let since = self.waits.take().map_or_else(Instant::now, |(since, _)| since);
                self.waits = Some((since, what));
                // Often at first, then with each heartbeat.
                Ok((since.elapsed() < TOLD_AFTER).then_some(LOOK_INTERVAL))
            }
            Next::Given => {
                self.waits = None;
                Ok(None)
            }
            Next::Job(job, given) => {
                self.shared.give(*job);
                (self.given, self.waits) = (Some(given), None);
                self.activity.set(Activity::Published);
                Ok(None)
            }
        }
    }

    /// What is to be given next; `None` before there is any reader.
    fn next_job(&self) -> Result<Option<Next>, Failure> {
        let missing = self.readers.iter().find(|(_, reader)| reader.set().is_none());
        if let Some((name, _)) = missing {
            return Ok(Some(Next::Missing(format!("there are no maps of {name} that belong together"))));
        }
        let sets: Vec<(&String, SiteSet<'_>)> =
            self.readers.iter().filter_map(|(name, reader)| Some((name, reader.set()?))).collect();
        let Some((_, first)) = sets.first() else { return Ok(None) };
        let (site, state) = (first.site.content_hash(), first.state.content_hash());
        let is_same = |set: &SiteSet<'_>| (set.site.content_hash(), set.state.content_hash()) == (site, state);
        if let Some((name, _)) = sets.iter().find(|(_, set)| !is_same(set)) {
            let what = format!("the maps of {name} are of another date than those of {}", sets[0].0);
            return Ok(Some(Next::Missing(what)));
        }

        // How the plan time moves is told beside the bus: it counts once it is told of this state.
        let Some(clock) = clock_of(&StatusBoard::of_own(&self.config), state) else {
            let what = "schedule-eval has not told yet how the plan time moves".to_owned();
            return Ok(Some(Next::Missing(what)));
        };
        let key: SetKey = key_of(first, &sets);
        if self.given.as_ref() == Some(&(key.clone(), clock.clone())) {
            return Ok(Some(Next::Given));
        }
        self.activity.set(Activity::Writing);
        let site = SitePieces {
            site: piece("site", first.site),
            tasks: first.tasks.map(|tasks| piece("tasks", tasks)),
            frame_epoch: first.site.bytes().header().frame_epoch,
            clock: clock.clone(),
        };
        let head = first.state.view().head;
        let robots = sets.iter().map(|(name, set)| ((*name).clone(), robot_pieces(name, set)));
        let set = SetPieces {
            plan_time_s: head.plan_time().map(|at| at.civil_seconds()),
            valid_until_s: messages::plan_time(head.valid_until_s).map(|at| at.civil_seconds()),
            state: piece("schedule-state", first.state),
            robots: robots.collect::<BTreeMap<_, _>>(),
        };
        let job = Job { site, set, config: self.config.clone() };
        Ok(Some(Next::Job(Box::new(job), (key, clock))))
    }
}

/// What identifies what all robots have.
fn key_of(first: &SiteSet<'_>, sets: &[(&String, SiteSet<'_>)]) -> SetKey {
    let of_robot = |(_, set): &(&String, SiteSet<'_>)| {
        let plan = set.mission_plan.map_or(ContentHash::NONE, |plan| plan.content_hash());
        [set.index.content_hash(), plan]
    };
    let of_site = [first.site.content_hash(), first.state.content_hash()];
    let tasks = first.tasks.map(|tasks| tasks.content_hash());
    of_site.into_iter().chain(tasks).chain(sets.iter().flat_map(of_robot)).collect()
}

/// An archive of a topic, from its sample.
pub fn piece<T: bus::Topic>(topic: &str, sample: &bus::CheckedSample<T>) -> Piece {
    Piece::copy_of(topic.to_owned(), sample.content_hash(), sample.as_ref())
}

/// The maps of a robot, from a set of samples.
pub fn robot_pieces(name: &str, set: &SiteSet<'_>) -> RobotPieces {
    let (site, index) = (set.site.view(), set.index.view());
    let topic = |topic: &str| Piece::topic_of(name, topic);
    let header: &SampleHeader = set.index.bytes().header();
    let storeys = index.slots.iter().zip(&set.grids).map(|(slot, grid)| {
        let storey = &site.map_storeys[slot.map_storey as usize];
        let text = site.text(storey.name).to_owned();
        StoreyPiece {
            map_storey: slot.map_storey,
            name: text,
            global_id: site.text(storey.global_id).to_owned(),
            input_hash: grid.bytes().header().inputs.own,
            grid: Piece::copy_of(topic(&format!("grid/{}", slot.map_storey)), slot.content_hash, (**grid).as_ref()),
        }
    });
    RobotPieces {
        grids: Piece::copy_of(topic("grids"), set.index.content_hash(), set.index.as_ref()),
        mission_plan: set
            .mission_plan
            .map(|plan| Piece::copy_of(topic("mission-plan"), plan.content_hash(), plan.as_ref())),
        robot_hash: header.inputs.robot,
        storeys: storeys.collect(),
    }
}

/// How the plan time moves, as schedule-eval says of a schedule state; `None` as long as it does not.
fn clock_of(board: &StatusBoard, state: ContentHash) -> Option<IndexClock> {
    let report: Report<ScheduleFacts> = board.report(bus::Daemon::ScheduleEval)?;
    let facts = Some(report.facts).filter(|facts| facts.state.content_hash == state)?;
    Some(match facts {
        ScheduleFacts { is_wall_clock: true, site_zone: Some(zone), .. } => IndexClock::Wall { zone },
        _ => IndexClock::ByServer,
    })
}

impl Service for SiteServer {
    type Input = ServeInput;
    type Request = ServeRequest;
    type Facts = ServeFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        let names: Vec<Option<RobotName>> = match self.config.robot_names() {
            names if names.is_empty() => vec![None],
            names => names.into_iter().map(Some).collect(),
        };
        if let Some(giver) = &self.giver {
            giver.attach(bus);
        }
        self.readers.clear();
        for name in names {
            let of_robot = match name {
                Some(_) => bus.meaning(name)?,
                None => bus.clone(),
            };
            let text = name.map_or_else(|| UNNAMED_ROBOT.to_owned(), |name| name.to_string());
            self.readers.push((text, SiteSetReader::of(&of_robot)?));
        }
        Ok(())
    }

    fn handle(&mut self, event: Event<ServeInput>) -> Result<Done, Failure> {
        if let Event::Configuration(config) = event {
            if config.serve.as_ref() != Some(&self.serve) {
                return Err("[serve] cannot change while site-server runs: restart it".into());
            }
            // Rules or options of waypoints may be others: later sets are drawn with them.
            (self.config, self.given) = (*config, None);
        }
        // What cannot be read stands until it can.
        let published = self.publish();
        self.error = published.as_ref().err().map(|why| chain(why.as_ref()));
        Ok(Done { wake_in: published.unwrap_or(None), ..Done::default() })
    }

    fn answer(&mut self, request: ServeRequest, _: &Asked) -> Result<Done<Option<()>>, Failure> {
        match request {}
    }

    fn standing(&self) -> Standing {
        let outcome = self.shared.outcome();
        let waits = self.waits.as_ref().filter(|(since, _)| since.elapsed() >= TOLD_AFTER);
        let waits = waits.map(|(_, what)| format!("nothing newer is published: {what}"));
        // How robots are is not how the server is: `groundplan fleet status` tells that.
        let error = self.error.clone().or(outcome.error).or_else(|| self.robots.error());
        Standing { error, warning: waits.or(outcome.warning) }
    }

    fn facts(&self) -> ServeFacts {
        let outcome = self.shared.outcome();
        ServeFacts {
            store: self.serve.store.clone(),
            site: self.serve.site.clone(),
            epoch: outcome.epoch,
            plan_times_s: outcome.plan_times_s,
            new_bytes: outcome.new_bytes,
            why_no_later: outcome.why_no_later,
        }
    }
}

impl Drop for SiteServer {
    fn drop(&mut self) {
        self.shared.stop();
        self.robots.stop();
        if let Some(giver) = &self.giver {
            giver.stop();
        }
    }
}
