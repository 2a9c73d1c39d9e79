//! Shared parts of the fuzz targets: functions per target, mutations of STEP text, process set-up.

pub mod step_text;
pub mod targets;

use std::panic;
use std::sync::Mutex;

/// Prepares the process of a target, once.
///
/// Work runs on the one thread of the fuzzer. A panic in this project's own code ends the process at once, also where it would
/// be caught; one in a foreign crate may unwind, because that is what the project relies on where it catches panics of the
/// IFC kernel. One that is not caught ends in libFuzzer's crate, and is reported there.
///
/// # Panics
/// If the process is prepared twice.
pub fn prepare() {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("it is called once");
    let report = panic::take_hook();
    let foreign = Mutex::new(String::new());
    panic::set_hook(Box::new(move |panic| {
        let is_in = |part: &str| panic.location().is_some_and(|at| at.file().contains(part));
        let mut foreign = foreign.lock().expect("nothing panics while it is held");
        if is_in("/libfuzzer-sys-") {
            eprintln!("a foreign crate panicked: {foreign}");
        } else if is_in("/registry/src/") || is_in("/rustc/") {
            *foreign = panic.to_string();
        } else {
            report(panic);
            std::process::abort();
        }
    }));
}
