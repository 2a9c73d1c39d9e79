//! Tells the graph which readers and writers are the node's, also writers of DDS, which the library does not count.
//!
//! On the topic of nodes the newest message of a participant takes the place of those before it, whichever writer sent it. The library
//! sends its own, without the writers of DDS, when it opens something and to each reader that comes. Therefore the whole list goes out
//! when it has changed or a reader has come, several times, and again from time to time.

use ros2_client::builtin_topics::ros_discovery::{QOS_PUB, TOPIC_NAME, TYPE_NAME};
use ros2_client::dds::rustdds::dds::CreateResult;
use ros2_client::dds::rustdds::no_key::DataWriterCdr;
use ros2_client::dds::rustdds::{DomainParticipant, GUID, RTPSEntity, Timestamp, TopicKind};
use ros2_client::entities_info::{NodeEntitiesInfo, ParticipantEntitiesInfo};
use ros2_client::{Context, Gid};
use std::collections::BTreeSet;
use tracing::warn;

/// So often the list goes out after a change, once a second: the library's list may come later than the first of them.
const REPEATS_AFTER_CHANGE: u32 = 5;
/// Seconds between lists while nothing changes: the library's may have been lost on the way, and sent again late.
const PERIOD_S: u32 = 10;

/// The list of the node's readers and writers.
pub(super) struct NodeEntities {
    context: Context,
    writer: DataWriterCdr<ParticipantEntitiesInfo>,
    /// Writers that belong to the node without the library.
    writers: Vec<Gid>,
    schedule: Schedule<(Vec<NodeEntitiesInfo>, BTreeSet<GUID>)>,
}

impl NodeEntities {
    /// Opens the topic of nodes; nothing is sent yet.
    ///
    /// # Errors
    /// The topic cannot be opened.
    pub(super) fn open(context: &Context) -> CreateResult<Self> {
        let participant = context.domain_participant();
        let (topic, kind) = (TOPIC_NAME.to_owned(), TYPE_NAME.to_owned());
        let topic = participant.create_topic(topic, kind, &QOS_PUB, TopicKind::NoKey)?;
        let publisher = participant.create_publisher(&QOS_PUB)?;
        let writer = publisher.create_datawriter_no_key_cdr(&topic, None)?;
        let writers = vec![writer.guid().into()];
        Ok(Self { context: context.clone(), writer, writers, schedule: Schedule::default() })
    }

    /// A writer of DDS is one of the node's.
    pub(super) fn add_writer(&mut self, writer: GUID) {
        self.writers.push(writer.into());
    }

    /// Sends the list where it is due; to be called once a second.
    pub(super) fn tell(&mut self, participant: &DomainParticipant) {
        let of_library = self.context.participant_entities_info();
        let mut nodes = of_library.nodes().clone();
        for node in &mut nodes {
            self.writers.iter().for_each(|writer| node.add_writer(*writer));
        }
        let readers = participant.discovered_readers();
        let readers = readers.iter().filter(|reader| reader.subscription_topic_data.topic_name() == TOPIC_NAME);
        let readers = readers.map(|reader| reader.reader_proxy.remote_reader_guid).collect();
        if self.schedule.is_due((nodes.clone(), readers)) {
            let list = ParticipantEntitiesInfo::new(of_library.gid(), nodes);
            if let Err(why) = self.writer.write(list, Some(Timestamp::now())) {
                warn!(service = "ros-bridge", error = %why, "the list of the node's readers and writers is not sent");
            }
        }
    }
}

/// The seconds in which something is sent.
struct Schedule<T> {
    last: Option<T>,
    since_change_s: u32,
}

impl<T> Default for Schedule<T> {
    fn default() -> Self {
        Self { last: None, since_change_s: 0 }
    }
}

impl<T: PartialEq> Schedule<T> {
    /// True if this is to be sent in this second.
    fn is_due(&mut self, now: T) -> bool {
        let now = Some(now);
        self.since_change_s = if self.last == now { self.since_change_s.saturating_add(1) } else { 0 };
        self.last = now;
        self.since_change_s < REPEATS_AFTER_CHANGE || self.since_change_s.is_multiple_of(PERIOD_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_changed_goes_out_at_once_and_several_times_and_then_seldom() {
        let mut schedule = Schedule::default();
        let due: Vec<u32> = (0..25).filter(|second| schedule.is_due(*second >= 12)).collect();
        assert_eq!(due, [0, 1, 2, 3, 4, 10, 12, 13, 14, 15, 16, 22]);
    }
}
