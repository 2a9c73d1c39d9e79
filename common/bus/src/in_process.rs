//! A bus in the heap of one process: latched topics and heartbeats without shared memory, threads and files, for simulations
//! of a whole site.

use crate::bounded_queue::push_bounded;
use crate::error::{PortError, PublishError};
use crate::limits::STATUS_BUFFER;
use crate::names::{Daemon, TopicName};
use crate::robot_name::{OfRobot, RobotName};
use messages::{ArchiveBuffer, SampleHeader, StatusRecord};
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::panic::panic_any;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// A bus inside one process, for tests that simulate a site: the services of its daemons take turns, and what one of them
/// publishes is there for the others at once.
///
/// Topics and heartbeats are as in shared memory, with the same ports: [`crate::Bus::in_process`] joins. There is no
/// [`crate::Waiter`], so that nothing wakes a participant; it asks its ports. There are no commands, and any number of
/// participants. A bus costs a few allocations, and nothing of it outlives its ports. Clones are the same bus.
///
/// ```
/// use bus::{Bus, Daemon, InProcessBus, Origin, topics};
/// use messages::{ContentHash, InputHashes, ScheduleStateBuilder};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let site = InProcessBus::new();
/// let producer = Bus::in_process(&site, Daemon::ScheduleEval);
/// let schedule_states = producer.publisher(topics::ScheduleState, 4096)?;
/// let origin = Origin { epoch: 1, frame_epoch: 0, inputs: InputHashes::default() };
/// schedule_states.publish(&ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), 3, 1), origin)?;
///
/// let late = Bus::in_process(&site, Daemon::Rasterize).subscriber(topics::ScheduleState)?;
/// let sample = late.take()?.expect("the last sample is there");
/// assert_eq!(sample.check()?.view().n_elements(), 3);
///
/// site.set_full(true);
/// assert!(schedule_states.loan(4096).is_err());
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct InProcessBus(Arc<Shared>);

struct Shared {
    generation: u64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    topics: BTreeMap<OfRobot<TopicName>, TopicState>,
    /// Of the site, and of each robot.
    heartbeats: Vec<(Option<RobotName>, Weak<Heartbeats>)>,
    is_full: bool,
    /// Loans that are given until one fails.
    n_loans_until_failure: Option<usize>,
    /// Loans that are given until the process that asks for one dies.
    n_loans_until_death: Option<usize>,
}

/// What a process that dies at a loan panics with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeathAtLoan;

#[derive(Default)]
struct TopicState {
    has_publisher: bool,
    last: Option<Arc<TopicSample>>,
    readers: Vec<Weak<Slot>>,
}

/// The newest sample that one reader did not take.
type Slot = Mutex<Option<Arc<TopicSample>>>;

/// Heartbeats that one reader did not take.
type Heartbeats = Mutex<VecDeque<StatusRecord>>;

impl Default for InProcessBus {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Debug for InProcessBus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InProcessBus").field("generation", &self.generation()).finish_non_exhaustive()
    }
}

impl InProcessBus {
    /// A bus of its own, in its first generation.
    pub fn new() -> Self {
        Self::of_generation(1)
    }

    /// The next generation of this bus: without samples, publishers and faults. Who takes part is to drop its ports and to
    /// join this one; ports of the earlier generation see nothing of it.
    pub fn next_generation(&self) -> Self {
        Self::of_generation(self.generation() + 1)
    }

    fn of_generation(generation: u64) -> Self {
        Self(Arc::new(Shared { generation, state: Mutex::default() }))
    }

    /// Its generation, from 1.
    pub fn generation(&self) -> u64 {
        self.0.generation
    }

    /// Fills the memory, or makes room again. While it is full each loan fails with [`PublishError::NoMemory`], and no
    /// heartbeat is sent; samples that were published stay.
    pub fn set_full(&self, is_full: bool) {
        self.0.lock().is_full = is_full;
    }

    /// Lets one publication fail after `n` more loans were given: its loan fails with [`PublishError::NoMemory`], and there
    /// is room again for the next one. A later call takes the place of an earlier one; a loan that fails for another reason
    /// does not count.
    ///
    /// Where threads publish at once, as `rasterize` does with the grids of several storeys, any of them may be the one.
    pub fn fail_publish_after(&self, n: usize) {
        self.0.lock().n_loans_until_failure = Some(n);
    }

    /// Lets the process that publishes after `n` more loans were given die at that: its loan panics with [`DeathAtLoan`], which a test
    /// catches before it drops what the process had. A later call takes the place of an earlier one; `None` lets all live.
    pub fn die_at_publish_after(&self, n: Option<usize>) {
        self.0.lock().n_loans_until_death = n;
    }

    pub(crate) fn topic_writer(&self, topic: OfRobot<TopicName>) -> Result<TopicWriter, PortError> {
        let mut state = self.0.lock();
        let topic_state = state.topics.entry(topic).or_default();
        if topic_state.has_publisher {
            return Err(PortError::Taken { what: topic.to_string() });
        }
        topic_state.has_publisher = true;
        Ok(TopicWriter { bus: Arc::clone(&self.0), topic, is_lent: AtomicBool::new(false), samples: Mutex::default() })
    }

    pub(crate) fn topic_reader(&self, topic: OfRobot<TopicName>) -> TopicReader {
        let mut state = self.0.lock();
        let topic_state = state.topics.entry(topic).or_default();
        let slot = Arc::new(Mutex::new(topic_state.last.clone()));
        // Here too, so that readers that come and go do not pile up on a topic without publications.
        topic_state.readers.retain(|slot| slot.strong_count() > 0);
        topic_state.readers.push(Arc::downgrade(&slot));
        TopicReader { slot }
    }

    pub(crate) fn status_target(&self, robot: Option<RobotName>) -> StatusTarget {
        StatusTarget { bus: Arc::clone(&self.0), robot }
    }

    pub(crate) fn status_source(&self, robot: Option<RobotName>) -> StatusSource {
        let heartbeats = Arc::default();
        let mut state = self.0.lock();
        state.heartbeats.retain(|(_, heartbeats)| heartbeats.strong_count() > 0);
        state.heartbeats.push((robot, Arc::downgrade(&heartbeats)));
        StatusSource { heartbeats }
    }

    /// Why a daemon has no ends of commands here.
    pub(crate) fn no_commands(daemon: OfRobot<Daemon>) -> PortError {
        let reason = "a bus inside one process has no commands".to_owned();
        PortError::Refused { what: daemon.command(), reason }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// True if there is room for a loan, which counts as given.
    fn take_room(&mut self) -> bool {
        if self.is_full {
            return false;
        }
        let [fails, dies] = [&mut self.n_loans_until_failure, &mut self.n_loans_until_death].map(|left| {
            let is_now = *left == Some(0);
            *left = left.and_then(|n| n.checked_sub(1));
            is_now
        });
        if dies {
            panic_any(DeathAtLoan);
        }
        !fails
    }
}

/// The publishing end of a topic.
pub(crate) struct TopicWriter {
    bus: Arc<Shared>,
    topic: OfRobot<TopicName>,
    is_lent: AtomicBool,
    /// What it published. The memory of a sample that is held by nobody else is lent again with the bytes in it, as in shared
    /// memory.
    samples: Mutex<Vec<Arc<TopicSample>>>,
}

impl TopicWriter {
    /// Memory for a sample of `length` bytes.
    pub(crate) fn loan(&self, length: usize) -> Result<Loan<'_>, PublishError> {
        if self.is_lent.swap(true, Ordering::AcqRel) {
            return Err(PublishError::LoanedOut { topic: self.topic.what });
        }
        // From here on a failure gives the loan back.
        let mut loan = Loan { writer: self, memory: ArchiveBuffer::default() };
        if !self.bus.lock().take_room() {
            return Err(PublishError::NoMemory { length, free_bytes: 0 });
        }
        loan.memory = self.free_memory(length).unwrap_or_else(|| ArchiveBuffer::zeroed(length));
        Ok(loan)
    }

    /// The memory of an earlier sample of this length that nobody holds; that of other lengths is given up.
    fn free_memory(&self, length: usize) -> Option<ArchiveBuffer> {
        let mut samples = self.samples();
        samples.retain(|sample| Arc::strong_count(sample) > 1 || sample.memory.bytes().len() == length);
        let place = samples.iter().position(|sample| Arc::strong_count(sample) == 1)?;
        Arc::into_inner(samples.swap_remove(place)).map(|sample| sample.memory)
    }

    fn samples(&self) -> MutexGuard<'_, Vec<Arc<TopicSample>>> {
        self.samples.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for TopicWriter {
    fn drop(&mut self) {
        let mut state = self.bus.lock();
        let topic_state = state.topics.entry(self.topic).or_default();
        (topic_state.has_publisher, topic_state.last) = (false, None);
    }
}

/// Memory of a sample to be; dropping it gives it back.
pub(crate) struct Loan<'a> {
    writer: &'a TopicWriter,
    memory: ArchiveBuffer,
}

impl Loan<'_> {
    pub(crate) fn bytes(&self) -> &[u8] {
        self.memory.bytes()
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        self.memory.bytes_mut()
    }

    /// Gives the sample to all subscribers; how many there are.
    pub(crate) fn send(mut self, header: SampleHeader) -> usize {
        let sample = Arc::new(TopicSample { header, memory: std::mem::take(&mut self.memory) });
        self.writer.samples().push(Arc::clone(&sample));
        let mut state = self.writer.bus.lock();
        let topic_state = state.topics.entry(self.writer.topic).or_default();
        topic_state.readers.retain(|slot| slot.strong_count() > 0);
        for slot in topic_state.readers.iter().filter_map(Weak::upgrade) {
            let mut newest = slot.lock().unwrap_or_else(PoisonError::into_inner);
            // A publisher that comes again with a lower epoch takes nothing away.
            if newest.as_ref().is_none_or(|newest| newest.header.epoch <= header.epoch) {
                *newest = Some(Arc::clone(&sample));
            }
        }
        topic_state.last = Some(sample);
        topic_state.readers.len()
    }
}

impl Drop for Loan<'_> {
    fn drop(&mut self) {
        self.writer.is_lent.store(false, Ordering::Release);
    }
}

/// The receiving end of a topic.
pub(crate) struct TopicReader {
    slot: Arc<Slot>,
}

impl TopicReader {
    /// The newest sample that was not taken.
    pub(crate) fn receive(&self) -> Option<Arc<TopicSample>> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// A sample in the heap.
pub(crate) struct TopicSample {
    header: SampleHeader,
    memory: ArchiveBuffer,
}

impl TopicSample {
    pub(crate) fn header(&self) -> &SampleHeader {
        &self.header
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.memory.bytes()
    }
}

/// The sending end of the status stream.
pub(crate) struct StatusTarget {
    bus: Arc<Shared>,
    robot: Option<RobotName>,
}

impl StatusTarget {
    /// False if it could not be sent.
    pub(crate) fn send(&self, record: StatusRecord) -> bool {
        let state = self.bus.lock();
        if state.is_full {
            return false;
        }
        let own = state.heartbeats.iter().filter(|(robot, _)| *robot == self.robot);
        for heartbeats in own.filter_map(|(_, heartbeats)| heartbeats.upgrade()) {
            push_bounded(&mut heartbeats.lock().unwrap_or_else(PoisonError::into_inner), record, STATUS_BUFFER);
        }
        true
    }
}

/// The receiving end of the status stream.
pub(crate) struct StatusSource {
    heartbeats: Arc<Heartbeats>,
}

impl StatusSource {
    pub(crate) fn receive(&self) -> Option<StatusRecord> {
        self.heartbeats.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::Bus;
    use crate::error::ReceiveError;
    use crate::latched::{Origin, Publisher, Sent, Subscriber};
    use crate::topics::{Grids, ScheduleState};
    use messages::{ArchiveWriter, ContentHash, InputHashes, ScheduleStateBuilder};

    fn publisher(bus: &InProcessBus) -> Publisher<ScheduleState> {
        Bus::in_process(bus, Daemon::ScheduleEval).publisher(ScheduleState, 64).unwrap()
    }

    fn subscriber(bus: &InProcessBus) -> Subscriber<ScheduleState> {
        Bus::in_process(bus, Daemon::Rasterize).subscriber(ScheduleState).unwrap()
    }

    fn state(n_elements: usize) -> ScheduleStateBuilder {
        ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), n_elements, 1)
    }

    fn publish(publisher: &Publisher<ScheduleState>, epoch: u64) -> Result<Sent, PublishError> {
        publisher.publish(&state(3), Origin { epoch, frame_epoch: 0, inputs: InputHashes::default() })
    }

    /// The epoch of what a subscriber takes; 0 if there is nothing.
    fn taken(subscriber: &Subscriber<ScheduleState>) -> u64 {
        subscriber.take().unwrap().map_or(0, |sample| sample.header().epoch)
    }

    #[test]
    fn a_late_joiner_gets_the_last_sample_until_its_publisher_is_dropped() {
        let bus = InProcessBus::new();
        let states = publisher(&bus);
        publish(&states, 1).unwrap();
        publish(&states, 2).unwrap();
        let (late, slow) = (subscriber(&bus), subscriber(&bus));
        assert_eq!([taken(&late), taken(&late)], [2, 0], "a sample is taken once");
        assert!(matches!(
            Bus::in_process(&bus, Daemon::ScheduleEval).publisher(ScheduleState, 64).map(drop),
            Err(PortError::Taken { .. })
        ));
        drop(states);
        assert_eq!([taken(&subscriber(&bus)), taken(&slow)], [0, 2], "what has come stays");
        publish(&publisher(&bus), 2).unwrap();
        assert_eq!([taken(&late), taken(&slow)], [2, 2], "what is published again comes again");
    }

    #[test]
    fn the_newest_sample_is_that_of_the_highest_epoch() {
        let bus = InProcessBus::new();
        let (quick, slow) = (subscriber(&bus), subscriber(&bus));
        assert_eq!(publish(&publisher(&bus), 7).unwrap().n_subscribers, 2);
        assert_eq!(taken(&quick), 7);
        let states = publisher(&bus);
        publish(&states, 3).unwrap();
        assert!(matches!(quick.take(), Err(ReceiveError::EpochFell { epoch: 3, last: 7, .. })));
        assert_eq!([taken(&slow), taken(&subscriber(&bus))], [7, 3]);
        assert!(matches!(publish(&states, 2), Err(PublishError::EpochFell { epoch: 2, last: 3, .. })));
        drop(quick);
        assert_eq!(publish(&states, 8).unwrap().n_subscribers, 1);
        assert_eq!(taken(&slow), 8);
    }

    #[test]
    fn full_memory_refuses_loans_and_heartbeats_until_there_is_room() {
        let bus = InProcessBus::new();
        let (states, subscriber) = (publisher(&bus), subscriber(&bus));
        let (status, heartbeats) = (bus.status_target(None), bus.status_source(None));
        let record: StatusRecord = bytemuck::Zeroable::zeroed();
        publish(&states, 1).unwrap();
        bus.set_full(true);
        for _ in 0..2 {
            let refused = publish(&states, 2);
            assert!(matches!(refused, Err(PublishError::NoMemory { free_bytes: 0, .. })), "{refused:?}");
        }
        assert!(!status.send(record) && heartbeats.receive().is_none());
        assert_eq!(taken(&subscriber), 1, "what was published stays");
        bus.set_full(false);
        publish(&states, 2).unwrap();
        assert!(status.send(record) && heartbeats.receive().is_some());
        assert_eq!(taken(&subscriber), 2);
    }

    #[test]
    fn one_publication_fails_after_a_number_of_others() {
        for n in 0..4 {
            let bus = InProcessBus::new();
            let states = publisher(&bus);
            let index = Bus::in_process(&bus, Daemon::Rasterize).publisher(Grids, 64).unwrap();
            bus.fail_publish_after(n);
            let loan = states.loan(64).map(drop);
            assert_eq!(loan.is_err(), n == 0);
            // All topics count, and a second loan of a publisher does not.
            let lent = index.loan(64);
            assert_eq!(lent.is_err(), n == 1);
            if lent.is_ok() {
                assert!(matches!(index.loan(64).map(drop), Err(PublishError::LoanedOut { .. })));
            }
            let has_failed: Vec<bool> = (1..=3).map(|epoch| publish(&states, epoch).is_err()).collect();
            assert_eq!(has_failed, [n == 2, n == 3, false]);
        }
    }

    #[test]
    fn memory_is_lent_again_once_its_sample_is_dropped() {
        let bus = InProcessBus::new();
        let (states, subscriber) = (publisher(&bus), subscriber(&bus));
        let is_used = |length: usize| states.loan(length).unwrap().bytes_mut().iter().any(|byte| *byte != 0);
        let length = state(3).length();
        publish(&states, 1).unwrap();
        let held = subscriber.take().unwrap().unwrap();
        let before = held.bytes().to_vec();
        assert!(!is_used(length), "the last sample is held");
        publish(&states, 2).unwrap();
        assert!(!is_used(length), "both are held: by its subscriber, and for late joiners");
        assert_eq!(held.bytes(), before);
        assert_eq!(held.bytes().as_ptr() as usize % 64, 0);
        drop(held);
        assert!(!is_used(length + 64), "it is of another length");
        publish(&states, 3).unwrap();
        assert_eq!(taken(&subscriber), 3);
        publish(&states, 4).unwrap();
        assert!(is_used(length), "nobody holds the third one");
    }

    #[test]
    fn generations_and_buses_know_nothing_of_each_other() {
        let bus = InProcessBus::new();
        let states = publisher(&bus);
        publish(&states, 1).unwrap();
        bus.set_full(true);
        let next = bus.next_generation();
        assert_eq!([bus.generation(), next.generation(), InProcessBus::new().generation()], [1, 2, 1]);
        assert_eq!(Bus::in_process(&next, Daemon::Robot).generation(), 2);
        assert_eq!([taken(&subscriber(&bus)), taken(&subscriber(&next))], [1, 0]);
        publish(&publisher(&next), 1).unwrap();
    }

    #[test]
    fn there_are_no_commands() {
        let bus = Bus::in_process(&InProcessBus::new(), Daemon::ScheduleEval);
        let refused = [bus.command_server().map(drop), bus.command_client(Daemon::ScheduleEval).map(drop)];
        for refused in refused {
            let words = refused.unwrap_err().to_string();
            assert!(
                words.contains("`command/schedule-eval` cannot be opened: a bus inside one process has no"),
                "{words}"
            );
        }
    }
}
