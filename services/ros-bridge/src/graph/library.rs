//! The ROS 2 library in this process: whether it still works.

use rustix::io::Errno;

/// The library keeps up to 8192 messages for a reader that does not acknowledge them; this is a hundred sets of large maps. Pages that
/// are shared with others, such as the grids of the bus, do not count.
const MAX_OWN_BYTES: u64 = 3 << 30;

/// The library as it was when it had joined the graph.
pub(super) struct Library {
    n_threads: Option<usize>,
}

impl Library {
    /// As it is now.
    pub(super) fn now() -> Self {
        Self { n_threads: n_threads() }
    }

    /// Why it cannot go on.
    ///
    /// A thread of it ends without an error when the system interrupts its waiting, as it does when a stopped process goes on or a
    /// computer wakes up: from then on nobody gets anything.
    pub(super) fn failure(&self) -> Option<&'static str> {
        if let (Some(before), Some(now)) = (self.n_threads, n_threads())
            && now < before
        {
            return Some("a thread of the ROS 2 library has ended");
        }
        let is_full = own_bytes().is_some_and(|bytes| bytes > MAX_OWN_BYTES);
        is_full.then_some("its memory is full, perhaps of messages that a reader in ROS 2 does not take")
    }
}

/// Threads of this process by the name of the DDS library; `None` if that cannot be read now.
fn n_threads() -> Option<usize> {
    let mut n_threads = 0;
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        match std::fs::read_to_string(thread.ok()?.path().join("comm")) {
            Ok(name) => n_threads += usize::from(name.starts_with("RustDDS")),
            // It has ended meanwhile: before the file was opened, or after that.
            Err(why) if [Errno::NOENT, Errno::SRCH].map(|e| Some(e.raw_os_error())).contains(&why.raw_os_error()) => {}
            Err(_) => return None,
        }
    }
    Some(n_threads)
}

/// Memory of this process alone; `None` if it is not known.
fn own_bytes() -> Option<u64> {
    let statm = std::fs::read_to_string("/proc/self/statm").ok()?;
    let mut pages = statm.split(' ').skip(1).map_while(|pages| pages.parse::<u64>().ok());
    let own = pages.next()?.saturating_sub(pages.next()?);
    Some(own * rustix::param::page_size() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_has_ended_is_a_failure_and_pages_of_others_are_not() {
        let count = || n_threads().unwrap();
        let before = count();
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let thread = std::thread::Builder::new().name("RustDDS test".to_owned());
        let thread = thread.spawn(move || ended.recv()).unwrap();
        while count() == before {
            std::thread::yield_now();
        }
        let library = Library::now();
        assert_eq!(library.failure(), None);
        drop(end);
        let _ = thread.join().unwrap();
        while count() > before {
            std::thread::yield_now();
        }
        assert_eq!(library.failure(), Some("a thread of the ROS 2 library has ended"));
        let own = own_bytes().unwrap();
        assert!(own > 1 << 16 && own < MAX_OWN_BYTES, "{own}");
    }
}
