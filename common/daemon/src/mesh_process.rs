//! Runs a task in a process of its own under limits of time and memory, so that nothing that happens to it happens here.
//!
//! The process is this program again with [`ARGUMENT`]: the task comes on its standard input, answers go to its standard
//! output as they are known. It is the first that the system ends when memory runs out.

use crate::cpu_ticks::cpu_ticks;
use rustix::param::clock_ticks_per_second;
use rustix::process::{Resource, Rlimit, Signal, getrlimit, setrlimit};
use rustix::time::{ClockId, clock_gettime};
use std::ffi::OsStr;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitCode, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The only argument of the process.
const ARGUMENT: &str = "mesh-process";

/// Limit of its address space, of which every thread of the kernel takes a quarter of a gibibyte for its stack.
const MAX_BYTES: u64 = 3 << 30;
/// Limits of its CPU time in seconds: for each answer, and for the first one, before which it reads the file.
const MAX_CPU_S: u64 = 10;
const MAX_READING_CPU_S: u64 = 30;

/// Processes that mesh for this one now.
static RUNNING: Mutex<Vec<u32>> = Mutex::new(Vec::new());

fn running() -> MutexGuard<'static, Vec<u32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Numbers of the processes that mesh for this one now.
pub(crate) fn mesh_processes() -> Vec<u32> {
    running().clone()
}

/// Gives a task to a process of its own: parts of its bytes in, what it answers out, as it comes. `max_cpu_s` is a limit in whole
/// seconds of the CPU time in all. Gives the CPU time in seconds, and why there are no more answers: the process cannot be
/// started, failed, or was ended, as by one of its limits.
pub fn in_mesh_process(
    task: &[&[u8]],
    max_cpu_s: Option<f64>,
    take: &mut dyn FnMut(&[u8]),
) -> (f64, Result<(), String>) {
    let max_cpu_s = max_cpu_s.map(|max_cpu_s| (max_cpu_s.ceil().max(1.0) as u64).to_string());
    let mut command = Command::new("/proc/self/exe");
    command.arg(ARGUMENT).args(max_cpu_s).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = match command.spawn() {
        Ok(child) => child,
        Err(error) => return (0.0, Err(format!("its process cannot be started: {error}"))),
    };
    let process = child.id();
    running().push(process);
    let (stdin, stdout) = (child.stdin.take(), child.stdout.take());
    let read = std::thread::scope(|scope| {
        // A process that ends early closes the pipe; its status tells why.
        scope.spawn(move || stdin.map(|mut stdin| task.iter().try_for_each(|part| stdin.write_all(part))));
        stdout.map_or(Ok(()), |stdout| hand_on(stdout, take))
    });
    let cpu_s = cpu_s_of(process);
    let status = child.wait();
    running().retain(|other| *other != process);
    let end = match status {
        Err(error) => Err(format!("its process is lost: {error}")),
        Ok(status) if !status.success() => Err(why_ended(status)),
        Ok(_) => read.map_err(|error| format!("its process cannot be read: {error}")),
    };
    (cpu_s, end)
}

/// CPU time that a process has taken, also one that has ended and was not waited for; 0 where the system does not say.
fn cpu_s_of(process: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let ticks: u64 = cpu_ticks(&stat).split(' ').filter_map(|ticks| ticks.parse::<u64>().ok()).sum();
    ticks as f64 / clock_ticks_per_second() as f64
}

/// Hands on what comes until its end.
fn hand_on(mut from: impl Read, take: &mut dyn FnMut(&[u8])) -> std::io::Result<()> {
    let mut piece = vec![0; 1 << 16];
    loop {
        match from.read(&mut piece) {
            Ok(0) => return Ok(()),
            Ok(n) => take(&piece[..n]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// What a process met that failed.
fn why_ended(status: ExitStatus) -> String {
    match status.signal().and_then(Signal::from_named_raw) {
        Some(Signal::XCPU) => format!("the kernel takes more than {MAX_CPU_S} s of CPU time for it"),
        Some(Signal::KILL) => "the system ended the kernel's process, which it does where memory runs out".to_owned(),
        Some(Signal::ABORT | Signal::SEGV | Signal::BUS) => {
            format!("the kernel wants more than {} GiB of memory for it, or overflows its stack", MAX_BYTES >> 30)
        }
        Some(signal) => format!("the kernel's process was ended by signal {}", signal.as_raw()),
        None => "the kernel fails".to_owned(),
    }
}

/// Runs the task of this process, if it is one that [`in_mesh_process`] has started; `None` if it is not. To be called before
/// anything else. `work` gives its answers as it has them.
pub fn run_mesh_process<E>(
    work: impl FnOnce(&[u8], &mut (dyn FnMut(&[u8]) + Send)) -> Result<(), E>,
) -> Option<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().as_deref() != Some(OsStr::new(ARGUMENT)) {
        return None;
    }
    let max_cpu_s = match arguments.next() {
        Some(seconds) => Some(seconds.to_str()?.parse().ok()?),
        None => None,
    };
    if arguments.next().is_some() {
        return None;
    }
    Some(if done(max_cpu_s, work).is_some() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn done<E>(
    max_cpu_s: Option<u64>,
    work: impl FnOnce(&[u8], &mut (dyn FnMut(&[u8]) + Send)) -> Result<(), E>,
) -> Option<()> {
    let limit = |most| Rlimit { current: Some(most), maximum: Some(most) };
    setrlimit(Resource::As, limit(MAX_BYTES)).ok()?;
    // The signal of the time limit would leave a dump of its memory.
    setrlimit(Resource::Core, limit(0)).ok()?;
    allow_cpu_s(MAX_READING_CPU_S, max_cpu_s)?;
    // Where it may not be written, the system chooses by size, which is this process as well.
    let _ = std::fs::write("/proc/self/oom_score_adj", "1000");
    let mut task = Vec::new();
    std::io::stdin().read_to_end(&mut task).ok()?;
    let mut is_sent = true;
    let mut answer = |bytes: &[u8]| {
        let mut out = std::io::stdout();
        is_sent &=
            out.write_all(bytes).and_then(|()| out.flush()).is_ok() && allow_cpu_s(MAX_CPU_S, max_cpu_s).is_some();
    };
    work(&task, &mut answer).ok()?;
    is_sent.then_some(())
}

/// Allows this process so much more CPU time, and no more than this in all.
fn allow_cpu_s(more_s: u64, max_cpu_s: Option<u64>) -> Option<()> {
    let spent_s = clock_gettime(ClockId::ProcessCPUTime).tv_sec.unsigned_abs();
    let maximum = getrlimit(Resource::Cpu).maximum;
    let current = [maximum, max_cpu_s].into_iter().flatten().fold(spent_s + more_s, u64::min);
    setrlimit(Resource::Cpu, Rlimit { current: Some(current), maximum }).ok()
}
