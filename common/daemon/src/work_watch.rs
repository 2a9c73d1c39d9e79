//! Watch over a service: the job that it works on, its begin, and a verdict whether any of its threads still runs.
//!
//! Work may take long, and that is no fault: what counts is whether anything of it runs. A thread that waits for a file that does
//! not come, as on a network mount that is away, neither computes nor is woken. The loop looks once a heartbeat; when nothing has
//! run for [`MAX_STILL`] looks, the service hangs, and the daemon is silent from then on: readers take it for missing, and the
//! watchdog starts it again.

use crate::cpu_ticks::cpu_ticks;
use crate::mesh_process::mesh_processes;
use crate::progress::Reporter;
use bus::Stamp;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::PathBuf;
use std::time::Duration;
use tracing::{info, warn};

/// Looks in a row, a second apart, at which nothing of a service has run. A disk that writes back what it was given holds a
/// thread for some seconds, a bad one for a dozen.
const MAX_STILL: u32 = 30;

/// What a service works on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Busy {
    /// The job, in words.
    pub job: String,
    /// Monotonic time of its begin, nanoseconds since the machine's boot.
    pub since_ns: u64,
}

impl Busy {
    /// For how long until now.
    pub fn duration(&self) -> Duration {
        Stamp::now().since(Stamp(self.since_ns))
    }
}

/// What the kernel counts of the threads of this process with a name, and of processes that mesh for it: another one after any
/// of them has run, or has begun or ended.
///
/// A thread has the name of the one that started it, unless it is given another.
fn counts(thread_name: &str) -> Vec<String> {
    let threads = fs::read_dir("/proc/self/task").into_iter().flatten().flatten().map(|thread| thread.path());
    let read = |path: PathBuf| fs::read_to_string(path).unwrap_or_default();
    let threads = threads.filter(|thread| read(thread.join("comm")).trim_end() == thread_name);
    let meshing = mesh_processes().into_iter().map(|process| PathBuf::from(format!("/proc/{process}")));
    // Kernels that do not count the one count the other.
    let both = |task: PathBuf| [read(task.join("schedstat")), cpu_ticks(&read(task.join("stat")))];
    threads.chain(meshing).flat_map(both).collect()
}

/// Watches the service from the loop.
pub(crate) struct WorkWatch {
    service: &'static str,
    thread_name: &'static str,
    work: Option<Work>,
}

/// A job that the service has and has not ended.
struct Work {
    busy: Busy,
    reporter: Option<Reporter>,
    counts: Vec<String>,
    n_still: u32,
}

impl WorkWatch {
    /// Of an idle service, which works on threads with this name.
    pub(crate) fn of(service: &'static str, thread_name: &'static str) -> Self {
        Self { service, thread_name, work: None }
    }

    /// The service begins a job.
    pub(crate) fn begin(&mut self, job: String) {
        let busy = Busy { job, since_ns: Stamp::now().0 };
        self.work = Some(Work { busy, reporter: None, counts: Vec::new(), n_still: 0 });
    }

    /// Where the service reports the progress of its job.
    pub(crate) fn report_of(&mut self, reporter: Reporter) {
        self.work.iter_mut().for_each(|work| work.reporter = Some(reporter.clone()));
    }

    /// The service has ended its job.
    pub(crate) fn end(&mut self) {
        if self.hangs() {
            info!(service = self.service, "the service goes on");
        }
        self.work = None;
    }

    /// Looks whether anything of the job has run since the last look; once a heartbeat.
    pub(crate) fn look(&mut self) {
        let Some(work) = &mut self.work else { return };
        let counts = counts(self.thread_name);
        work.n_still = if counts == work.counts { work.n_still.saturating_add(1) } else { 0 };
        work.counts = counts;
        if work.n_still == MAX_STILL {
            let (job, busy_s) = (&work.busy.job, work.busy.duration().as_secs());
            warn!(service = self.service, job, busy_s, "the service hangs: the daemon is silent until it goes on");
        }
    }

    /// True if nothing of the job runs.
    pub(crate) fn hangs(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.n_still >= MAX_STILL)
    }

    /// What the service works on now, with what it reports to a client.
    pub(crate) fn busy(&self) -> Option<Busy> {
        let Work { busy, reporter, .. } = self.work.as_ref()?;
        let doing = reporter.as_ref().map(Reporter::doing).filter(|doing| !doing.is_empty());
        let job = doing.map_or_else(|| busy.job.clone(), |doing| format!("{} ({doing})", busy.job));
        Some(Busy { job, ..*busy })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    /// A watch of a thread with this name that runs this.
    fn watch_of(name: &'static str, work: impl FnOnce() + Send + 'static) -> (WorkWatch, std::thread::JoinHandle<()>) {
        let (runs, has_begun) = channel();
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            runs.send(()).unwrap();
            work();
        });
        has_begun.recv().unwrap();
        let mut watch = WorkWatch::of("test", name);
        watch.begin("a job".to_owned());
        (watch, thread.unwrap())
    }

    #[test]
    fn a_thread_that_waits_hangs_until_its_job_ends() {
        let (go, wait) = channel::<()>();
        let (mut watch, thread) = watch_of("waits", move || assert!(wait.recv().is_err()));
        // It may still be on its way to where it waits: then its counts change once more.
        while !watch.hangs() {
            watch.look();
        }
        assert_eq!(watch.busy().unwrap().job, "a job");
        watch.end();
        assert!(!watch.hangs() && watch.busy().is_none());
        drop(go);
        thread.join().unwrap();
    }

    #[test]
    fn a_thread_that_runs_between_two_looks_does_not_hang() {
        let (go, wait) = channel::<()>();
        let (back, done) = channel();
        let (mut watch, thread) = watch_of("runs", move || wait.iter().for_each(|()| back.send(()).unwrap()));
        for _ in 0..2 * MAX_STILL {
            go.send(()).unwrap();
            done.recv().unwrap();
            watch.look();
        }
        assert!(!watch.hangs());
        drop(go);
        thread.join().unwrap();
    }
}
