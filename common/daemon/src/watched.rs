//! A value that threads share, and of which one waits for changes.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A value that threads share. A thread that panicked left it as it was then: who comes later goes on with that.
#[derive(Debug, Default)]
pub struct Watched<T> {
    value: Mutex<T>,
    changed: Condvar,
}

impl<T> Watched<T> {
    /// This value.
    pub fn new(value: T) -> Self {
        Self { value: Mutex::new(value), changed: Condvar::new() }
    }

    /// The value, for who looks at it, or changes what nobody waits for.
    pub fn lock(&self) -> MutexGuard<'_, T> {
        self.value.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the value, and wakes who waits.
    pub fn change(&self, change: impl FnOnce(&mut T)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }

    /// Waits while `is_idle` says so of the value, but not longer than this.
    pub fn wait_while(&self, longest: Option<Duration>, is_idle: impl FnMut(&mut T) -> bool) -> MutexGuard<'_, T> {
        match longest {
            None => self.changed.wait_while(self.lock(), is_idle).unwrap_or_else(PoisonError::into_inner),
            Some(longest) => {
                let waited = self.changed.wait_timeout_while(self.lock(), longest, is_idle);
                waited.unwrap_or_else(PoisonError::into_inner).0
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn a_change_wakes_who_waits_for_it_and_a_wait_has_an_end() {
        let watched = Arc::new(Watched::<u32>::default());
        assert_eq!(*watched.wait_while(Some(Duration::from_millis(1)), |value| *value == 0), 0, "nothing came");
        let of_thread = Arc::clone(&watched);
        let waiter = std::thread::spawn(move || *of_thread.wait_while(None, |value| *value < 2));
        watched.change(|value| *value += 1);
        watched.change(|value| *value += 1);
        assert_eq!(waiter.join().unwrap(), 2);
    }
}
