//! The node of the bridge in the ROS 2 graph: its topics and its services.

mod library;
mod lost_participants;
mod node_entities;
mod publishers;
mod qos;
mod services;

pub(crate) use publishers::{MapTopics, StateTopics};
pub(crate) use services::{Calls, ServiceClient, ServiceServer};

use daemon::facts::RosPeers;
use daemon::{Failure, RosConfig, full_ros_name};
use futures::executor::block_on;
use futures::stream::{StreamExt, select};
use library::Library;
use lost_participants::LostParticipants;
use node_entities::NodeEntities;
use qos::{best_effort, latched, queue, volatile};
use ros::RosMessage;
use ros::msg::builtin_interfaces::Time;
use ros::msg::nav_msgs::OccupancyGrid;
use ros::msg::rosgraph_msgs::Clock;
use ros::msg::tf2_msgs::TFMessage;
use ros2_client::dds::rustdds::policy::ResourceLimits;
use ros2_client::dds::rustdds::{
    DomainParticipant as Participant, DomainParticipantBuilder, QosPolicies, QosPolicyBuilder, RTPSEntity, Topic,
    TopicKind,
};
use ros2_client::qos::{History, QosProfile};
use ros2_client::{Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Subscription};
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::net::{Ipv4Addr, UdpSocket};
use std::pin::pin;
use std::thread;
use tracing::warn;

/// Name of the node.
pub(crate) const NODE: &str = "ros_bridge";
/// Transforms that are kept for a slow reader.
const TRANSFORMS: usize = 100;

/// A node in the ROS 2 graph.
pub(crate) struct RosGraph {
    node: Node,
    namespace: String,
    participant: Participant,
    entities: NodeEntities,
    library: Library,
    lost: LostParticipants,
}

/// A part of the graph that cannot be had.
#[derive(Debug, thiserror::Error)]
pub(crate) enum GraphError {
    #[error("ros.domain_id: {text:?} is no ROS domain: it must be 0 to {}", RosConfig::MAX_DOMAIN)]
    Domain { text: String },
    #[error("ros.interfaces: this computer has no interface with the address {address}")]
    Interface { address: Ipv4Addr },
    #[error("{name:?} is no name of ROS 2")]
    Name { name: String },
    #[error("ROS 2: {what} cannot be created: {why}")]
    Create { what: String, why: String },
}

fn create<E: std::fmt::Debug>(what: impl Into<String>) -> impl FnOnce(E) -> GraphError {
    |why| GraphError::Create { what: what.into(), why: format!("{why:?}") }
}

impl RosGraph {
    /// Joins the graph of a domain.
    ///
    /// # Errors
    /// A domain or namespace that is none, no network.
    pub(crate) fn join(config: &RosConfig) -> Result<Self, GraphError> {
        let domain_id = domain_id(config)?;
        let name_error = || GraphError::Name { name: config.namespace.clone() };
        let name = NodeName::new(&config.namespace, NODE).map_err(|_| name_error())?;
        let mut participant = DomainParticipantBuilder::new(domain_id);
        if !config.interfaces.is_empty() {
            // The library joins nobody at an address that is none of this computer, and says so to nobody.
            if let Some(&address) = config.interfaces.iter().find(|address| UdpSocket::bind((**address, 0)).is_err()) {
                return Err(GraphError::Interface { address });
            }
            participant = participant.with_only_networks(config.interfaces.iter().copied());
        }
        let what = format!("a participant of domain {domain_id}");
        let participant = participant.build().map_err(create(what.as_str()))?;
        let context = Context::from_domain_participant(participant).map_err(create(what))?;
        // The library's services of parameters have the header of one middleware only; the bridge has its own.
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        // Nobody spins it: all that this would do is to read what the bridge reads itself, by readers that are no node's, one of them
        // on `/clock` with a type that is not that of the topic.
        let node = context.new_node(name, options).map_err(create("the node"))?;
        let entities = NodeEntities::open(&context).map_err(create("the topic of nodes"))?;
        let (namespace, participant) = (config.namespace.clone(), context.domain_participant());
        let lost = LostParticipants::of(&participant).map_err(create("a socket for announcements"))?;
        Ok(Self { node, namespace, participant, entities, library: Library::now(), lost })
    }

    /// Once a second: why somebody gets nothing from here any more, or soon will not, until this process begins anew.
    pub(crate) fn failure(&mut self) -> Option<&'static str> {
        let why = "a participant was silent for too long, and the ROS 2 library does not take it back";
        self.library.failure().or_else(|| self.lost.has_unheard().then_some(why))
    }

    /// Once a second: tells other nodes which readers and writers are this node's, where they may not know it.
    pub(crate) fn tell_entities(&mut self) {
        self.entities.tell(&self.participant);
    }

    /// A name in full: one that begins with a slash as it is, others in the namespace of the node.
    fn name(&self, name: &str) -> Result<Name, GraphError> {
        let full = full_ros_name(&self.namespace, name);
        Name::parse(&full).map_err(|_| GraphError::Name { name: full })
    }

    /// Its domain.
    pub(crate) fn domain_id(&self) -> u16 {
        self.node.domain_id()
    }

    /// What is there of other participants: how many, and how many publishers and subscriptions of these topics.
    pub(crate) fn peers<'a>(&self, topics: impl Iterator<Item = &'a str>) -> RosPeers {
        let own = self.participant.guid().prefix;
        let writers = self.participant.discovered_writers();
        let readers = self.participant.discovered_readers();
        let writers =
            writers.iter().map(|w| (w.writer_proxy.remote_writer_guid.prefix, w.publication_topic_data.topic_name()));
        let readers =
            readers.iter().map(|r| (r.reader_proxy.remote_reader_guid.prefix, r.subscription_topic_data.topic_name()));
        let [writers, readers]: [Vec<_>; 2] = [
            writers.filter(|(prefix, _)| *prefix != own).collect(),
            readers.filter(|(prefix, _)| *prefix != own).collect(),
        ];
        let participants: BTreeSet<_> = writers.iter().chain(&readers).map(|(prefix, _)| *prefix).collect();
        let of_topic = |topic: &'a str| {
            let wanted = format!("rt{topic}");
            let n = |ends: &[(_, &String)]| ends.iter().filter(|(_, name)| **name == wanted).count();
            (topic.to_owned(), [n(&writers), n(&readers)])
        };
        RosPeers { participants: participants.len(), topics: topics.map(of_topic).collect() }
    }

    /// Takes grids of a topic, latched or not, on a thread of its own: `take` gets each, or why a message cannot be read.
    ///
    /// # Errors
    /// A name that is none, a topic that cannot be opened.
    pub(crate) fn take_grids(
        &mut self,
        topic: &str,
        take: impl FnMut(Result<OccupancyGrid, String>) + Send + 'static,
    ) -> Result<(), Failure> {
        let latched = self.subscription(topic, &latched())?;
        let volatile = self.subscription(topic, &volatile())?;
        take_on_thread("ros-slam-map", latched, volatile, take)
    }

    /// Takes transforms, those that change and those that do not, on a thread of its own: `take` gets each message.
    ///
    /// # Errors
    /// Topics that cannot be opened.
    pub(crate) fn take_transforms(&mut self, mut take: impl FnMut(TFMessage) + Send + 'static) -> Result<(), Failure> {
        let moving = self.subscription("/tf", &queue(TRANSFORMS))?;
        let of_static = QosProfile { durability: latched().durability, ..queue(TRANSFORMS) };
        let fixed = self.subscription("/tf_static", &of_static)?;
        take_on_thread("ros-tf", fixed, moving, move |message| match message {
            Ok(message) => take(message),
            Err(error) => warn!(service = "ros-bridge", error, "transforms cannot be read"),
        })
    }

    /// Reads the simulated time.
    ///
    /// # Errors
    /// A topic that cannot be opened.
    pub(crate) fn clock(&mut self) -> Result<ClockReader, GraphError> {
        Ok(ClockReader(self.subscription("/clock", &best_effort())?))
    }

    fn subscription<M: RosMessage + DeserializeOwned + 'static>(
        &mut self,
        topic: &str,
        profile: &QosProfile,
    ) -> Result<Subscription<M>, GraphError> {
        let max_samples = match profile.history {
            History::KeepLast { depth } => i32::try_from(depth).unwrap_or(i32::MAX),
            History::KeepAll => i32::MAX,
        };
        // Without a limit the library keeps 64 messages of every topic: of large maps that is more than a robot's memory.
        let limits = ResourceLimits { max_samples, max_instances: 1, max_samples_per_instance: max_samples };
        let profile = QosPolicies::from(profile).modify_by(&QosPolicyBuilder::new().resource_limits(limits).build());
        let dds_topic = self.dds_topic::<M>(topic, &profile)?;
        self.node.create_subscription(&dds_topic, None).map_err(create(topic))
    }

    /// A topic of DDS for what a profile of ROS 2 does not say.
    fn dds_topic<M: RosMessage>(&self, name: &str, qos: &QosPolicies) -> Result<Topic, GraphError> {
        let (full, kind) = (format!("rt{}", self.name(name)?), MessageTypeName::new(M::PACKAGE, M::NAME));
        let topic = self.participant.create_topic(full, kind.dds_msg_type(), qos, TopicKind::NoKey);
        topic.map_err(create(name))
    }
}

/// The simulated time.
pub(crate) struct ClockReader(Subscription<Clock>);

impl ClockReader {
    /// The newest time since the last call; `None` without one.
    ///
    /// # Errors
    /// A message that cannot be read.
    pub(crate) fn newest(&self) -> Result<Option<Time>, Failure> {
        let mut newest = None;
        while let Some((Clock { clock }, _)) = self.0.take().map_err(|why| format!("/clock cannot be read: {why:?}"))? {
            newest = Some(clock);
        }
        Ok(newest)
    }
}

/// Hands each message of two subscriptions over, on a thread, or why one cannot be read.
fn take_on_thread<M: DeserializeOwned + Send + 'static>(
    thread_name: &str,
    first: Subscription<M>,
    second: Subscription<M>,
    mut take: impl FnMut(Result<M, String>) + Send + 'static,
) -> Result<(), Failure> {
    let read = move || {
        let mut messages = pin!(select(first.async_stream(), second.async_stream()));
        while let Some(message) = block_on(messages.next()) {
            take(message.map(|(message, _)| message).map_err(|why| why.to_string()));
        }
    };
    thread::Builder::new().name(thread_name.to_owned()).spawn(read)?;
    Ok(())
}

fn domain_id(config: &RosConfig) -> Result<u16, GraphError> {
    let of_environment = || match std::env::var("ROS_DOMAIN_ID") {
        Ok(text) => text.trim().parse::<u16>().map_err(|_| GraphError::Domain { text }),
        Err(_) => Ok(0),
    };
    let domain_id = config.domain_id.map_or_else(of_environment, Ok)?;
    if domain_id <= RosConfig::MAX_DOMAIN {
        Ok(domain_id)
    } else {
        Err(GraphError::Domain { text: domain_id.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interface_is_one_of_this_computer() {
        let config = RosConfig { interfaces: [Ipv4Addr::new(203, 0, 113, 7)].into(), ..RosConfig::default() };
        let why = RosGraph::join(&config).err().unwrap();
        assert!(why.to_string().ends_with("203.0.113.7"), "{why}");
    }

    #[test]
    fn a_domain_is_one_whose_ports_exist() {
        let of = |id| domain_id(&RosConfig { domain_id: Some(id), ..RosConfig::default() }).ok();
        assert_eq!([of(0), of(232), of(233)], [Some(0), Some(232), None]);
    }
}
