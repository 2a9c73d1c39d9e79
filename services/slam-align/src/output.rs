//! A topic that is published when what it carries differs.

use bus::{Bus, Origin, Publisher, Topic};
use daemon::{Epochs, Failure};
use messages::ArchiveBuffer;

/// A topic, and what was published last.
pub(crate) struct Output {
    topic: Topic,
    publisher: Option<Publisher>,
    pub(crate) last: Option<(ArchiveBuffer, Origin)>,
}

impl Output {
    /// Nothing was published yet.
    pub(crate) fn new(topic: Topic) -> Self {
        Self { topic, publisher: None, last: None }
    }

    /// Joins a generation of the bus, and brings it what was published last.
    pub(crate) fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.publisher = None;
        let publisher = bus.publisher(self.topic, self.last.as_ref().map_or(1 << 14, |(a, _)| a.bytes().len()))?;
        if let Some((archive, origin)) = &self.last {
            publisher.publish_copy(archive.bytes(), *origin)?;
        }
        self.publisher = Some(publisher);
        Ok(())
    }

    /// Publishes what differs from what is published; true if it did.
    pub(crate) fn publish(
        &mut self,
        archive: ArchiveBuffer,
        epochs: &mut Epochs,
        origin: Origin,
    ) -> Result<bool, Failure> {
        let Some(publisher) = &self.publisher else { return Ok(false) };
        if self.last.as_ref().is_some_and(|(last, _)| last.bytes() == archive.bytes()) {
            return Ok(false);
        }
        let origin = Origin { epoch: epochs.take()?, ..origin };
        publisher.publish_copy(archive.bytes(), origin)?;
        self.last = Some((archive, origin));
        Ok(true)
    }
}
