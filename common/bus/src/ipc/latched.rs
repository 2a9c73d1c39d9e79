//! Latched topics in shared memory.

use super::event_port::EventPort;
use super::membership::{Latches, Membership};
use super::memory;
use super::node::check_memory;
use super::services;
use super::wire::{WireBlock, WireHeader};
use crate::error::{PortError, PublishError, ReceiveError};
use crate::limits::{MAX_NODES, MAX_SUBSCRIBERS};
use crate::names::TopicName;
use crate::robot_name::OfRobot;
use crate::wakeup::{EventService, Wakeup};
use iceoryx2::port::LoanError;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, PortFactory};
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::ipc_threadsafe::Service;
use messages::SampleHeader;
use std::mem::MaybeUninit;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

const BLOCK_BYTES: usize = size_of::<WireBlock>();

fn open(membership: &Membership, topic: OfRobot<TopicName>) -> Result<services::TopicService, PortError> {
    check_memory()?;
    services::topic(&membership.node, topic).open().map_err(|e| match e {
        PublishSubscribeOpenError::DoesNotExist => PortError::Missing { what: topic.to_string() },
        PublishSubscribeOpenError::ExceedsMaxNumberOfNodes => {
            PortError::Full { what: topic.to_string(), max: MAX_NODES }
        }
        e => PortError::Refused { what: topic.to_string(), reason: format!("{e:?}") },
    })
}

/// The publishing end of a topic.
pub(crate) struct TopicWriter {
    port: Publisher<Service, [WireBlock], WireHeader>,
    event_port: Arc<EventPort>,
    topic: OfRobot<TopicName>,
    populated: Mutex<PopulatedPages>,
    segment: PathBuf,
    _membership: Arc<Membership>,
}

/// Chunks of the data segment whose pages exist: making them again would cost as much as reading them.
#[derive(Default)]
struct PopulatedPages {
    /// Bytes of the longest loan: a longer one may bring a new segment, at an address that was in use before.
    longest: usize,
    /// Address and bytes.
    chunks: Vec<(usize, usize)>,
}

impl PopulatedPages {
    /// Makes the pages of a loan that do not exist yet.
    fn make(&mut self, memory: &mut [MaybeUninit<WireBlock>]) -> std::io::Result<()> {
        let (address, length) = (memory.as_ptr() as usize, size_of_val(memory));
        if self.longest < length {
            self.chunks.clear();
        }
        let known = self.chunks.iter().position(|(at, _)| *at == address);
        if known.is_some_and(|k| length <= self.chunks[k].1) {
            return Ok(());
        }
        // A failure gives pages back, also those that existed.
        known.map(|k| self.chunks.swap_remove(k));
        memory::populate(memory)?;
        self.longest = self.longest.max(length);
        self.chunks.push((address, length));
        Ok(())
    }
}

impl TopicWriter {
    pub(crate) fn open(
        membership: &Arc<Membership>,
        topic: OfRobot<TopicName>,
        length: usize,
    ) -> Result<Arc<Self>, PortError> {
        // The event port first: the event of a subscriber that joins now is received.
        let event_port = membership.event_port(EventService::Of(topic.producer()))?;
        let port = open(membership, topic)?
            .publisher_builder()
            .initial_max_slice_len(length.div_ceil(BLOCK_BYTES).max(1))
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| match e {
                PublisherCreateError::ExceedsMaxSupportedPublishers => PortError::Taken { what: topic.to_string() },
                e => PortError::Refused { what: topic.to_string(), reason: format!("{e:?}") },
            })?;
        let segment = membership
            .segment_of(port.id().value())
            .map_err(|reason| PortError::Refused { what: topic.to_string(), reason: reason.to_string() })?;
        let (populated, membership_of_port) = (Mutex::default(), Arc::clone(membership));
        let writer = Arc::new(Self { port, event_port, topic, populated, segment, _membership: membership_of_port });
        let mut writers = membership.writers.lock().unwrap_or_else(PoisonError::into_inner);
        let latches: Weak<dyn Latches> = Arc::<Self>::downgrade(&writer);
        writers.push(latches);
        Ok(writer)
    }

    /// Memory for a sample, with the bytes of earlier samples in it.
    pub(crate) fn loan(&self, length: usize) -> Result<Memory, PublishError> {
        let no_memory = || PublishError::NoMemory { length, free_bytes: memory::free_bytes() };
        // The library writes a few words into fresh memory before this function sees it.
        if memory::free_bytes() < memory::RESERVE_BYTES / 2 {
            return Err(no_memory());
        }
        let mut sample = self.port.loan_slice_uninit(length.div_ceil(BLOCK_BYTES).max(1)).map_err(|e| match e {
            LoanError::ExceedsMaxLoans => PublishError::LoanedOut { topic: self.topic.what },
            LoanError::OutOfMemory => no_memory(),
            e => PublishError::Refused { topic: self.topic.what, reason: format!("{e:?}") },
        })?;
        let mut populated = self.populated.lock().unwrap_or_else(PoisonError::into_inner);
        populated.make(sample.payload_mut()).map_err(|_| no_memory())?;
        drop(populated);
        // SAFETY: the payload is mapped and its pages exist; every bit pattern is a value of the plain `WireBlock`.
        let mut sample = unsafe { sample.assume_init() };
        let tail = length..sample.payload().len() * BLOCK_BYTES;
        bytemuck::cast_slice_mut::<_, u8>(sample.payload_mut())[tail].fill(0);
        Ok(Memory { sample })
    }

    /// Sends a sample; the number of subscribers that it went to.
    pub(crate) fn send(&self, memory: Memory, header: SampleHeader) -> Result<usize, PublishError> {
        let mut sample = memory.sample;
        *sample.user_header_mut() = WireHeader(header);
        let sent =
            sample.send().map_err(|e| PublishError::Refused { topic: self.topic.what, reason: format!("{e:?}") })?;
        self.event_port.notify(Wakeup::Data);
        Ok(sent)
    }
}

impl Latches for TopicWriter {
    fn serve_late_joiners(&self) {
        // A late joiner that cannot be connected has left.
        let _ = self.port.update_connections();
    }

    fn event_port(&self) -> Arc<EventPort> {
        Arc::clone(&self.event_port)
    }

    fn segment(&self) -> &Path {
        &self.segment
    }
}

/// Memory of a sample to be.
pub(crate) struct Memory {
    sample: SampleMut<Service, [WireBlock], WireHeader>,
}

impl Memory {
    pub(crate) fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self.sample.payload())
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        bytemuck::cast_slice_mut(self.sample.payload_mut())
    }
}

/// The receiving end of a topic.
pub(crate) struct TopicReader {
    port: Subscriber<Service, [WireBlock], WireHeader>,
    topic: OfRobot<TopicName>,
    membership: Arc<Membership>,
}

impl TopicReader {
    pub(crate) fn open(membership: &Arc<Membership>, topic: OfRobot<TopicName>) -> Result<Self, PortError> {
        let what = || topic.to_string();
        let event_port = membership.event_port(EventService::Of(topic.producer()))?;
        let service = open(membership, topic)?;
        let port = service.subscriber_builder().create().map_err(|e| match e {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                PortError::Full { what: what(), max: MAX_SUBSCRIBERS }
            }
            e => PortError::Refused { what: what(), reason: format!("{e:?}") },
        })?;
        services::leave_places(
            membership.is_guest,
            service.dynamic_config().number_of_subscribers(),
            MAX_SUBSCRIBERS,
            what,
        )?;
        // The producer delivers the last sample when this event wakes it.
        event_port.notify(Wakeup::LateJoiner);
        Ok(Self { port, topic, membership: Arc::clone(membership) })
    }

    pub(crate) fn receive(&self) -> Result<Option<TopicSample>, ReceiveError> {
        let received = self.port.receive();
        let sample =
            received.map_err(|e| ReceiveError::Refused { what: self.topic.to_string(), reason: format!("{e:?}") })?;
        Ok(sample.map(|sample| TopicSample { sample, _membership: Arc::clone(&self.membership) }))
    }
}

/// A sample that is read in place.
pub(crate) struct TopicSample {
    sample: Sample<Service, [WireBlock], WireHeader>,
    _membership: Arc<Membership>,
}

impl TopicSample {
    pub(crate) fn header(&self) -> &SampleHeader {
        &self.sample.user_header().0
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self.sample.payload())
    }
}
