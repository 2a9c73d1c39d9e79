//! The output of a service on a latched topic: what was published last comes again in every generation of the bus, and after a
//! full memory.

use crate::failure::Failure;
use crate::state::Epochs;
use bus::{Bus, Origin, Publisher, Topic};
use messages::{ArchiveBuffer, Checked, InputHashes};

/// Room that is reserved for a topic of which nothing was published yet.
const FIRST_BYTES: usize = 1 << 16;

/// A topic, and what was published on it last.
///
/// The archive stays in the heap, and is copied into shared memory: it has to outlive the generations of the bus.
pub struct LatchedOutput<T: Topic> {
    topic: T,
    publisher: Option<Publisher<T>>,
    last: Option<(Checked<T::Payload>, Origin)>,
    is_pending: bool,
}

impl<T: Topic> LatchedOutput<T> {
    /// Nothing was published yet.
    pub fn new(topic: T) -> Self {
        Self { topic, publisher: None, last: None, is_pending: false }
    }

    /// Joins a generation of the bus, and brings it what was published last.
    ///
    /// # Errors
    /// The bus refuses. What could not be published is pending.
    pub fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // The end of the earlier generation first: there is one publisher.
        self.publisher = None;
        let length = self.last.as_ref().map_or(FIRST_BYTES, |(archive, _)| archive.bytes().bytes().len());
        self.publisher = Some(bus.publisher(self.topic, length)?);
        self.is_pending = self.last.is_some();
        self.retry()
    }

    /// Publishes an archive under the next epoch; before the bus is there it waits for it. Of its origin the epoch is filled in.
    ///
    /// # Errors
    /// The epoch cannot be kept, the bus refuses. The archive is pending.
    pub fn publish(
        &mut self,
        epochs: &mut Epochs,
        archive: Checked<T::Payload>,
        frame_epoch: u64,
        inputs: InputHashes,
    ) -> Result<(), Failure> {
        let origin = Origin { epoch: epochs.take()?, frame_epoch, inputs };
        self.last = Some((archive, origin));
        self.is_pending = true;
        self.retry()
    }

    /// Publishes what is pending, if there is a bus.
    ///
    /// # Errors
    /// The bus refuses, for instance because shared memory is full; it stays pending.
    pub fn retry(&mut self) -> Result<(), Failure> {
        if let (true, Some((archive, origin)), Some(publisher)) = (self.is_pending, &self.last, &self.publisher) {
            publisher.publish_copy(archive.bytes().bytes(), *origin)?;
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
        self.last.as_ref().map(|(archive, _)| archive)
    }

    /// True if an archive is the same as what came last.
    pub fn is_last(&self, archive: &ArchiveBuffer) -> bool {
        self.last().is_some_and(|last| last.bytes().bytes() == archive.bytes())
    }

    /// Epoch of what came last; 0 for nothing.
    pub fn epoch(&self) -> u64 {
        self.last.as_ref().map_or(0, |(_, origin)| origin.epoch)
    }

    /// Content hash of what came last; 0 for nothing.
    pub fn content_hash(&self) -> u64 {
        self.last().map_or(0, Checked::content_hash)
    }
}
