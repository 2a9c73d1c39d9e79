//! Topics that clients of the relay follow: one subscription for all, and a sealed copy of the newest sample.

use super::event::RelayEvent;
use crate::bus::Bus;
use crate::error::PortError;
use crate::latched::{RawSample, RawSubscriber};
use crate::names::TopicName;
use crate::relay_protocol::{FromRelay, seal};
use messages::SampleHeader;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::os::fd::OwnedFd;
use std::sync::Arc;

/// Topics that somebody follows.
#[derive(Default)]
pub(super) struct Feeds {
    feeds: BTreeMap<TopicName, Feed>,
}

struct Feed {
    subscriber: RawSubscriber,
    /// Counts the samples; 0 while there is none.
    number: u64,
    newest: Option<Result<Copied, String>>,
}

/// A sample in memory that clients may read.
struct Copied {
    header: SampleHeader,
    memory: Arc<OwnedFd>,
}

impl Feeds {
    /// Follows a topic.
    pub(super) fn follow(&mut self, bus: &Bus, topic: TopicName) -> Result<(), PortError> {
        if let Entry::Vacant(place) = self.feeds.entry(topic) {
            place.insert(Feed { subscriber: bus.raw_subscriber(topic)?, number: 0, newest: None });
        }
        Ok(())
    }

    /// Takes what has come, and gives up topics that nobody follows any more.
    pub(super) fn take(&mut self, is_used: impl Fn(TopicName) -> bool, on_event: &mut dyn FnMut(RelayEvent<'_>)) {
        self.feeds.retain(|topic, _| is_used(*topic));
        for (topic, feed) in &mut self.feeds {
            let newest = match feed.subscriber.take() {
                Ok(None) => continue,
                Ok(Some(sample)) => Copied::of(&sample),
                Err(error) => Err(error.to_string()),
            };
            if let Err(reason) = &newest {
                on_event(RelayEvent::SampleLost { topic: *topic, reason: reason.clone() });
            }
            (feed.newest, feed.number) = (Some(newest), feed.number + 1);
        }
    }

    /// The newest sample of a topic and its number, if that is above `last`.
    pub(super) fn newer(&self, topic: TopicName, last: u64) -> Option<(u64, FromRelay)> {
        let feed = self.feeds.get(&topic).filter(|feed| feed.number > last)?;
        let frame = match feed.newest.as_ref()? {
            Ok(copied) => {
                FromRelay::Sample { topic, header: Box::new(copied.header), memory: Arc::clone(&copied.memory) }
            }
            Err(reason) => FromRelay::NoTopic { topic, reason: reason.clone() },
        };
        Some((feed.number, frame))
    }
}

impl Copied {
    fn of(sample: &RawSample) -> Result<Self, String> {
        let memory = seal("groundplan-sample", sample.bytes());
        let memory = memory.map_err(|error| format!("it cannot be copied: {error}"))?;
        Ok(Self { header: *sample.header(), memory: Arc::new(memory) })
    }
}
