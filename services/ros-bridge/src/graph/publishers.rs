//! The topics of the bridge.

use super::qos::{heartbeat, latched, latched_large, volatile, with};
use super::{GraphError, RosGraph, create};
use bus::HEARTBEAT_PERIOD;
use daemon::{Failure, RosConfig, RosOutput, full_ros_name};
use ros::RosMessage;
use ros::msg::diagnostic_msgs::DiagnosticArray;
use ros::msg::geometry_msgs::PoseWithCovarianceStamped;
use ros::msg::grid_map_msgs::GridMap;
use ros::msg::nav_msgs::OccupancyGrid;
use ros::msg::nav2_msgs::CostmapFilterInfo;
use ros::msg::std_msgs;
use ros::msg::tf2_msgs::TFMessage;
use ros::msg::visualization_msgs::MarkerArray;
use ros2_client::dds::rustdds::no_key::DataWriterCdr;
use ros2_client::dds::rustdds::{QosPolicies, RTPSEntity, Timestamp};
use ros2_client::qos::QosProfile;
use ros2_client::{MessageTypeName, Publisher};
use std::time::Instant;
use tracing::warn;

/// A topic and its publisher; without one if the site does not want it.
pub(crate) struct Topic<M: RosMessage> {
    name: String,
    publisher: Option<Publisher<M>>,
}

impl<M: RosMessage> Topic<M> {
    /// Publishes; what a reader does not take in time is logged, and comes with the next message.
    pub(crate) fn publish(&self, message: M) {
        let Some(publisher) = &self.publisher else { return };
        if let Err(why) = publisher.publish(message) {
            warn!(service = "ros-bridge", topic = self.name, error = %why, "a message is not sent");
        }
    }
}

/// A topic of grids, which tells whether its readers have them; without a writer if the site does not want it.
///
/// The library's publisher hides its writer, therefore this is a writer of DDS, of which the graph is told apart.
pub(crate) struct GridTopic<M: RosMessage = OccupancyGrid> {
    name: String,
    writer: Option<DataWriterCdr<M>>,
}

impl<M: RosMessage> GridTopic<M> {
    /// Its name in full.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Publishes.
    ///
    /// # Errors
    /// The grid is not sent.
    pub(crate) fn publish(&self, grid: M) -> Result<(), Failure> {
        let Some(writer) = &self.writer else { return Ok(()) };
        writer.write(grid, Some(Timestamp::now())).map_err(|why| format!("{} is not sent: {why}", self.name).into())
    }

    /// Waits until each reliable reader has what was published; false if one does not at this instant.
    pub(crate) fn is_taken_until(&self, deadline: Instant) -> bool {
        let longest = deadline.saturating_duration_since(Instant::now());
        // Without a writer there is nothing to wait for, and a wait does not fail.
        self.writer.as_ref().is_none_or(|writer| writer.wait_for_acknowledgments(longest).unwrap_or(true))
    }
}

/// Topics whose messages belong to one set of maps.
pub(crate) struct MapTopics {
    pub(crate) map: GridTopic,
    pub(crate) localization_map: GridTopic,
    pub(crate) keepout_mask: GridTopic,
    pub(crate) keepout_info: Topic<CostmapFilterInfo>,
    /// There only if the site wants limits of speed.
    pub(crate) speed_mask: GridTopic,
    pub(crate) speed_info: Topic<CostmapFilterInfo>,
    /// There only if the site wants heights.
    pub(crate) grid_map: GridTopic<GridMap>,
    pub(crate) rooms: Topic<MarkerArray>,
    pub(crate) waypoints: Topic<MarkerArray>,
    pub(crate) route: Topic<MarkerArray>,
    /// Path of the route graph's file.
    pub(crate) route_graph: Topic<std_msgs::String>,
    /// One JSON document: what changed, epoch, until when it is valid.
    pub(crate) changed: Topic<std_msgs::String>,
}

/// Topics that do not wait for maps.
pub(crate) struct StateTopics {
    /// One JSON document a second: whether the maps may be used.
    pub(crate) heartbeat: Topic<std_msgs::String>,
    pub(crate) diagnostics: Topic<DiagnosticArray>,
    pub(crate) tf_static: Topic<TFMessage>,
    pub(crate) initial_pose: Topic<PoseWithCovarianceStamped>,
}

impl MapTopics {
    /// Opens all that the site wants.
    ///
    /// # Errors
    /// Names that are none, topics that cannot be opened.
    pub(crate) fn open(graph: &mut RosGraph, config: &RosConfig) -> Result<Self, GraphError> {
        let map = config.map_topic.as_deref().unwrap_or("map");
        Ok(Self {
            map: graph.grids(config, RosOutput::Map, map)?,
            localization_map: graph.grids(config, RosOutput::LocalizationMap, "localization_map")?,
            keepout_mask: graph.grids(config, RosOutput::KeepoutMask, "keepout_mask")?,
            keepout_info: graph.output(config, RosOutput::KeepoutMask, "keepout_info", latched())?,
            speed_mask: graph.grids_if(config.speed_mask, config, RosOutput::KeepoutMask, "speed_mask")?,
            speed_info: graph.topic("speed_info", config.speed_mask.then(latched))?,
            grid_map: graph.grids_if(config.grid_map, config, RosOutput::Map, "grid_map")?,
            rooms: graph.output(config, RosOutput::Rooms, "rooms", latched_large())?,
            waypoints: graph.output(config, RosOutput::Waypoints, "waypoints", latched_large())?,
            route: graph.output(config, RosOutput::Route, "route", latched_large())?,
            route_graph: graph.output(config, RosOutput::Route, "route_graph", latched())?,
            changed: graph.output(config, RosOutput::Changed, "changed", latched())?,
        })
    }
}

impl StateTopics {
    /// Opens all that the site wants.
    ///
    /// # Errors
    /// Names that are none, topics that cannot be opened.
    pub(crate) fn open(graph: &mut RosGraph, config: &RosConfig) -> Result<Self, GraphError> {
        let initial_pose = if config.initial_pose { Some(volatile()) } else { None };
        Ok(Self {
            heartbeat: graph.output(config, RosOutput::Heartbeat, "heartbeat", heartbeat(HEARTBEAT_PERIOD))?,
            diagnostics: graph.output(config, RosOutput::Diagnostics, "/diagnostics", volatile())?,
            tf_static: graph.output(config, RosOutput::TfStatic, "/tf_static", latched())?,
            initial_pose: graph.topic("/initialpose", initial_pose)?,
        })
    }
}

impl RosGraph {
    fn grids(&mut self, config: &RosConfig, output: RosOutput, name: &str) -> Result<GridTopic, GraphError> {
        self.grids_if(config.outputs.contains(&output), config, output, name)
    }

    /// A topic of grids with the quality of service of an output; nothing is published on it unless it is wanted.
    fn grids_if<M: RosMessage>(
        &mut self,
        is_wanted: bool,
        config: &RosConfig,
        output: RosOutput,
        name: &str,
    ) -> Result<GridTopic<M>, GraphError> {
        let mut writer = None;
        if is_wanted {
            let qos = QosPolicies::from(&with(latched_large(), config.qos.get(&output)));
            let topic = self.dds_topic::<M>(name, &qos)?;
            let publisher = self.participant.create_publisher(&qos).map_err(create(name))?;
            let created = publisher.create_datawriter_no_key_cdr(&topic, None).map_err(create(name))?;
            self.entities.add_writer(created.guid());
            writer = Some(created);
        }
        Ok(GridTopic { name: full_ros_name(&self.namespace, name), writer })
    }

    fn output<M: RosMessage>(
        &mut self,
        config: &RosConfig,
        output: RosOutput,
        name: &str,
        profile: QosProfile,
    ) -> Result<Topic<M>, GraphError> {
        let is_wanted = config.outputs.contains(&output);
        self.topic(name, is_wanted.then(|| with(profile, config.qos.get(&output))))
    }

    /// A topic; without a profile nothing is published on it.
    fn topic<M: RosMessage>(&mut self, name: &str, profile: Option<QosProfile>) -> Result<Topic<M>, GraphError> {
        let mut publisher = None;
        if let Some(profile) = profile {
            let kind = MessageTypeName::new(M::PACKAGE, M::NAME);
            let topic = self.node.create_topic(&self.name(name)?, kind, &profile).map_err(create(name))?;
            publisher = Some(self.node.create_publisher(&topic, None).map_err(create(name))?);
        }
        Ok(Topic { name: full_ros_name(&self.namespace, name), publisher })
    }
}
