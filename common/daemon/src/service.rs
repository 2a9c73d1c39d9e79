//! The `Service` trait: inputs, attachment to the bus, handling of events.

use crate::config::SiteConfig;
use crate::failure::Failure;
use crate::input::Input;
use crate::request::{Answer, Request};
use bus::Bus;
use messages::Stage;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// A daemon's work. All calls come from one thread, one after the other.
pub trait Service: Send {
    /// Topics whose newest samples it gets.
    type Input: Input;

    /// Opens its ends of the bus, on the start and on every new generation of the bus, and publishes its last output
    /// again.
    ///
    /// # Errors
    /// The bus refuses.
    fn attach(&mut self, bus: &Bus) -> Result<(), Failure>;

    /// Answers to something that happened.
    ///
    /// # Errors
    /// What it was asked cannot be done. The error goes to the client and into the heartbeat, and the daemon goes on.
    fn handle(&mut self, event: Event<Self::Input>) -> Result<Done, Failure>;
}

/// Something that happened.
#[derive(Debug)]
pub enum Event<I> {
    /// It is attached to the bus: time to begin what needs no input.
    Attached,
    /// A sample of one of its inputs; older ones were left out.
    Input(I),
    /// A client asks.
    Request(Request),
    /// A heartbeat has passed in which nothing else happened, or the service asked to be woken.
    Tick,
    /// The configuration was read again: what can change while the daemon runs is to be as it says.
    Configuration(Box<SiteConfig>),
}

/// What came of it: the answer for the client that asked, and what is to happen next.
#[derive(Debug, Default)]
pub struct Done {
    /// What counts now.
    pub answer: Answer,
    /// Tick no later than after this time; a heartbeat comes without asking.
    pub wake_in: Option<Duration>,
    /// Something that somebody should know although nothing failed, such as a clock that is not trusted.
    pub warning: Option<String>,
}

/// Where a service says what it is doing.
#[derive(Debug, Clone, Default)]
pub struct Stages(Arc<AtomicU32>);

impl Stages {
    /// From now on.
    pub fn set(&self, stage: Stage) {
        self.0.store(stage as u32, Ordering::Release);
    }

    /// What it said last.
    pub fn get(&self) -> Stage {
        Stage::from_id(self.0.load(Ordering::Acquire)).unwrap_or(Stage::Idle)
    }
}
