//! The ROS 2 library in this process: whether it still works.

use daemon::resident_bytes;
use std::fs::DirEntry;

/// The library keeps up to 8192 messages for a reader that does not acknowledge them; this is a hundred sets of large maps.
const MAX_MEMORY_BYTES: u64 = 3 << 30;

/// The library as it was when it had joined the graph.
pub(super) struct Library {
    n_threads: usize,
}

impl Library {
    /// As it is now.
    pub(super) fn now() -> Self {
        Self { n_threads: n_threads() }
    }

    /// Why it cannot go on.
    ///
    /// A thread of it ends without a word when the system interrupts its waiting, as it does when a stopped process goes on or a
    /// computer wakes up: from then on nobody gets anything.
    pub(super) fn failure(&self) -> Option<&'static str> {
        if n_threads() < self.n_threads {
            return Some("the ROS 2 library has ended");
        }
        let is_full = resident_bytes() > MAX_MEMORY_BYTES;
        is_full.then_some("a reader in ROS 2 does not take its messages, and they fill the memory")
    }
}

/// Threads of this process by the name of the DDS library.
fn n_threads() -> usize {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let name = |thread: DirEntry| std::fs::read_to_string(thread.path().join("comm")).ok();
    threads.filter_map(name).filter(|name| name.starts_with("RustDDS")).count()
}
