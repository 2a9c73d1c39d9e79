//! Topics that clients of the relay follow: one subscription for all, and a sealed copy of the newest sample.
//!
//! The system counts a copy as memory of the relay for as long as anybody has it open. The relay closes its own end when
//! a newer one is there; what a client keeps open behind its back it neither sees nor takes back.

use super::event::RelayEvent;
use crate::bus::Bus;
use crate::error::PortError;
use crate::latched::{RawSample, RawSubscriber};
use crate::names::TopicName;
use crate::relay_protocol::{FromRelay, seal};
use crate::robot_name::OfRobot;
use messages::SampleHeader;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A topic is kept for this long after its last client: one that comes and goes costs its producer nothing, and no copy.
const KEPT_FOR: Duration = Duration::from_secs(10);

/// Interval at which a sample that could not be copied is tried again.
const RETRY: Duration = Duration::from_secs(1);

/// Makes the memory that clients may read.
type Seal = Box<dyn Fn(&[u8]) -> io::Result<OwnedFd> + Send>;

/// Topics that somebody follows.
pub(super) struct Feeds {
    feeds: BTreeMap<OfRobot<TopicName>, Feed>,
    /// Counts the news of all topics: no two have the same number.
    n_news: u64,
    seal: Seal,
}

struct Feed {
    subscriber: RawSubscriber,
    followed: Instant,
    /// The last sample that could be copied, and its number.
    newest: Option<(u64, Copied)>,
    /// Why a later one is not there, and the number of that news.
    failure: Option<(u64, String)>,
    /// A sample that is to be copied, from that moment.
    waiting: Option<(RawSample, Instant)>,
}

/// A sample in memory that clients may read.
struct Copied {
    header: SampleHeader,
    memory: Arc<OwnedFd>,
}

impl Default for Feeds {
    fn default() -> Self {
        Self::with_seal(Box::new(|bytes| seal("groundplan-sample", bytes)))
    }
}

impl Feeds {
    pub(super) fn with_seal(seal: Seal) -> Self {
        Self { feeds: BTreeMap::new(), n_news: 0, seal }
    }

    /// Follows a topic; `bus` means the robot whose it is.
    pub(super) fn follow(&mut self, bus: &Bus, topic: OfRobot<TopicName>) -> Result<(), PortError> {
        if let Entry::Vacant(place) = self.feeds.entry(topic) {
            let subscriber = bus.raw_subscriber(topic.what)?;
            place.insert(Feed { subscriber, followed: Instant::now(), newest: None, failure: None, waiting: None });
        }
        Ok(())
    }

    /// Takes what has come on topics that are used, and gives up those that nobody has followed for a while.
    pub(super) fn take(
        &mut self,
        is_used: impl Fn(OfRobot<TopicName>) -> bool,
        now: Instant,
        on_event: &mut dyn FnMut(RelayEvent<'_>),
    ) {
        for (topic, feed) in self.feeds.iter_mut().filter(|(topic, _)| is_used(**topic)) {
            feed.followed = now;
            if let Some(reason) = feed.take(&mut self.n_news, &self.seal, now) {
                on_event(RelayEvent::SampleLost { topic: topic.to_string(), reason });
            }
        }
        self.feeds.retain(|_, feed| now.saturating_duration_since(feed.followed) < KEPT_FOR);
    }

    /// The next news of a topic behind that with number `last`, and its number: the newest sample, or why a later one is
    /// not there.
    pub(super) fn newer(&self, topic: OfRobot<TopicName>, last: u64) -> Option<(u64, FromRelay)> {
        let feed = self.feeds.get(&topic)?;
        let topic = topic.what;
        let sample =
            feed.newest.as_ref().filter(|(number, _)| *number > last).map(|(number, Copied { header, memory })| {
                (*number, FromRelay::Sample { topic, header: Box::new(*header), memory: Arc::clone(memory) })
            });
        let failure = feed.failure.as_ref().filter(|(number, _)| *number > last);
        sample
            .or_else(|| failure.map(|(number, reason)| (*number, FromRelay::NoTopic { topic, reason: reason.clone() })))
    }

    /// True if this is the number of a topic's newest sample, which the relay holds itself.
    pub(super) fn is_newest(&self, topic: OfRobot<TopicName>, number: u64) -> bool {
        self.feeds.get(&topic).and_then(|feed| feed.newest.as_ref()).is_some_and(|newest| newest.0 == number)
    }
}

impl Feed {
    /// Takes what has come; why it cannot be passed on, if that is new.
    fn take(&mut self, n_news: &mut u64, seal: &Seal, now: Instant) -> Option<String> {
        let failure = match self.subscriber.take() {
            Ok(Some(sample)) => {
                self.waiting = Some((sample, now));
                None
            }
            Ok(None) => None,
            Err(error) => Some(error.to_string()),
        };
        let failure = failure.or_else(|| self.copy(n_news, seal, now))?;
        let is_known = self.failure.as_ref().is_some_and(|(_, reason)| *reason == failure);
        (!is_known).then(|| {
            *n_news += 1;
            self.failure = Some((*n_news, failure.clone()));
            failure
        })
    }

    /// Copies the sample that waits for it, if it is time; why that fails.
    fn copy(&mut self, n_news: &mut u64, seal: &Seal, now: Instant) -> Option<String> {
        let (sample, _) = self.waiting.as_ref().filter(|(_, from)| *from <= now)?;
        match seal(sample.bytes()) {
            Ok(memory) => {
                *n_news += 1;
                self.newest = Some((*n_news, Copied { header: *sample.header(), memory: Arc::new(memory) }));
                (self.waiting, self.failure) = (None, None);
                None
            }
            Err(error) => {
                self.waiting.as_mut()?.1 = now + RETRY;
                Some(format!("it cannot be copied: {error}"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relay::tests::{Attended, Fixture, publish, until};
    use crate::relay_protocol::read_sealed;
    use crate::{Daemon, topics};
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

    const TOPIC: OfRobot<TopicName> = OfRobot { robot: None, what: TopicName::ScheduleState };

    /// Feeds whose copies can be made to fail.
    struct Followed {
        feeds: Feeds,
        bus: Bus,
        fails: Arc<AtomicBool>,
        n_copies: Arc<AtomicU32>,
        events: Vec<String>,
    }

    impl Followed {
        fn new(fixture: &Fixture) -> Self {
            let (bus, _) = Bus::join_as_owner(&fixture.domain, Daemon::Groundplan).unwrap();
            let (fails, n_copies) = (Arc::<AtomicBool>::default(), Arc::<AtomicU32>::default());
            let (failing, counter) = (Arc::clone(&fails), Arc::clone(&n_copies));
            let mut feeds = Feeds::with_seal(Box::new(move |bytes| {
                if failing.load(Ordering::Relaxed) {
                    return Err(io::Error::other("no descriptors"));
                }
                counter.fetch_add(1, Ordering::Relaxed);
                seal("test", bytes)
            }));
            feeds.follow(&bus, TOPIC).unwrap();
            Self { feeds, bus, fails, n_copies, events: Vec::new() }
        }

        fn take(&mut self, is_used: bool, now: Instant) {
            self.feeds.take(|_| is_used, now, &mut |event| self.events.push(format!("{event:?}")));
        }

        /// Epoch, or reason, of what a client gets that has had everything up to `last`.
        fn newer(&self, last: u64) -> Option<(u64, Result<u64, String>)> {
            let (number, frame) = self.feeds.newer(TOPIC, last)?;
            Some((
                number,
                match frame {
                    FromRelay::Sample { header, memory, .. } => {
                        read_sealed(&*memory, header.payload_length).unwrap();
                        Ok(header.epoch)
                    }
                    FromRelay::NoTopic { reason, .. } => Err(reason),
                    other => panic!("{other:?}"),
                },
            ))
        }
    }

    #[test]
    fn a_sample_that_cannot_be_copied_takes_nothing_away_and_is_copied_later() {
        let fixture = Fixture::start();
        let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
        let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
        let mut followed = Followed::new(&fixture);
        let now = Instant::now();
        publish(&publisher, 1);
        let (first, epoch) = until("the first", || {
            followed.take(true, now);
            followed.newer(0)
        });
        assert_eq!(epoch, Ok(1));
        followed.fails.store(true, Ordering::Relaxed);
        publish(&publisher, 2);
        let (failure, reason) = until("the failure", || {
            followed.take(true, now);
            followed.newer(first)
        });
        assert_eq!(reason, Err("it cannot be copied: no descriptors".to_owned()));
        assert_eq!(followed.newer(0), Some((first, Ok(1))), "who comes now gets the one before");
        followed.take(true, now + RETRY);
        assert_eq!((followed.newer(failure), followed.events.len()), (None, 1), "it is told once");
        followed.fails.store(false, Ordering::Relaxed);
        followed.take(true, now + RETRY);
        assert_eq!(followed.newer(failure), None, "it is not tried all the time");
        followed.take(true, now + 2 * RETRY);
        let (second, epoch) = followed.newer(failure).unwrap();
        assert_eq!((epoch, followed.newer(second)), (Ok(2), None));
    }

    #[test]
    fn a_sample_that_is_refused_takes_nothing_away() {
        let fixture = Fixture::start();
        let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
        let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
        let mut followed = Followed::new(&fixture);
        publish(&publisher, 5);
        let (first, _) = until("the first", || {
            followed.take(true, Instant::now());
            followed.newer(0)
        });
        drop(publisher);
        let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
        publish(&publisher, 2);
        let (_, reason) = until("the refusal", || {
            followed.take(true, Instant::now());
            followed.newer(first)
        });
        assert!(reason.unwrap_err().contains("epoch 2"));
        assert_eq!(followed.newer(0), Some((first, Ok(5))));
    }

    #[test]
    fn a_topic_without_followers_is_kept_for_a_while_and_not_copied() {
        let fixture = Fixture::start();
        let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
        let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
        let mut followed = Followed::new(&fixture);
        let now = Instant::now();
        publish(&publisher, 1);
        let (first, _) = until("the first", || {
            followed.take(true, now);
            followed.newer(0)
        });
        for _ in 0..10 {
            followed.take(false, now);
            followed.feeds.follow(&followed.bus, TOPIC).unwrap();
            followed.take(true, now);
            assert_eq!(followed.newer(0), Some((first, Ok(1))), "it is there at once");
        }
        publish(&publisher, 2);
        followed.take(false, now + KEPT_FOR / 2);
        assert_eq!(followed.n_copies.load(Ordering::Relaxed), 1);
        let (_, epoch) = until("the second", || {
            followed.take(true, now + KEPT_FOR / 2);
            followed.newer(first)
        });
        assert_eq!(epoch, Ok(2));
        followed.take(false, now + KEPT_FOR);
        assert!(followed.newer(0).is_some(), "it was followed a moment ago");
        followed.take(false, now + 2 * KEPT_FOR);
        assert_eq!(followed.newer(0), None);
    }
}
