//! The output of a service on a latched topic: what was published last comes again in every generation of the bus, and after a
//! full memory; what was published before comes again where a decision fails.

use crate::decision::{Decide, OutputEnd, Outputs};
use crate::failure::Failure;
use crate::request::Published;
use crate::state::Epochs;
use bus::{Bus, Origin, Publisher, Topic};
use messages::{ArchiveBuffer, Checked, ContentHash, InputHashes};
use std::sync::Arc;
use tracing::warn;

/// Room that is reserved for a topic of which nothing was published yet.
const FIRST_BYTES: usize = 1 << 16;

/// A topic, and what was published on it last.
///
/// The archive stays in the heap, and is copied into shared memory: it has to outlive the generations of the bus, and is
/// compared with the next one. So it is for all topics but grids and their index, which have publishers of their own.
pub struct LatchedOutput<T: Topic> {
    topic: T,
    bus: Option<Bus>,
    publisher: Option<Publisher<T>>,
    last: Option<Last<T>>,
    is_pending: bool,
    /// What was there before the decision that is underway; `None` where that changes nothing here.
    before: Option<Before<T>>,
}

/// An archive for a topic.
pub struct NewSample<T: Topic> {
    /// The archive, which may be on its way to the disk as well.
    pub archive: Arc<Checked<T::Payload>>,
    /// Counts the changes of the site's map frame.
    pub frame_epoch: u64,
    /// What it was made from.
    pub inputs: InputHashes,
}

/// What an output was.
struct Before<T: Topic> {
    last: Option<Last<T>>,
    is_pending: bool,
}

/// What came last. Its epoch is taken when it is first to be published; a disk that is full refuses it.
struct Last<T: Topic> {
    archive: Arc<Checked<T::Payload>>,
    epoch: Option<u64>,
    frame_epoch: u64,
    inputs: InputHashes,
}

impl<T: Topic> LatchedOutput<T> {
    /// Nothing was published yet.
    pub fn new(topic: T) -> Self {
        Self { topic, bus: None, publisher: None, last: None, is_pending: false, before: None }
    }

    /// Opens the end of the topic, if there is a bus and it is not open.
    fn open(&mut self) -> Result<(), Failure> {
        if let (Some(bus), None) = (&self.bus, &self.publisher) {
            let length = self.last.as_ref().map_or(FIRST_BYTES, |last| last.archive.bytes().bytes().len());
            self.publisher = Some(bus.publisher(self.topic, length)?);
        }
        Ok(())
    }

    /// Takes what came last from the bus, with its memory.
    pub fn withdraw(&mut self) {
        (self.publisher, self.last, self.before, self.is_pending) = (None, None, None, false);
    }

    /// Publishes an archive under the next epoch; before the bus is there it waits for it. The one before can
    /// [come back](OutputEnd::go_back) until this one is [settled](OutputEnd::settle).
    ///
    /// # Errors
    /// As [`OutputEnd::retry`]. The archive is pending.
    pub fn publish(&mut self, epochs: &mut Epochs, sample: NewSample<T>) -> Result<(), Failure> {
        let NewSample { archive, frame_epoch, inputs } = sample;
        let last = self.last.replace(Last { archive, epoch: None, frame_epoch, inputs });
        self.before = Some(Before { last, is_pending: self.is_pending });
        self.is_pending = true;
        self.retry(epochs)
    }

    /// Publishes an archive under the next epoch, without a way back.
    ///
    /// # Errors
    /// As [`Self::publish`].
    pub fn publish_for_good(&mut self, epochs: &mut Epochs, sample: NewSample<T>) -> Result<(), Failure> {
        let published = self.publish(epochs, sample);
        self.settle();
        published
    }

    /// What came last.
    pub fn last(&self) -> Option<&Checked<T::Payload>> {
        self.last.as_ref().map(|last| &*last.archive)
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
        Published { content_hash: self.last().map_or(ContentHash::NONE, Checked::content_hash), epoch: self.epoch() }
    }
}

impl<T: Topic> OutputEnd for LatchedOutput<T> {
    fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure> {
        // The end of the earlier generation first: there is one publisher.
        self.publisher = None;
        self.bus = Some(bus.clone());
        self.open()?;
        self.is_pending = self.last.is_some();
        if let Err(why) = self.retry(epochs) {
            warn!(error = crate::chain(why.as_ref()), "what was published last has no room yet");
        }
        Ok(())
    }

    fn settle(&mut self) {
        self.before = None;
    }

    /// On the bus it comes under another epoch where the bus has the last sample.
    fn go_back(&mut self, epochs: &mut Epochs) {
        let Some(before) = self.before.take() else { return };
        let is_on_bus = !self.is_pending;
        (self.last, self.is_pending) = (before.last, before.is_pending);
        if let Some(last) = self.last.as_mut().filter(|_| is_on_bus) {
            (last.epoch, self.is_pending) = (None, true);
            if let Err(why) = self.retry(epochs) {
                warn!(error = crate::chain(why.as_ref()), "what was published before has no room yet");
            }
        }
    }

    fn is_pending(&self) -> bool {
        self.is_pending
    }

    fn retry(&mut self, epochs: &mut Epochs) -> Result<(), Failure> {
        if self.is_pending {
            self.open()?;
        }
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
}

/// The output of a daemon with one topic.
pub struct OneTopic<T: Topic>(pub LatchedOutput<T>);

impl<D: Decide + ?Sized, T: Topic> Outputs<D> for OneTopic<T> {
    type Publication = NewSample<T>;

    fn ends(&mut self) -> Vec<&mut dyn OutputEnd> {
        vec![&mut self.0]
    }

    fn publish(&mut self, sample: NewSample<T>, _: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        self.0.publish(epochs, sample)
    }

    fn published(&self) -> Published {
        self.0.published()
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
        let archive =
            Checked::new(ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), 3, 1).finish()).unwrap();
        let sample = NewSample { archive: Arc::new(archive), frame_epoch: 1, inputs: InputHashes::default() };
        assert!(output.publish(&mut epochs, sample).is_err());
        output.settle();
        assert!(output.is_pending() && output.epoch() == 0 && states.take().unwrap().is_none());

        std::fs::create_dir(&state).unwrap();
        output.retry(&mut epochs).unwrap();
        waiter.wait(Duration::ZERO).unwrap();
        let sample = states.take().unwrap().unwrap();
        assert!(!output.is_pending() && sample.header().epoch == output.epoch() && output.epoch() > 0);
        assert_eq!(sample.check().unwrap().content_hash(), output.published().content_hash);
    }
}
