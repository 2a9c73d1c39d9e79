//! The `Service` trait: inputs and requests, attachment to the bus, handling of events, what it tells of itself.

use crate::caller::Caller;
use crate::config::SiteConfig;
use crate::failure::Failure;
use crate::input::Input;
use crate::progress::Reporter;
use crate::request::{Published, Request};
use bus::Bus;
use messages::Activity;
use serde::Serialize;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A daemon's work. All calls come from one thread, one after the other.
pub trait Service: Send {
    /// Topics whose newest samples it gets.
    type Input: Input;

    /// The requests that it takes; they name the daemon.
    type Request: Request;

    /// What it tells of itself beside its heartbeat, see [`crate::facts`].
    type Facts: Serialize;

    /// Opens its ports, on the start and on every new generation of the bus, and publishes its last output again.
    ///
    /// # Errors
    /// The bus refuses.
    fn attach(&mut self, bus: &Bus) -> Result<(), Failure>;

    /// Handles an event.
    ///
    /// # Errors
    /// What is to be done cannot be done. The error goes into the heartbeat, and the daemon goes on.
    fn handle(&mut self, event: Event<Self::Input>) -> Result<Done, Failure>;

    /// Does what a client asks for; its effect is on disk when this answers. Without an answer it is not done yet: that comes by
    /// [`Self::late_answer`], and no other request before it.
    ///
    /// # Errors
    /// The event cannot be handled. The error goes to the client and into the heartbeat, and the daemon continues.
    fn answer(&mut self, request: Self::Request, asked: &Asked) -> Result<Done<Option<AnswerOf<Self>>>, Failure>;

    /// The answer, or why there is none, to the request that has got none, once there is one; looked for after every event.
    fn late_answer(&mut self) -> Option<Result<AnswerOf<Self>, Failure>> {
        None
    }

    /// What an operator has to see until it is cured; read after every event and request.
    fn standing(&self) -> Standing {
        Standing::default()
    }

    /// Its facts; read after every event and request.
    fn facts(&self) -> Self::Facts;
}

/// The circumstances of a request.
#[derive(Clone)]
pub struct Asked {
    /// Who sent it.
    pub by: Caller,
    /// Takes the share that is done.
    pub reporter: Reporter,
}

/// What is wrong with a service, or worth knowing, for as long as it is so: later successes do not clear it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Standing {
    /// Why its output is not what its inputs ask for.
    pub error: Option<String>,
    /// What an operator should know although nothing failed, such as a clock that is not trusted.
    pub warning: Option<String>,
}

/// What a service answers.
pub type AnswerOf<S> = <<S as Service>::Request as Request>::Answer;

/// An event for a service.
#[derive(Debug)]
pub enum Event<I> {
    /// It is attached to the bus: time to begin what needs no input.
    Attached,
    /// A sample of one of its inputs; older ones were left out.
    Input(I),
    /// A heartbeat has passed in which nothing else happened, or the service asked to be woken.
    Tick,
    /// The configuration was read again: what can change while the daemon runs is to be as it says.
    Configuration(Box<SiteConfig>),
}

/// What came of an event or of a request, and what is to happen next.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Done<A = ()> {
    /// The answer for the client that asked.
    pub answer: A,
    /// What was published last; nothing where nothing was done.
    pub published: Published,
    /// Tick no later than after this time; a heartbeat comes without asking.
    pub wake_in: Option<Duration>,
}

impl<A> Done<A> {
    /// The same with this answer.
    pub fn answered<B>(self, answer: B) -> Done<B> {
        let Self { published, wake_in, .. } = self;
        Done { answer, published, wake_in }
    }
}

/// The activity of a service, shared with its loop.
#[derive(Debug, Clone, Default)]
pub struct CurrentActivity(Arc<Mutex<Activity>>);

impl CurrentActivity {
    /// Sets the activity.
    pub fn set(&self, activity: Activity) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = activity;
    }

    /// The last activity.
    pub fn get(&self) -> Activity {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
