//! What the fuzz targets share: what each does with its bytes, mutations of STEP text, and the set-up of the process.

pub mod step_text;
pub mod targets;

use std::panic;

/// Prepares the process of a target, once.
///
/// Work runs on the one thread of the fuzzer. A panic in this project's own code ends the process at once, also where it would
/// be caught; one in a foreign crate may unwind, because that is what the project relies on where it catches panics of the
/// IFC kernel, and libFuzzer reports those that are not caught.
///
/// # Panics
/// If the process is prepared twice.
pub fn prepare() {
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().expect("it is called once");
    let report = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        let is_foreign =
            panic.location().is_some_and(|at| at.file().contains("/registry/src/") || at.file().starts_with("/rustc/"));
        if !is_foreign {
            report(panic);
            std::process::abort();
        }
    }));
}
