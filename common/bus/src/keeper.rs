//! The keeper: the process that creates and holds all services of a domain.

use crate::domain::Domain;
use crate::error::DomainError;
use crate::file_lock::{FileIdentity, Lock};
use crate::generation::Place;
use crate::held_files::HeldFiles;
use crate::ipc;
use crate::robot_name::RobotName;
use crate::signal::Signal;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

/// A segment that has been empty for this long was left by a dead process.
const EMPTY_FOR: Duration = Duration::from_secs(1);

/// Holds a bus. All other processes only open services, so that only the death of the keeper can leave one half
/// created.
///
/// On its start it takes over the services that participants hold; when that fails, or there are none, it creates a new
/// generation, which participants join ([`crate::Wake::superseded`]). Dropped, it removes the bus; what participants
/// still hold is removed by the next keeper.
pub struct Keeper {
    /// First: services go before their generation is removed.
    services: Option<ipc::Services>,
    place: Place,
    robots: Vec<RobotName>,
    generation: u64,
    held_files: HeldFiles,
    _sweeper: Sweeper,
    lock: Lock,
}

impl Keeper {
    /// Number of the generation: above every earlier one of which something is left.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Removes resources of dead participants, and generations without members. To be called about once a second: a
    /// dead daemon is only noticed here. Returns the number of dead participants.
    ///
    /// # Errors
    /// Files that cannot be removed.
    pub fn tick(&self) -> Result<u64, DomainError> {
        // A file that cannot be handled keeps no dead participant in its place.
        let (closed, removed) = (self.place.keep_others_out(), self.remove_others());
        let n_dead = self.services.as_ref().map_or(0, ipc::Services::remove_dead);
        closed.and(removed)?;
        Ok(n_dead)
    }

    /// Makes a new generation if a file of this one was deleted or replaced from outside: by hand, or by a login manager
    /// that removes a user's shared memory. To be called about once a second, before [`Keeper::tick`]. Returns the first
    /// file that was missed.
    ///
    /// # Errors
    /// Another keeper has made the folder of the bus its own; no room in shared memory. The generation stays as it is, and
    /// the next call tries again.
    pub fn renew_if_damaged(&mut self) -> Result<Option<PathBuf>, DomainError> {
        let Some(missing) = self.held_files.missing(&self.place)? else { return Ok(None) };
        self.place.make_root()?;
        let lock_path = self.place.keeper_lock_path();
        let held = self.lock.identity().map_err(|source| DomainError::File { path: lock_path.clone(), source })?;
        if FileIdentity::at(&lock_path)? != Some(held) {
            let lock = self.place.lock_as_keeper()?;
            self.lock =
                lock.ok_or_else(|| DomainError::KeeperRuns { root: self.place.root().display().to_string() })?;
        }
        let generation = self.place.next_number(Some(self.generation))?;
        let services = ipc::Services::create(&self.place, generation, &self.robots)?;
        self.held_files = HeldFiles::of(&self.place, generation, &self.lock)?;
        self.place.keep_others_out()?;
        self.place.announce(generation)?;
        (self.services, self.generation) = (Some(services), generation);
        Ok(Some(missing))
    }

    /// Creates the services of a bus.
    ///
    /// # Errors
    /// A bus of another user, another keeper, no room in shared memory, files that cannot be written.
    pub fn start(domain: &Domain) -> Result<Self, DomainError> {
        domain.require_own()?;
        let (place, robots) = (&domain.place, domain.robots().to_vec());
        place.make_root()?;
        let lock = place.lock_as_keeper()?;
        let lock = lock.ok_or_else(|| DomainError::KeeperRuns { root: place.root().display().to_string() })?;
        // Before anything is opened: that may wait for an empty segment.
        let sweeper = Sweeper::start(place)?;
        // A file of another version, or one that is damaged, says only that its generation is not ours.
        let current = place.current().unwrap_or_default();
        let taken_over = match current {
            // Members of another build are to leave it, and be refused.
            Some(generation) if place.has_members(generation)? && place.require_own_build().is_ok() => {
                // Nothing is repaired in place, whichever service cannot be opened.
                ipc::Services::create(place, generation, &robots).ok().map(|services| (services, generation))
            }
            _ => None,
        };
        let (services, generation) = match taken_over {
            Some(found) => found,
            None => {
                let generation = place.next_number(current)?;
                (ipc::Services::create(place, generation, &robots)?, generation)
            }
        };
        let held_files = HeldFiles::of(place, generation, &lock)?;
        place.keep_others_out()?;
        place.announce(generation)?;
        let place = place.clone();
        let keeper = Self { services: Some(services), place, robots, generation, held_files, _sweeper: sweeper, lock };
        // What cannot be removed now is no reason to be without a bus: the next tick tries it again, and says so.
        let _ = keeper.remove_others();
        Ok(keeper)
    }

    /// Removes other generations without members; the first that cannot be removed is the error.
    fn remove_others(&self) -> Result<(), DomainError> {
        let mut first = Ok(());
        for generation in self.place.numbers()? {
            if generation != self.generation {
                first = first.and(self.place.remove(generation).map(drop));
            }
        }
        first
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        // What cannot be removed now is removed by the next keeper. A keeper that made the folder anew keeps its generation.
        if self.place.current().is_ok_and(|current| current == Some(self.generation)) {
            let _ = self.place.withdraw();
        }
        // The bus library lists all shared memory of the machine for each service that it removes. One who is killed
        // meanwhile leaves nothing if the files went before.
        if self.services.as_ref().is_some_and(ipc::Services::outlive_all_members) {
            let _ = self.place.remove_files(self.generation);
        }
        self.services = None;
        let _ = self.remove_others();
        let _ = self.place.remove(self.generation);
    }
}

/// A thread that removes empty segments: the keeper itself may be waiting for one.
struct Sweeper {
    stop: Arc<Signal>,
    thread: Option<JoinHandle<()>>,
}

impl Sweeper {
    fn start(place: &Place) -> Result<Self, DomainError> {
        let failed = |source| DomainError::File { path: place.root().to_owned(), source };
        let stop = Arc::new(Signal::new().map_err(failed)?);
        let (place, stopped) = (place.clone(), Arc::clone(&stop));
        let sweep = move || {
            while !is_raised_within(&stopped, EMPTY_FOR) {
                // What cannot be removed now is tried again.
                let _ = place.remove_empty_segments(EMPTY_FOR);
            }
        };
        let thread = std::thread::Builder::new().name("sweeper".to_owned()).spawn(sweep);
        let thread = thread.map_err(|source| DomainError::File { path: "sweeper".into(), source })?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Sweeper {
    fn drop(&mut self) {
        self.stop.raise();
        if let Some(thread) = self.thread.take() {
            // Its panic has been reported; there is nothing to add.
            let _ = thread.join();
        }
    }
}

fn is_raised_within(signal: &Signal, time: Duration) -> bool {
    let mut polled = [PollFd::from_borrowed_fd(signal.descriptor(), PollFlags::IN)];
    let timeout = Timespec { tv_sec: time.as_secs().cast_signed(), tv_nsec: i64::from(time.subsec_nanos()) };
    poll(&mut polled, Some(&timeout)).is_ok_and(|n| n > 0)
}
