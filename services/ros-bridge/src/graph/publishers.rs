//! The topics of the bridge.

use super::qos::{latched, volatile};
use super::{GraphError, RosGraph, create, full_name};
use daemon::RosConfig;
use ros::RosMessage;
use ros::msg::diagnostic_msgs::DiagnosticArray;
use ros::msg::nav_msgs::OccupancyGrid;
use ros::msg::nav2_msgs::CostmapFilterInfo;
use ros::msg::std_msgs;
use ros::msg::tf2_msgs::TFMessage;
use ros::msg::visualization_msgs::MarkerArray;
use ros2_client::qos::QosProfile;
use ros2_client::{MessageTypeName, Publisher};
use tracing::warn;

/// A topic and its publisher.
pub(crate) struct Topic<M: RosMessage> {
    name: String,
    publisher: Publisher<M>,
}

impl<M: RosMessage> Topic<M> {
    /// Its name in full.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Publishes; what a reader does not take in time is logged, and comes with the next message.
    pub(crate) fn publish(&self, message: M) {
        if let Err(why) = self.publisher.publish(message) {
            warn!(service = "ros-bridge", topic = self.name, error = %why, "a message is not sent");
        }
    }
}

/// What the bridge publishes.
pub(crate) struct Publishers {
    pub(crate) map: Topic<OccupancyGrid>,
    pub(crate) localization_map: Topic<OccupancyGrid>,
    pub(crate) keepout_mask: Topic<OccupancyGrid>,
    pub(crate) keepout_info: Topic<CostmapFilterInfo>,
    pub(crate) rooms: Topic<MarkerArray>,
    pub(crate) waypoints: Topic<MarkerArray>,
    pub(crate) route: Topic<MarkerArray>,
    /// One JSON document: what changed, epoch, until when it is valid.
    pub(crate) changed: Topic<std_msgs::String>,
    pub(crate) diagnostics: Topic<DiagnosticArray>,
    pub(crate) tf_static: Topic<TFMessage>,
}

impl Publishers {
    /// Opens all of them.
    ///
    /// # Errors
    /// Names that are none, topics that cannot be opened.
    pub(crate) fn open(graph: &mut RosGraph, config: &RosConfig) -> Result<Self, GraphError> {
        let map = config.map_topic.as_deref().unwrap_or("map");
        Ok(Self {
            map: graph.publisher(map, &latched())?,
            localization_map: graph.publisher("localization_map", &latched())?,
            keepout_mask: graph.publisher("keepout_mask", &latched())?,
            keepout_info: graph.publisher("keepout_info", &latched())?,
            rooms: graph.publisher("rooms", &latched())?,
            waypoints: graph.publisher("waypoints", &latched())?,
            route: graph.publisher("route", &latched())?,
            changed: graph.publisher("changed", &latched())?,
            diagnostics: graph.publisher("/diagnostics", &volatile())?,
            tf_static: graph.publisher("/tf_static", &latched())?,
        })
    }
}

impl RosGraph {
    fn publisher<M: RosMessage>(&mut self, name: &str, qos: &QosProfile) -> Result<Topic<M>, GraphError> {
        let topic = self.node.create_topic(&self.name(name)?, MessageTypeName::new(M::PACKAGE, M::NAME), qos);
        let publisher = self.node.create_publisher(&topic.map_err(create(name))?, None).map_err(create(name))?;
        Ok(Topic { name: full_name(&self.namespace, name), publisher })
    }
}
