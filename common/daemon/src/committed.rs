//! Decisions carried out in one order: disk, bus, in force, history, answer. A step that fails undoes those before it: each output
//! publishes again what it had before ([`Outputs::go_back`]), files get back what they held.
//!
//! # Where disk or shared memory is full
//!
//! - Nothing changes: files and samples of the decision are taken back, but for derived files ([`Save::derived`]), and what was in force stays.
//! - A request is refused, with the bytes of shared memory that it wants and that are free, or the file that cannot be written; nothing
//!   tries it again, but `ifc-ingest` files of the site, or the first ones, that were to take effect.
//! - What nobody asked for stands in the status, and is decided again at the next look, with each heartbeat; `ifc-ingest`, which would
//!   read the files again, waits 10 s, then twice as long each time, up to 10 minutes ([`Decide::not_committed`]).
//! - What may come later than it is in force is [pending](crate::OutputEnd::is_pending), and is published before the next look decides
//!   anything: the site of `ifc-ingest`, observed progress for `schedule-eval`, all of a new generation of the bus, and what comes back.
//! - The history loses a line, and the log says so; a heartbeat that finds no room is left out.
//! - A date for which `schedule-eval` had room is in force, also where `rasterize` has none: the old maps stay, robots hold a second
//!   after the new schedule state came (`site-view`), `groundplan date` fails with both facts, and `rasterize` tries again with each
//!   heartbeat. Some grids may be out then while the index is of those before.
//! - SLAM maps of `ros-bridge` are published outside of decisions: it warns, and tries the newest map again at each tick.

use crate::decision::{AnswerTo, Decide, Decision, Now, Occasion, Outputs, PublicationsOf};
use crate::failure::{Failure, chain};
use crate::history::{History, HistoryEvent};
use crate::machine_time::{Clock, MachineClock};
use crate::request::{Published, Request};
use crate::save::Save;
use crate::service::{Asked, CurrentActivity, Done, Event, Service, Standing};
use crate::state::{Epochs, StateError};
use bus::Bus;
use messages::Activity;
use std::path::Path;
use tracing::warn;

/// The disk of a daemon.
pub trait Disk: Send {
    /// Writes a state file; when this returns it is on disk.
    ///
    /// # Errors
    /// The file system refuses; what was saved before stays.
    fn write(&mut self, save: &Save) -> Result<(), StateError>;

    /// Writes what a state file held before a decision that fails.
    ///
    /// # Errors
    /// As [`Self::write`].
    fn take_back(&mut self, save: &Save) -> Result<(), StateError> {
        self.write(save)
    }

    /// Appends to the history.
    ///
    /// # Errors
    /// The file system refuses.
    fn record(&mut self, event: HistoryEvent) -> Result<(), StateError>;
}

/// The file system of the machine.
#[derive(Debug)]
pub struct StateFolder {
    history: History,
}

impl StateFolder {
    /// A state folder.
    pub fn at(state: &Path) -> Self {
        Self { history: History::at(state) }
    }
}

impl Disk for StateFolder {
    fn write(&mut self, save: &Save) -> Result<(), StateError> {
        save.write()
    }

    fn record(&mut self, event: HistoryEvent) -> Result<(), StateError> {
        self.history.record(event)
    }
}

/// A daemon that decides, and what carries its decisions out.
pub struct Committed<D: Decide> {
    decider: D,
    outputs: D::Outputs,
    epochs: Epochs,
    disk: Box<dyn Disk>,
    clock: Box<dyn Clock>,
    activity: CurrentActivity,
    /// What a client is told that has waited for it.
    late_answer: Option<Result<AnswerTo<D>, Failure>>,
}

impl<D: Decide> Committed<D> {
    /// On the disk and with the clock of this machine.
    pub fn new(decider: D, outputs: D::Outputs, epochs: Epochs, state: &Path, activity: CurrentActivity) -> Self {
        let (disk, clock) = (Box::new(StateFolder::at(state)), Box::new(MachineClock::of_this_boot()));
        Self { decider, outputs, epochs, disk, clock, activity, late_answer: None }
    }

    /// The same on another disk, with another clock.
    #[must_use]
    pub fn driven_by(mut self, disk: Box<dyn Disk>, clock: Box<dyn Clock>) -> Self {
        (self.disk, self.clock) = (disk, clock);
        self
    }

    /// What is there at the start of the process is told to people, without any other effect.
    #[must_use]
    pub fn recording(mut self, events: Vec<HistoryEvent>) -> Self {
        self.record(events);
        self
    }

    fn now(&self) -> Now<'_, D> {
        Now { machine: self.clock.now(), outputs: &self.outputs }
    }

    /// Decides and commits. What is told as published is the last sample of the main topic, if one was published or a client asked.
    fn act(&mut self, occasion: Occasion<'_, D::Request>) -> Result<Done<Option<AnswerTo<D>>>, Failure> {
        let is_asked = matches!(occasion, Occasion::Request(..));
        let before = self.outputs.published();
        self.decider.gather()?;
        let decision = self.decider.decide(occasion, &self.now())?;
        let Decision { save, publish, next, history, answer, wake_in } = decision;
        if let Err(why) = self.commit(&save, publish) {
            let told = chain(why.as_ref());
            self.decider.not_committed(next, &told, self.clock.now());
            if answer.is_some() && !is_asked {
                self.late_answer = Some(Err(told.into()));
            }
            return Err(why);
        }
        self.decider.become_in_force(next);
        self.record(history);
        let mut answer = answer.map(|answer| answer(&self.decider, &self.now()));
        let is_news = answer.is_some() || self.outputs.published() != before;
        let published = if is_news { self.outputs.published() } else { Published::default() };
        if !is_asked && answer.is_some() {
            self.late_answer = answer.take();
        }
        Ok(Done { answer: answer.transpose()?, published, wake_in })
    }

    /// Writes and publishes all, or leaves disk and bus as they were.
    fn commit(&mut self, saves: &[Save], publications: PublicationsOf<D>) -> Result<(), Failure> {
        let way_back = self.save(saves)?;
        if publications.is_empty() {
            return Ok(());
        }
        self.activity.set(Activity::Writing);
        for publication in publications {
            if let Err(why) = self.outputs.publish(publication, &self.decider, &mut self.epochs) {
                self.outputs.go_back(&self.decider, &mut self.epochs);
                return Err(self.undone(way_back, why));
            }
        }
        self.outputs.settle();
        self.activity.set(Activity::Published);
        Ok(())
    }

    /// Writes files; the answer goes back to what they held, the last one first.
    fn save(&mut self, saves: &[Save]) -> Result<Vec<Save>, Failure> {
        let mut way_back = Vec::new();
        for save in saves {
            let written = save.way_back().and_then(|back| self.disk.write(save).map(|()| back));
            match written {
                Ok(Some(back)) => way_back.insert(0, back),
                Ok(None) => {}
                Err(why) => return Err(self.undone(way_back, why.into())),
            }
        }
        Ok(way_back)
    }

    /// The failure of a step, once what was saved before it is taken back.
    fn undone(&mut self, way_back: Vec<Save>, why: Failure) -> Failure {
        for save in way_back {
            if let Err(again) = self.disk.take_back(&save) {
                let (why, again) = (chain(why.as_ref()), chain(&again));
                return format!("{why}; and what was saved for it cannot be taken back: {again}").into();
            }
        }
        why
    }

    fn record(&mut self, events: Vec<HistoryEvent>) {
        for event in events {
            if let Err(why) = self.disk.record(event) {
                warn!(service = D::Request::DAEMON.name(), error = chain(&why), "the history cannot be written");
            }
        }
    }

    /// Looks whether anything is to be done, after what waits for room. What has no room yet keeps nothing else from being done.
    fn look(&mut self) -> Result<Done, Failure> {
        let late = self.outputs.retry(&self.decider, &mut self.epochs);
        let done = self.act(Occasion::Look)?.answered(());
        if done.published.epoch != 0 {
            // What still waits is tried again at the next look, and told then.
            return Ok(done);
        }
        if late? {
            self.activity.set(Activity::Published);
            return Ok(Done { published: self.outputs.published(), ..done });
        }
        Ok(done)
    }
}

impl<D: Decide> Service for Committed<D> {
    type Input = D::Input;
    type Request = D::Request;
    type Facts = D::Facts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.decider.attach(bus)?;
        self.outputs.attach(bus, &mut self.epochs)
    }

    fn handle(&mut self, event: Event<D::Input>) -> Result<Done, Failure> {
        match event {
            Event::Input(input) => {
                self.decider.take(input);
                self.look()
            }
            Event::Attached | Event::Tick => self.look(),
            Event::Configuration(config) => Ok(self.act(Occasion::Configuration(&config))?.answered(())),
        }
    }

    fn answer(&mut self, request: D::Request, asked: &Asked) -> Result<Done<Option<AnswerTo<D>>>, Failure> {
        self.act(Occasion::Request(request, asked))
    }

    fn late_answer(&mut self) -> Option<Result<AnswerTo<D>, Failure>> {
        self.late_answer.take()
    }

    fn standing(&self) -> Standing {
        self.decider.standing(&self.now())
    }

    fn facts(&self) -> D::Facts {
        self.decider.facts(&self.now())
    }
}
