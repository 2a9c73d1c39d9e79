//! The node of the bridge in the ROS 2 graph: its publishers, its subscriptions, the thread that keeps it discovered.

mod publishers;
mod qos;

pub(crate) use publishers::Publishers;

use daemon::{Failure, RosConfig};
use futures::executor::block_on;
use futures::stream::{StreamExt, select};
use qos::{latched, volatile};
use ros::msg::nav_msgs::OccupancyGrid;
use ros2_client::{Context, ContextOptions, MessageTypeName, Name, Node, NodeName, NodeOptions, Subscription};
use std::pin::pin;
use std::thread;
use tracing::{error, warn};

/// Name of the node.
const NODE: &str = "ros_bridge";
/// The largest number of a domain whose ports exist.
const MAX_DOMAIN: u16 = 232;

/// A node in the ROS 2 graph.
pub(crate) struct RosGraph {
    node: Node,
    namespace: String,
}

/// A part of the graph that cannot be had.
#[derive(Debug, thiserror::Error)]
pub(crate) enum GraphError {
    #[error("ros.domain_id: {text:?} is no ROS domain: it must be 0 to {MAX_DOMAIN}")]
    Domain { text: String },
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
        let context = Context::with_options(ContextOptions::new().domain_id(domain_id));
        let context = context.map_err(create(format!("a participant of domain {domain_id}")))?;
        // Six services of parameters that nobody could call: their header is not that of every middleware.
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let mut node = context.new_node(name, options).map_err(create("the node"))?;
        let spinner = node.spinner().map_err(create("the spinner"))?;
        let spin = move || {
            if let Err(why) = block_on(spinner.spin()) {
                error!(service = "ros-bridge", error = format!("{why:?}"), "the node is not discovered any more");
            }
        };
        thread::Builder::new().name("ros-spin".to_owned()).spawn(spin).map_err(create("a thread"))?;
        Ok(Self { node, namespace: config.namespace.clone() })
    }

    /// A name in full: one that begins with a slash as it is, others in the namespace of the node.
    fn name(&self, name: &str) -> Result<Name, GraphError> {
        let full = full_name(&self.namespace, name);
        Name::parse(&full).map_err(|_| GraphError::Name { name: full })
    }

    /// Takes grids of a topic, latched or not, on a thread of its own: `take` gets each.
    ///
    /// # Errors
    /// A name that is none, a topic that cannot be opened.
    pub(crate) fn take_grids(
        &mut self,
        topic: &str,
        mut take: impl FnMut(OccupancyGrid) + Send + 'static,
    ) -> Result<(), Failure> {
        let name = self.name(topic)?;
        let kind = MessageTypeName::new("nav_msgs", "OccupancyGrid");
        let latched: Subscription<OccupancyGrid> = {
            let topic = self.node.create_topic(&name, kind.clone(), &latched()).map_err(create(topic))?;
            self.node.create_subscription(&topic, None).map_err(create(name.to_string()))?
        };
        let volatile: Subscription<OccupancyGrid> = {
            let topic = self.node.create_topic(&name, kind, &volatile()).map_err(create(topic))?;
            self.node.create_subscription(&topic, None).map_err(create(name.to_string()))?
        };
        let read = move || {
            let mut grids = pin!(select(latched.async_stream(), volatile.async_stream()));
            while let Some(grid) = block_on(grids.next()) {
                match grid {
                    Ok((grid, _)) => take(grid),
                    Err(why) => {
                        warn!(service = "ros-bridge", error = format!("{why:?}"), "a message cannot be read");
                    }
                }
            }
        };
        thread::Builder::new().name("ros-slam-map".to_owned()).spawn(read)?;
        Ok(())
    }
}

/// Names that begin with a slash are whole; others are in the namespace.
pub(crate) fn full_name(namespace: &str, name: &str) -> String {
    if name.starts_with('/') { name.to_owned() } else { format!("{}/{name}", namespace.trim_end_matches('/')) }
}

fn domain_id(config: &RosConfig) -> Result<u16, GraphError> {
    let of_environment = || match std::env::var("ROS_DOMAIN_ID") {
        Ok(text) => text.trim().parse::<u16>().map_err(|_| GraphError::Domain { text }),
        Err(_) => Ok(0),
    };
    let domain_id = config.domain_id.map_or_else(of_environment, Ok)?;
    if domain_id <= MAX_DOMAIN { Ok(domain_id) } else { Err(GraphError::Domain { text: domain_id.to_string() }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_namespace_unless_they_begin_with_a_slash() {
        assert_eq!(full_name("/groundplan", "map"), "/groundplan/map");
        assert_eq!(full_name("/", "map"), "/map");
        assert_eq!(full_name("/groundplan", "/map"), "/map");
    }

    #[test]
    fn a_domain_is_one_whose_ports_exist() {
        let of = |id| domain_id(&RosConfig { domain_id: Some(id), ..RosConfig::default() }).ok();
        assert_eq!([of(0), of(232), of(233)], [Some(0), Some(232), None]);
    }
}
