//! A robot that follows a site, and what a reader of its bus and an operator see of it: that it is what the server published.

use crate::drawn::{N_STOREYS, config};
use crate::published::{Record, shown_set};
use crate::seeds::Violation;
use bus::{Bus, Daemon, GridSlot, RawSubscriber, TopicName};
use messages::ContentHash;
use replica::{IndexClock, PublicKey};
use serde_json::Value;
use site_simulator::replicas::{Follower, RobotClock};
use site_simulator::simulated_store::StoreLink;
use site_simulator::{End, SimulatedClock};
use site_view::SiteSetReader;
use std::path::{Path, PathBuf};

/// A robot, and what a reader of its bus has seen.
pub(crate) struct WatchedFollower {
    pub(crate) follower: Follower,
    /// Places of the storeys that it follows.
    storeys: Vec<usize>,
    sets: SiteSetReader,
    states: RawSubscriber,
    /// Epoch of the newest schedule state, and its hash.
    state: (u64, ContentHash),
    /// It acknowledged an index of this epoch: it shows none before.
    acknowledged: u64,
    /// It acknowledged this list of keys.
    pub(crate) list: u64,
    /// The same as it was on its disk when it started.
    at_start: u64,
    /// Its clock jumped.
    pub(crate) is_clock_wrong: bool,
    /// An archive on its disk is not what it was.
    pub(crate) is_damaged: bool,
    /// Epoch and plan time that it showed last.
    shown: (u64, Option<i64>),
}

impl WatchedFollower {
    /// A robot that does not run, in a folder of this name, which follows these storeys and believes these root keys.
    pub(crate) fn new(
        home: &Path,
        name: &str,
        storeys: Vec<usize>,
        roots: &[PublicKey],
        link: StoreLink,
        clock: &SimulatedClock,
    ) -> Self {
        let roots: Vec<String> = roots.iter().map(PublicKey::to_string).collect();
        let of_storeys = match storeys.len() {
            N_STOREYS => String::new(),
            _ => format!("storeys = {:?}\n", storeys.iter().map(usize::to_string).collect::<Vec<_>>()),
        };
        let synchronised = home.join(format!("{name}-synchronised"));
        std::fs::write(&synchronised, "").unwrap();
        let toml = format!(
            "state = {name:?}\n[clock]\nsynchronised_while = {synchronised:?}\n\
             [follow]\nstore = \"memory\"\nsite = \"tower\"\nroots = {roots:?}\n{of_storeys}"
        );
        let follower = Follower::new(config(&toml, home), link, RobotClock::new(clock.clone()));
        let (sets, states) = Self::readers(&follower);
        let (state, shown) = ((0, ContentHash::NONE), (0, None));
        Self {
            follower,
            storeys,
            sets,
            states,
            state,
            acknowledged: 0,
            list: 0,
            at_start: 0,
            is_clock_wrong: false,
            is_damaged: false,
            shown,
        }
    }

    fn readers(follower: &Follower) -> (SiteSetReader, RawSubscriber) {
        let bus = Bus::in_process(&follower.bus, Daemon::Groundplan);
        (SiteSetReader::of(&bus).unwrap(), bus.raw_subscriber(TopicName::ScheduleState).unwrap())
    }

    /// The keeper of its bus has died: its readers join the next generation, too.
    pub(crate) fn renew_bus(&mut self) -> End<()> {
        let end = self.follower.renew_bus();
        (self.sets, self.states) = Self::readers(&self.follower);
        self.state = (0, ContentHash::NONE);
        end
    }

    /// Something of what it shows is lost on its disk: after a start it shows what is here.
    pub(crate) fn lose_something(&mut self) {
        (self.shown, self.is_damaged) = ((0, None), true);
    }

    /// What its disk has of what it acknowledged, and of how far its clock got.
    pub(crate) fn kept(&self) -> Value {
        let text = std::fs::read(self.follower.state().join("site-follow.json"));
        text.map_or(Value::Null, |text| serde_json::from_slice(&text).unwrap())
    }

    pub(crate) fn synchronised(&self) -> PathBuf {
        let state = self.follower.state();
        let name = format!("{}-synchronised", state.file_name().unwrap().to_string_lossy());
        state.with_file_name(name)
    }

    /// Starts it, if it does not run; it may have forgotten what it acknowledged.
    pub(crate) fn start(&mut self, forgets: bool) -> End<()> {
        if self.follower.is_alive() {
            return End::Done(());
        }
        let state = self.follower.state();
        if forgets {
            for name in ["site-follow.json", "site-follow-index.jsonl"] {
                forget(&state, name);
            }
        }
        self.at_start = self.kept()["acknowledged"]["epoch"].as_u64().unwrap_or(0);
        self.follower.start()
    }

    /// A reader looks at its bus, and an operator at what it tells.
    pub(crate) fn look(&mut self, record: &Record, now_s: i64) -> Result<(), Violation> {
        while let Some(sample) = self.states.take().map_err(|why| daemon::chain(&why))? {
            self.state = (sample.header().epoch, sample.header().content_hash);
        }
        self.sets.take().map_err(|why| daemon::chain(&why))?;
        self.check_order()?;
        if let Some(set) = self.sets.set() {
            set.views().map_err(|why| format!("a set is of two sites: {}", daemon::chain(&why)))?;
            let found = record.indices_of(&set, &self.storeys);
            let Some((newest, _)) = found.last() else {
                return Err("what is shown is of no index that the server published".to_owned());
            };
            if *newest < self.acknowledged {
                return Err(format!("what is shown is of epoch {newest}, {} was acknowledged", self.acknowledged));
            }
        }
        self.check_facts(record, now_s)
    }

    /// What must be known before comes before: states before grids, grids before their index, the index before the mission plan.
    fn check_order(&self) -> Result<(), Violation> {
        let samples = self.sets.samples();
        let Some(index) = samples.index() else { return Ok(()) };
        let (view, header) = (index.view(), index.bytes().header());
        if header.inputs.schedule_state != self.state.1 && self.state.0 < header.epoch {
            return Err("an index of grids comes before its schedule state".to_owned());
        }
        for (slot, named) in view.slots.iter().enumerate() {
            let grid =
                samples.grid(GridSlot::new(slot).unwrap()).map(|grid| (grid.content_hash(), *grid.bytes().header()));
            let (hash, grid) = grid.ok_or("an index comes before a grid that it names")?;
            if hash != named.content_hash && grid.epoch < header.epoch {
                return Err(format!("the index comes before the grid in slot {slot}"));
            }
            if self.state.0 < grid.epoch && self.state.1 != grid.inputs.schedule_state {
                return Err(format!("the grid in slot {slot} comes before its schedule state"));
            }
        }
        let plan = samples.mission_plan().map(|plan| *plan.bytes().header());
        match plan.filter(|plan| plan.inputs.grids != index.content_hash() && plan.epoch > header.epoch) {
            Some(_) => Err("a mission plan comes before the index of its grids".to_owned()),
            None => Ok(()),
        }
    }

    /// What the daemon tells is so.
    fn check_facts(&mut self, record: &Record, now_s: i64) -> Result<(), Violation> {
        let facts = self.follower.process.lock().unwrap().facts();
        let Some(facts) = facts.filter(|facts| facts.epoch > 0) else { return Ok(()) };
        let least = self.acknowledged.max(self.at_start);
        if facts.epoch < least {
            return Err(format!("epoch {} is in force, {least} was acknowledged", facts.epoch));
        }
        let Some(known) = record.indices.get(&facts.epoch) else {
            return Err(format!("epoch {} is in force, which the server has not published", facts.epoch));
        };
        if known.list < self.list {
            return Err(format!("list {} of the keys is in force, {} was acknowledged", known.list, self.list));
        }
        (self.acknowledged, self.list) = (facts.epoch, known.list);
        let schedule = &facts.schedule;
        let Some(set) = shown_set(&known.index, &schedule.state) else {
            return Err(format!("the schedule state in force is not of epoch {}", facts.epoch));
        };
        if (schedule.valid_until_s, schedule.state_plan_time_s) != (set.valid_until_s, set.plan_time_s) {
            return Err(format!("it is said to be valid until {:?}: {set:?}", schedule.valid_until_s));
        }
        // The site's clock is UTC.
        if schedule.next_update_ms.is_some_and(|at_ms| Some(at_ms) != set.valid_until_s.map(|at_s| at_s * 1_000)) {
            return Err(format!("the next set is said to be due at {:?}: {set:?}", schedule.next_update_ms));
        }
        if known.index.clock != IndexClock::ByServer {
            if set.plan_time_s > known.index.sets[0].plan_time_s.max(Some(now_s)) {
                return Err(format!("{:?} is shown, and it is {now_s}", set.plan_time_s));
            }
            if self.shown.0 == facts.epoch && set.plan_time_s < self.shown.1 {
                return Err(format!("the maps go back from {:?} to {:?}", self.shown.1, set.plan_time_s));
            }
        }
        self.shown = (facts.epoch, set.plan_time_s);
        Ok(())
    }

    /// What is on its bus is this set of this index, with its mission plan.
    pub(crate) fn shows(&self, record: &Record, epoch: u64, place: usize) -> Result<(), Violation> {
        let set = self.sets.set().ok_or("what is on the bus does not belong together")?;
        if !record.indices_of(&set, &self.storeys).contains(&(epoch, place)) {
            return Err(format!("what is shown is not set {place} of epoch {epoch}"));
        }
        set.mission_plan.map(drop).ok_or_else(|| "no mission plan is of these maps".to_owned())
    }
}

/// Removes a state file in all of its forms.
pub(crate) fn forget(state: &Path, name: &str) {
    for path in [name.to_owned(), format!("{name}.sealed"), format!("kept/{name}")] {
        let _ = std::fs::remove_file(state.join(path));
    }
}
