//! Latched topics: archives written in place by the publisher and read in place by subscribers, last sample included for late
//! joiners.

use crate::error::{PublishError, ReceiveError};
use crate::limits::{MAX_HELD, MAX_SAMPLE_BYTES};
use crate::link::{LoanMemory, SampleMemory, TopicSource, TopicTarget};
use crate::names::TopicName;
use crate::stamp::Stamp;
use crate::topics::Topic;
use messages::{ArchiveError, ArchiveWriter, Checked, ContentHash, InputHashes, Payload, Preamble, SampleHeader};
use std::fmt;
use std::marker::PhantomData;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What the publisher says about a sample; the rest of the header comes from the archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Origin {
    /// Number of the sample; it also rises across restarts of the producer.
    pub epoch: u64,
    /// Counts the changes of the site's map frame.
    pub frame_epoch: u64,
    /// What it was made from.
    pub inputs: InputHashes,
}

/// The publishing end of a topic. The only one: a second is refused.
///
/// The last sample stays available to late joiners until the publisher is dropped, while its process waits on the bus's
/// [`crate::Waiter`], which serves them.
pub struct Publisher<T> {
    topic: T,
    port: TopicTarget,
    last_epoch: AtomicU64,
}

impl<T: Topic> Publisher<T> {
    pub(crate) fn new(topic: T, port: TopicTarget) -> Self {
        Self { topic, port, last_epoch: AtomicU64::new(0) }
    }

    /// The topic.
    pub fn topic(&self) -> T {
        self.topic
    }

    /// Memory for an archive of at most `length` bytes, at a multiple of 64. One loan at a time.
    ///
    /// The bytes are those of earlier samples: the writer writes every byte of its archive. More than ever before makes
    /// a larger segment; about 48 such steps are possible in the life of a publisher, each at least doubles it.
    ///
    /// # Errors
    /// No room in shared memory, a loan that is still out, more than [`MAX_SAMPLE_BYTES`]. The last sample stays.
    pub fn loan(&self, length: usize) -> Result<Loan<'_, T>, PublishError> {
        if length > MAX_SAMPLE_BYTES {
            return Err(PublishError::TooLarge { length, max: MAX_SAMPLE_BYTES });
        }
        let memory = self.port.loan(length)?;
        Ok(Loan { publisher: self, length, memory })
    }

    /// Publishes an archive that is written into the loan.
    ///
    /// # Errors
    /// As [`Publisher::loan`] and [`Loan::publish`].
    pub fn publish(
        &self,
        archive: &impl ArchiveWriter<Payload = T::Payload>,
        origin: Origin,
    ) -> Result<Sent, PublishError> {
        let mut loan = self.loan(archive.length())?;
        archive.write(loan.bytes_mut());
        loan.publish(origin)
    }

    /// Publishes a copy of an archive that is in the heap or in a file.
    ///
    /// # Errors
    /// As [`Publisher::loan`] and [`Loan::publish`].
    pub fn publish_copy(&self, archive: &[u8], origin: Origin) -> Result<Sent, PublishError> {
        let mut loan = self.loan(archive.len())?;
        loan.bytes_mut().copy_from_slice(archive);
        loan.publish(origin)
    }
}

/// What was published.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sent {
    /// Hash of the archive's content.
    pub content_hash: ContentHash,
    /// Subscribers that it went to.
    pub n_subscribers: usize,
}

/// Memory of a sample to be; dropping it gives it back.
pub struct Loan<'a, T> {
    publisher: &'a Publisher<T>,
    length: usize,
    memory: LoanMemory<'a>,
}

impl<T: Topic> Loan<'_, T> {
    /// The memory.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.memory.bytes_mut()[..self.length]
    }

    fn bytes(&self) -> &[u8] {
        &self.memory.bytes()[..self.length]
    }

    /// Publishes the archive that was written.
    ///
    /// # Errors
    /// Bytes that do not begin as an archive of the topic, an epoch below the last one. The last sample stays.
    pub fn publish(self, origin: Origin) -> Result<Sent, PublishError> {
        let Publisher { topic, last_epoch, .. } = self.publisher;
        let (topic, kind) = (topic.name(), T::Payload::KIND);
        let preamble = Preamble::of(self.bytes(), kind);
        let preamble = *preamble.map_err(|source| PublishError::Archive { topic, source })?;
        let header = SampleHeader {
            epoch: origin.epoch,
            stamp_ns: Stamp::now().0,
            payload_length: preamble.length,
            content_hash: preamble.content_hash,
            frame_epoch: origin.frame_epoch,
            inputs: origin.inputs,
            ..SampleHeader::of(kind)
        };
        let last = last_epoch.load(Ordering::Acquire);
        if origin.epoch < last {
            return Err(PublishError::EpochFell { topic, epoch: origin.epoch, last });
        }
        let n_subscribers = self.memory.send(header)?;
        last_epoch.store(origin.epoch, Ordering::Release);
        Ok(Sent { content_hash: preamble.content_hash, n_subscribers })
    }
}

/// The receiving end of a topic that is known by name only: for tools.
pub struct RawSubscriber {
    topic: TopicName,
    port: TopicSource,
    last_epoch: Mutex<u64>,
    held: Arc<AtomicUsize>,
}

impl RawSubscriber {
    pub(crate) fn new(topic: TopicName, port: TopicSource) -> Self {
        Self { topic, port, last_epoch: Mutex::new(0), held: Arc::default() }
    }

    /// The topic.
    pub fn topic(&self) -> TopicName {
        self.topic
    }

    /// The newest sample that was not taken yet; `None` if there is none. Samples in between are left out.
    ///
    /// A restarted publisher sends its last sample again, with the same epoch.
    ///
    /// # Errors
    /// A sample of another layout or topic, an epoch below the last one, [`MAX_HELD`] samples in hand. The sample is
    /// left out; what was taken before stays valid.
    pub fn take(&self) -> Result<Option<RawSample>, ReceiveError> {
        let held = self.held.load(Ordering::Acquire);
        if held >= MAX_HELD {
            return Err(ReceiveError::TooManyHeld { topic: self.topic, held });
        }
        let mut last_epoch = self.last_epoch.lock().unwrap_or_else(PoisonError::into_inner);
        let mut newest: Option<SampleMemory> = None;
        // One more may come from each publisher that died since the last look; few ever do.
        while let Some(memory) = self.port.receive()? {
            if newest.as_ref().is_none_or(|n| n.header().epoch <= memory.header().epoch) {
                newest = Some(memory);
            }
        }
        let Some(memory) = newest else { return Ok(None) };
        let header = *memory.header();
        header
            .check(self.topic.kind(), memory.bytes().len())
            .map_err(|source| ReceiveError::Sample { topic: self.topic, source })?;
        if header.epoch < *last_epoch {
            return Err(ReceiveError::EpochFell { topic: self.topic, epoch: header.epoch, last: *last_epoch });
        }
        *last_epoch = header.epoch;
        self.held.fetch_add(1, Ordering::AcqRel);
        Ok(Some(RawSample { topic: self.topic, memory, held: Arc::clone(&self.held) }))
    }
}

/// A sample, read in place: its memory does not change while this is held, also if its publisher dies. What comes from
/// the relay is a copy.
pub struct RawSample {
    topic: TopicName,
    memory: SampleMemory,
    held: Arc<AtomicUsize>,
}

impl RawSample {
    /// Its topic.
    pub fn topic(&self) -> TopicName {
        self.topic
    }

    /// The sample as one of this topic; `None` if it is of another.
    pub fn of<T: Topic>(self, topic: T) -> Option<Sample<T>> {
        (self.topic == topic.name()).then_some(Sample { raw: self, topic: PhantomData })
    }

    /// Its header.
    pub fn header(&self) -> &SampleHeader {
        self.memory.header()
    }

    /// The archive, at a multiple of 64. Not validated yet.
    pub fn bytes(&self) -> &[u8] {
        // The length was checked when the sample was taken.
        &self.memory.bytes()[..self.header().payload_length as usize]
    }
}

impl AsRef<[u8]> for RawSample {
    fn as_ref(&self) -> &[u8] {
        self.bytes()
    }
}

impl Drop for RawSample {
    fn drop(&mut self) {
        self.held.fetch_sub(1, Ordering::AcqRel);
    }
}

impl fmt::Debug for RawSample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RawSample").field("header", self.header()).finish_non_exhaustive()
    }
}

/// The receiving end of a topic.
pub struct Subscriber<T> {
    raw: RawSubscriber,
    topic: T,
}

impl<T: Topic> Subscriber<T> {
    pub(crate) fn new(topic: T, raw: RawSubscriber) -> Self {
        Self { raw, topic }
    }

    /// The topic.
    pub fn topic(&self) -> T {
        self.topic
    }

    /// The newest sample that was not taken yet, see [`RawSubscriber::take`].
    ///
    /// # Errors
    /// As there.
    pub fn take(&self) -> Result<Option<Sample<T>>, ReceiveError> {
        Ok(self.raw.take()?.and_then(|raw| raw.of(self.topic)))
    }
}

/// A sample of a topic, read in place. It was received, and not validated yet.
pub struct Sample<T> {
    raw: RawSample,
    topic: PhantomData<fn() -> T>,
}

/// A sample whose archive was validated once.
pub type CheckedSample<T> = Checked<<T as Topic>::Payload, Sample<T>>;

impl<T: Topic> Sample<T> {
    /// Validates the archive, which hashes it: on a worker's thread, and once.
    ///
    /// # Errors
    /// Bytes that are no whole archive of the topic.
    pub fn check(self) -> Result<CheckedSample<T>, ArchiveError> {
        Checked::new(self)
    }

    /// Its header.
    pub fn header(&self) -> &SampleHeader {
        self.raw.header()
    }

    /// The archive, at a multiple of 64.
    pub fn bytes(&self) -> &[u8] {
        self.raw.bytes()
    }
}

impl<T: Topic> AsRef<[u8]> for Sample<T> {
    fn as_ref(&self) -> &[u8] {
        self.bytes()
    }
}

impl<T> fmt::Debug for Sample<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.raw.fmt(f)
    }
}
