//! The service's own thread: jobs one after the other, each with its outcome.

use crate::config::SiteConfig;
use crate::failure::{Failure, chain};
use crate::input::Input;
use crate::service::{Asked, Done, Event, Service, Standing};
use bus::{Bus, RawSample, Waker};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Name of the threads that a service works on, and of those that it starts for its work; one with another name is no part of a
/// job.
pub(crate) const WORK_THREAD: &str = "service-work";

/// A job of the service. Samples are validated on its thread, because that takes time.
pub(crate) enum Job<R> {
    Attach(Bus, Waker),
    Attached,
    Sample(RawSample),
    Request(R, Asked),
    Configuration(Box<SiteConfig>),
    Tick,
}

/// The outcome of a job.
pub(crate) struct Outcome {
    pub(crate) result: Result<Done, Failure>,
    /// What the client that waits is told, as bytes of its answer; `None` for jobs without a client, or if it has to wait.
    pub(crate) answer: Option<Result<Vec<u8>, String>>,
    /// What the service tells of itself after it.
    pub(crate) standing: Standing,
    pub(crate) facts: serde_json::Value,
}

/// Channels of the loop. A panic of the service closes them.
pub(crate) struct ServiceThread<R> {
    pub(crate) jobs: Sender<Job<R>>,
    pub(crate) outcomes: Receiver<Outcome>,
}

/// Starts the thread, with a pool of so many for its parallel work; 0: all cores.
///
/// # Errors
/// The system cannot start a thread.
pub(crate) fn start<S: Service + 'static>(
    name: &str,
    n_threads: usize,
    service: S,
) -> Result<ServiceThread<S::Request>, Failure> {
    let (to_service, jobs) = channel();
    let (outcomes, from_service) = channel();
    // The service runs on a thread of the pool that its parallel work runs on: handing work to a pool from outside
    // costs an allocation now and then, and a thread.
    let pool =
        rayon::ThreadPoolBuilder::new().num_threads(n_threads).thread_name(|_| WORK_THREAD.to_owned()).build()?;
    let thread = std::thread::Builder::new().name(name.to_owned());
    thread.spawn(move || pool.install(move || work(service, &jobs, outcomes)))?;
    Ok(ServiceThread { jobs: to_service, outcomes: from_service })
}

fn work<S: Service>(mut service: S, jobs: &Receiver<Job<S::Request>>, outcomes: Sender<Outcome>) {
    let mut sender = ResultSender { outcomes: Some(outcomes), waker: None };
    for job in jobs {
        let mut answer = None;
        let result = match job {
            Job::Attach(bus, waker) => {
                sender.waker = Some(waker);
                service.attach(&bus).map(|()| Done::default())
            }
            Job::Attached => service.handle(Event::Attached),
            Job::Sample(sample) => S::Input::check(sample).and_then(|input| service.handle(Event::Input(input))),
            Job::Request(request, asked) => match service.answer(request, &asked) {
                Ok(done) => {
                    answer = done.answer.as_ref().map(in_bytes);
                    Ok(done.answered(()))
                }
                Err(why) => {
                    answer = Some(Err(chain(why.as_ref())));
                    Err(why)
                }
            },
            Job::Configuration(config) => service.handle(Event::Configuration(config)),
            Job::Tick => service.handle(Event::Tick),
        };
        let late = service.late_answer().map(|late| late.map_err(|why| chain(why.as_ref())).and_then(|a| in_bytes(&a)));
        // Facts are plain records: only a text that is no UTF-8, such as a path, has no JSON.
        let facts = serde_json::to_value(service.facts()).unwrap_or_default();
        let outcome = Outcome { result, answer: answer.or(late), standing: service.standing(), facts };
        if sender.outcomes.as_ref().is_some_and(|outcomes| outcomes.send(outcome).is_err()) {
            return;
        }
        sender.waker.iter().for_each(Waker::wake_up);
    }
}

fn in_bytes<A: serde::Serialize>(answer: &A) -> Result<Vec<u8>, String> {
    serde_json::to_vec(answer).map_err(|why| chain(&why))
}

/// The sender of outcomes. A panic of the service closes it and wakes the loop.
struct ResultSender {
    outcomes: Option<Sender<Outcome>>,
    waker: Option<Waker>,
}

impl Drop for ResultSender {
    fn drop(&mut self) {
        drop(self.outcomes.take());
        self.waker.iter().for_each(Waker::wake_up);
    }
}
