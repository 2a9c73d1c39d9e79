//! The output of a service on a latched topic: what was published last comes again in every generation of the bus, and after a
//! full memory.

use crate::failure::Failure;
use crate::request::Published;
use crate::state::Epochs;
use bus::{Bus, Origin, Publisher, Topic};
use messages::{ArchiveBuffer, Checked, InputHashes};
use tracing::warn;

/// Room that is reserved for a topic of which nothing was published yet.
const FIRST_BYTES: usize = 1 << 16;

/// A topic, and what was published on it last.
///
/// The archive stays in the heap, and is copied into shared memory: it has to outlive the generations of the bus, and is
/// compared with the next one. So it is for site, schedule state, mission plan, alignment and deviations; grids and their
/// index have publishers of their own.
pub struct LatchedOutput<T: Topic> {
    topic: T,
    publisher: Option<Publisher<T>>,
    last: Option<Last<T>>,
    is_pending: bool,
}

/// What came last. Its epoch is taken when it is first to be published; a disk that is full refuses it.
struct Last<T: Topic> {
    archive: Checked<T::Payload>,
    epoch: Option<u64>,
    frame_epoch: u64,
    inputs: InputHashes,
}

impl<T: Topic> LatchedOutput<T> {
    /// Nothing was published yet.
    pub fn new(topic: T) -> Self {
        Self { topic, publisher: None, last: None, is_pending: false }
    }

    /// Joins a generation of the bus, and brings it what was published last; what cannot be published is pending.
    ///
    /// # Errors
    /// A topic that cannot be opened.
    pub fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure> {
        // The end of the earlier generation first: there is one publisher.
        self.publisher = None;
        let length = self.last.as_ref().map_or(FIRST_BYTES, |last| last.archive.bytes().bytes().len());
        self.publisher = Some(bus.publisher(self.topic, length)?);
        self.is_pending = self.last.is_some();
        if let Err(why) = self.retry(epochs) {
            warn!(error = crate::chain(why.as_ref()), "what was published last has no room yet");
        }
        Ok(())
    }

    /// Publishes an archive under the next epoch; before the bus is there it waits for it.
    ///
    /// # Errors
    /// As [`Self::retry`]. The archive is pending.
    pub fn publish(
        &mut self,
        epochs: &mut Epochs,
        archive: Checked<T::Payload>,
        frame_epoch: u64,
        inputs: InputHashes,
    ) -> Result<(), Failure> {
        self.last = Some(Last { archive, epoch: None, frame_epoch, inputs });
        self.is_pending = true;
        self.retry(epochs)
    }

    /// Publishes what is pending, if there is a bus.
    ///
    /// # Errors
    /// The epoch cannot be kept, or the bus refuses, for instance because shared memory is full; it stays pending.
    pub fn retry(&mut self, epochs: &mut Epochs) -> Result<(), Failure> {
        let Some(last) = self.last.as_mut().filter(|_| self.is_pending) else { return Ok(()) };
        let epoch = match last.epoch {
            Some(epoch) => epoch,
            None => *last.epoch.insert(epochs.take()?),
        };
        if let Some(publisher) = &self.publisher {
            let origin = Origin { epoch, frame_epoch: last.frame_epoch, inputs: last.inputs };
            publisher.publish_copy(last.archive.bytes().bytes(), origin)?;
            self.is_pending = false;
        }
        Ok(())
    }

    /// True while what came last is not published.
    pub fn is_pending(&self) -> bool {
        self.is_pending
    }

    /// What came last.
    pub fn last(&self) -> Option<&Checked<T::Payload>> {
        self.last.as_ref().map(|last| &last.archive)
    }

    /// True if an archive is the same as what came last.
    pub fn is_last(&self, archive: &ArchiveBuffer) -> bool {
        self.last().is_some_and(|last| last.bytes().bytes() == archive.bytes())
    }

    /// Epoch of what came last; 0 for nothing.
    pub fn epoch(&self) -> u64 {
        self.last.as_ref().and_then(|last| last.epoch).unwrap_or(0)
    }

    /// What came last was made from this; all zero for nothing.
    pub fn inputs(&self) -> InputHashes {
        self.last.as_ref().map_or(InputHashes::default(), |last| last.inputs)
    }

    /// Hash and epoch of what came last.
    pub fn published(&self) -> Published {
        Published { content_hash: self.last().map_or(0, Checked::content_hash), epoch: self.epoch() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::{Daemon, Domain, Keeper, topics};
    use messages::ScheduleStateBuilder;
    use std::time::Duration;

    #[test]
    fn an_archive_that_got_no_epoch_is_published_when_the_disk_has_room_again() {
        let root = tempfile::Builder::new().prefix("bus").tempdir_in("/dev/shm").unwrap();
        let domain = Domain::shared(&format!("go{:x}_", std::process::id()), root.path()).unwrap();
        let _keeper = Keeper::start(&domain).unwrap();
        let (producer, mut waiter) = Bus::join(&domain, Daemon::ScheduleEval).unwrap();
        let (consumer, _waiter) = Bus::join(&domain, Daemon::Groundplan).unwrap();
        let states = consumer.subscriber(topics::ScheduleState).unwrap();

        let home = tempfile::tempdir().unwrap();
        let state = home.path().join("state");
        std::fs::create_dir(&state).unwrap();
        let mut epochs = Epochs::at(&state, "epochs.json").unwrap();
        std::fs::remove_dir_all(&state).unwrap();
        let mut output = LatchedOutput::new(topics::ScheduleState);
        output.attach(&producer, &mut epochs).unwrap();
        let archive = Checked::new(ScheduleStateBuilder::everything_built(7, 3, 1).finish()).unwrap();
        assert!(output.publish(&mut epochs, archive, 1, InputHashes::default()).is_err());
        assert!(output.is_pending() && output.epoch() == 0 && states.take().unwrap().is_none());

        std::fs::create_dir(&state).unwrap();
        output.retry(&mut epochs).unwrap();
        waiter.wait(Duration::ZERO).unwrap();
        let sample = states.take().unwrap().unwrap();
        assert!(!output.is_pending() && sample.header().epoch == output.epoch() && output.epoch() > 0);
        assert_eq!(sample.check().unwrap().content_hash(), output.published().content_hash);
    }
}
