//! Runs a task in a process of its own under limits of time and memory, so that nothing that happens to it happens here.
//!
//! The process is this program again with [`ARGUMENT`]: the task comes on its standard input, the result goes to its
//! standard output. It is the first that the system ends when memory runs out.

use rustix::process::{Resource, Rlimit, Signal, setrlimit};
use std::ffi::OsStr;
use std::io::{Read, Write};
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitCode, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The only argument of the process.
const ARGUMENT: &str = "mesh-process";

/// Limit of its address space, of which every thread of the kernel takes a quarter of a gibibyte for its stack.
const MAX_BYTES: u64 = 3 << 30;
/// Limit of its CPU time in seconds.
const MAX_CPU_S: u64 = 20;

/// Processes that mesh for this one now.
static RUNNING: Mutex<Vec<u32>> = Mutex::new(Vec::new());

fn running() -> MutexGuard<'static, Vec<u32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Numbers of the processes that mesh for this one now.
pub(crate) fn mesh_processes() -> Vec<u32> {
    running().clone()
}

/// Gives a task to a process of its own: parts of its bytes in, its result out.
///
/// # Errors
/// Why there is no result: the process cannot be started, failed, or was ended, as by one of its limits.
pub fn in_mesh_process(task: &[&[u8]]) -> Result<Vec<u8>, String> {
    let mut child = Command::new("/proc/self/exe")
        .arg(ARGUMENT)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("its process cannot be started: {error}"))?;
    let process = child.id();
    running().push(process);
    let mut result = Vec::new();
    let (stdin, stdout) = (child.stdin.take(), child.stdout.take());
    let read = std::thread::scope(|scope| {
        // A process that ends early closes the pipe; its status tells why.
        scope.spawn(move || stdin.map(|mut stdin| task.iter().try_for_each(|part| stdin.write_all(part))));
        stdout.map(|mut stdout| stdout.read_to_end(&mut result))
    });
    let status = child.wait();
    running().retain(|other| *other != process);
    let status = status.map_err(|error| format!("its process is lost: {error}"))?;
    if !status.success() {
        return Err(why_ended(status));
    }
    match read {
        Some(Ok(_)) => Ok(result),
        Some(Err(error)) => Err(format!("its process cannot be read: {error}")),
        None => Err("its process has no output".to_owned()),
    }
}

/// What a process met that failed.
fn why_ended(status: ExitStatus) -> String {
    match status.signal().and_then(Signal::from_named_raw) {
        Some(Signal::XCPU) => format!("the kernel takes more than {MAX_CPU_S} s for it"),
        Some(Signal::KILL) => "the system ended the kernel's process, which it does where memory runs out".to_owned(),
        Some(Signal::ABORT | Signal::SEGV | Signal::BUS) => {
            format!("the kernel wants more than {} GiB of memory for it, or overflows its stack", MAX_BYTES >> 30)
        }
        Some(signal) => format!("the kernel's process was ended by signal {}", signal.as_raw()),
        None => "the kernel fails".to_owned(),
    }
}

/// Runs the task of this process, if it is one that [`in_mesh_process`] has started; `None` if it is not. To be called before
/// anything else.
pub fn run_mesh_process<E>(work: impl FnOnce(&[u8]) -> Result<Vec<u8>, E>) -> Option<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().as_deref() != Some(OsStr::new(ARGUMENT)) || arguments.next().is_some() {
        return None;
    }
    Some(if done(work).is_some() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn done<E>(work: impl FnOnce(&[u8]) -> Result<Vec<u8>, E>) -> Option<()> {
    let limit = |most| Rlimit { current: Some(most), maximum: Some(most) };
    setrlimit(Resource::As, limit(MAX_BYTES)).ok()?;
    setrlimit(Resource::Cpu, Rlimit { current: Some(MAX_CPU_S), maximum: Some(MAX_CPU_S + 1) }).ok()?;
    // Where it may not be written, the system chooses by size, which is this process as well.
    let _ = std::fs::write("/proc/self/oom_score_adj", "1000");
    let mut task = Vec::new();
    std::io::stdin().read_to_end(&mut task).ok()?;
    let result = work(&task).ok()?;
    std::io::stdout().write_all(&result).ok()
}
