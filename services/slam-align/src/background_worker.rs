//! A background thread at low priority that works on one job after the other. A panic is the error of its job.

use daemon::Failure;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

/// A job that is done, and what came of it.
pub(crate) struct Outcome<J, R> {
    pub(crate) job: J,
    pub(crate) result: Result<R, Failure>,
}

/// The thread, and whether it is busy.
pub(crate) struct BackgroundWorker<J, R> {
    jobs: Sender<J>,
    outcomes: Receiver<Outcome<J, R>>,
    is_busy: bool,
}

impl<J: Send + 'static, R: Send + 'static> BackgroundWorker<J, R> {
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
            // Tracking and publication must not wait for it; threads of the pool inherit the priority.
            daemon::in_background();
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
        Ok(Self { jobs, outcomes, is_busy: false })
    }

    pub(crate) fn is_busy(&self) -> bool {
        self.is_busy
    }

    /// Starts a job on the idle thread.
    ///
    /// # Errors
    /// There is no thread.
    pub(crate) fn begin(&mut self, job: J) -> Result<(), Failure> {
        self.jobs.send(job).map_err(|_| NO_THREAD)?;
        self.is_busy = true;
        Ok(())
    }

    /// The outcome of the last job, if it is done.
    ///
    /// # Errors
    /// There is no thread.
    pub(crate) fn take(&mut self) -> Result<Option<Outcome<J, R>>, Failure> {
        match self.outcomes.try_recv() {
            Ok(outcome) => {
                self.is_busy = false;
                Ok(Some(outcome))
            }
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

    fn outcome_of(worker: &mut BackgroundWorker<u32, u32>, job: u32) -> Outcome<u32, u32> {
        worker.begin(job).unwrap();
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
        let mut worker = BackgroundWorker::start(2, |job: &u32| match *job {
            0 => panic!("no zero"),
            1 => Ok(rayon::join(|| -> u32 { panic!("{job} in the pool") }, || 0).1),
            2 => Err("refused".into()),
            job => Ok(job * 10),
        })
        .unwrap();
        for (job, why) in [(0, "no zero"), (1, "1 in the pool"), (2, "refused")] {
            let Outcome { job: back, result } = outcome_of(&mut worker, job);
            let text = result.unwrap_err().to_string();
            assert!(back == job && text.contains(why), "{text}");
            assert!(!worker.is_busy());
        }
        assert_eq!(outcome_of(&mut worker, 7).result.unwrap(), 70);
    }
}
