//! A background thread at low priority that works on one job after the other. A panic is the error of its job.

use daemon::Failure;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

/// A job that is done, and what came of it.
pub struct Outcome<J, R> {
    /// The job.
    pub job: J,
    /// Its result.
    pub result: Result<R, Failure>,
}

/// The ends of who works on one job after the other.
pub struct Worker<J, R> {
    /// Takes jobs.
    pub jobs: Sender<J>,
    /// Gives each back when it is done.
    pub outcomes: Receiver<Outcome<J, R>>,
}

impl<J: Send + 'static, R: Send + 'static> Worker<J, R> {
    /// Starts the thread, with a pool of so many for its parallel work; 0: all cores. After a panic `work` is called again for
    /// the next job.
    ///
    /// # Errors
    /// The system has no threads to give.
    pub(crate) fn start(
        n_threads: usize,
        mut work: impl FnMut(&J) -> Result<R, Failure> + Send + 'static,
    ) -> Result<Self, Failure> {
        let (jobs, pending) = channel::<J>();
        let (done, outcomes) = channel();
        let thread = std::thread::Builder::new().name("slam-align-work".to_owned());
        thread.spawn(move || {
            // Tracking and publication must not wait for it, but a robot without a pose does; threads of the pool inherit the priority.
            daemon::behind_others();
            let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build() else { return };
            pool.install(|| {
                for job in pending {
                    let result = catch_unwind(AssertUnwindSafe(|| work(&job)));
                    let result = result.unwrap_or_else(|panic| Err(words_of(panic.as_ref()).into()));
                    if done.send(Outcome { job, result }).is_err() {
                        return;
                    }
                }
            });
        })?;
        Ok(Self { jobs, outcomes })
    }

    /// Begins a job, as the last one is done. Without a thread [`Self::take`] fails.
    pub(crate) fn begin(&self, job: J) {
        let _ = self.jobs.send(job);
    }

    /// The outcome of the last job, if it is done.
    ///
    /// # Errors
    /// There is no thread.
    pub(crate) fn take(&self) -> Result<Option<Outcome<J, R>>, Failure> {
        match self.outcomes.try_recv() {
            Ok(outcome) => Ok(Some(outcome)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(NO_THREAD.into()),
        }
    }
}

const NO_THREAD: &str = "the thread that searches poses has ended: restart slam-align";

fn words_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("it panicked, which is a bug: {}", text.unwrap_or("without a message"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    fn outcome_of(worker: &Worker<u32, u32>, job: u32) -> Outcome<u32, u32> {
        worker.begin(job);
        let begun = Instant::now();
        loop {
            if let Some(outcome) = worker.take().unwrap() {
                return outcome;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "no outcome");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_panic_is_the_error_of_its_job_which_comes_back_and_the_next_job_is_done() {
        let worker = Worker::start(2, |job: &u32| match *job {
            0 => panic!("no zero"),
            1 => Ok(rayon::join(|| -> u32 { panic!("{job} in the pool") }, || 0).1),
            2 => Err("refused".into()),
            job => Ok(job * 10),
        })
        .unwrap();
        for (job, why) in [(0, "no zero"), (1, "1 in the pool"), (2, "refused")] {
            let Outcome { job: back, result } = outcome_of(&worker, job);
            let text = result.unwrap_err().to_string();
            assert!(back == job && text.contains(why), "{text}");
            assert!(worker.take().unwrap().is_none());
        }
        assert_eq!(outcome_of(&worker, 7).result.unwrap(), 70);
    }
}
