//! Daemons that decide: what is to be in force, on disk and on the bus is said, and carried out by one loop.

use crate::config::SiteConfig;
use crate::failure::Failure;
use crate::history::HistoryEvent;
use crate::input::Input;
use crate::machine_time::MachineTime;
use crate::request::{Published, Request};
use crate::save::Save;
use crate::service::{Asked, Standing};
use crate::state::Epochs;
use bus::Bus;
use serde::Serialize;
use smallvec::SmallVec;
use std::time::Duration;

/// The rules of a daemon. They write and publish nothing that has to be undone (a cache they may write): [`crate::Committed`] does, and keeps what is in force as it was
/// if a step of a decision fails. So no rule has a way back of its own, and a whole site of them runs in one test.
pub trait Decide: Send {
    /// Topics whose newest samples it gets.
    type Input: Input;
    /// The requests that it takes; they name the daemon.
    type Request: Request;
    /// What it tells of itself beside its heartbeat, see [`crate::facts`].
    type Facts: Serialize;
    /// What is in force: all that a decision changes.
    type InForce: Send;
    /// Its topics.
    type Outputs: Outputs<Self>;

    /// Takes the newest sample of an input. What follows from it is decided afterwards, and again as long as that fails.
    fn take(&mut self, input: Self::Input);

    /// Joins a generation of the bus: samples of inputs belong to one that is gone, and come again.
    ///
    /// # Errors
    /// The bus refuses what is read beside the inputs.
    fn attach(&mut self, bus: &Bus) -> Result<(), Failure>;

    /// Takes what is read beside the inputs, before each decision.
    ///
    /// # Errors
    /// A sample that cannot be taken.
    fn gather(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    /// Decides; the same state, occasion and circumstances give the same decision.
    ///
    /// # Errors
    /// What is asked for cannot be, or cannot be now: everything stays as it is.
    fn decide(&self, occasion: Occasion<'_, Self::Request>, now: &Now<'_, Self>) -> Result<Decision<Self>, Failure>;

    /// Takes what was decided, which is committed.
    fn become_in_force(&mut self, next: Self::InForce);

    /// What was decided could not be committed. It is decided again at the next look; rules whose decisions take long say here that
    /// it is too early for that.
    fn not_committed(&mut self, _next: Self::InForce, _why: &str, _machine: MachineTime) {}

    /// What an operator has to see until it is cured; read after every event and request.
    fn standing(&self, now: &Now<'_, Self>) -> Standing;

    /// Its facts; read after every event and request.
    fn facts(&self, now: &Now<'_, Self>) -> Self::Facts;
}

/// Why something is decided.
pub enum Occasion<'a, R> {
    /// Inputs, files or the time may be others than at the last look.
    Look,
    /// The configuration was read again: what can change while the daemon runs is to be as it says.
    Configuration(&'a SiteConfig),
    /// A client asks.
    Request(R, &'a Asked),
}

/// The circumstances of a decision.
pub struct Now<'a, D: Decide + ?Sized> {
    /// What the machine's clock tells.
    pub machine: MachineTime,
    /// What is on the bus.
    pub outputs: &'a D::Outputs,
}

/// What is decided, in the order in which it is committed: on disk, on the bus, in force, in the history, and as an answer.
pub struct Decision<D: Decide + ?Sized> {
    /// Files of the state folder.
    pub save: Vec<Save>,
    /// Samples; few, and without a place in the heap.
    pub publish: PublicationsOf<D>,
    /// What is in force from then on.
    pub next: D::InForce,
    /// What people are told about it later.
    pub history: Vec<HistoryEvent>,
    /// What the client is told, once all is committed; `None` where nobody asked, or the client has to wait for what a later decision
    /// answers.
    pub answer: Option<AnswerOnce<D>>,
    /// When to look again, if not with the next heartbeat.
    pub wake_in: Option<Duration>,
}

/// Publications of a decision.
pub(crate) type PublicationsOf<D> = SmallVec<[<<D as Decide>::Outputs as Outputs<D>>::Publication; 2]>;

/// Makes the answer of what is committed, which may be a refusal.
pub type AnswerOnce<D> = Box<dyn FnOnce(&D, &Now<'_, D>) -> Result<AnswerTo<D>, Failure> + Send>;

/// What a daemon answers.
pub type AnswerTo<D> = <<D as Decide>::Request as Request>::Answer;

impl<D: Decide> Decision<D> {
    /// Nothing but this comes into force.
    pub fn of(next: D::InForce) -> Self {
        Self { save: Vec::new(), publish: SmallVec::new(), next, history: Vec::new(), answer: None, wake_in: None }
    }

    /// The same, with what a client is told.
    pub fn answered(mut self, answer: impl FnOnce(&D, &Now<'_, D>) -> AnswerTo<D> + Send + 'static) -> Self {
        self.answer = Some(Box::new(move |decider, now| Ok(answer(decider, now))));
        self
    }
}

/// A topic of a daemon, or what else has to follow what is in force.
pub trait OutputEnd {
    /// Joins a generation of the bus. What was published last comes again, at once or as soon as there is room.
    ///
    /// # Errors
    /// The bus refuses.
    fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure>;

    /// What was published last stays.
    fn settle(&mut self);

    /// What was there before the last publication comes back, if that is not settled.
    fn go_back(&mut self, epochs: &mut Epochs);

    /// True while what came last is not published.
    fn is_pending(&self) -> bool;

    /// Publishes what is pending, if there is a bus.
    ///
    /// # Errors
    /// The epoch cannot be kept, or the bus refuses, for instance because shared memory is full; it stays pending.
    fn retry(&mut self, epochs: &mut Epochs) -> Result<(), Failure>;
}

/// The topics of a daemon: what was published last stays until the next is committed, and comes again in every generation of the bus.
pub trait Outputs<D: Decide + ?Sized>: Send {
    /// What can be published.
    type Publication: Send;

    /// Its ends, in the order in which they are published; none where it does itself what follows.
    fn ends(&mut self) -> Vec<&mut dyn OutputEnd> {
        Vec::new()
    }

    /// Opens its ends in a generation of the bus. What was published last comes again: at once, as soon as there is room, or by the
    /// decision that its inputs lead to there.
    ///
    /// # Errors
    /// The bus refuses.
    fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure> {
        self.ends().into_iter().try_for_each(|end| end.attach(bus, epochs))
    }

    /// Publishes.
    ///
    /// # Errors
    /// The bus refuses, for instance because shared memory is full: the decision fails. A topic that may come later than what is in force
    /// refuses nothing, and is [tried again](Self::retry).
    fn publish(&mut self, publication: Self::Publication, decider: &D, epochs: &mut Epochs) -> Result<(), Failure>;

    /// All publications of a decision are out: there is no way back from here.
    fn settle(&mut self) {
        for end in self.ends() {
            end.settle();
        }
    }

    /// What was published before the decision that failed comes back.
    fn go_back(&mut self, _decider: &D, epochs: &mut Epochs) {
        for end in self.ends() {
            end.go_back(epochs);
        }
    }

    /// Publishes what is pending; true if anything was.
    ///
    /// # Errors
    /// As [`Self::publish`]; it stays pending.
    fn retry(&mut self, _decider: &D, epochs: &mut Epochs) -> Result<bool, Failure> {
        let mut is_late = false;
        for end in self.ends() {
            is_late |= end.is_pending();
            end.retry(epochs)?;
        }
        Ok(is_late)
    }

    /// The last sample of its main topic.
    fn published(&self) -> Published;
}
