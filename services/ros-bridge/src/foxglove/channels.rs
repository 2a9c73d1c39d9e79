//! The channels of the server: the topics of the bridge under the same names, rooms as entities, the pose of the SLAM map.

use super::latch::{Latches, RosChannel, SceneChannel};
use daemon::RosConfig;
use foxglove::Context;
use ros::msg::diagnostic_msgs::DiagnosticArray;
use ros::msg::foxglove_msgs::Grid as FoxgloveGrid;
use ros::msg::geometry_msgs::PoseWithCovarianceStamped;
use ros::msg::nav_msgs::OccupancyGrid;
use ros::msg::nav2_msgs::CostmapFilterInfo;
use ros::msg::std_msgs;
use ros::msg::tf2_msgs::TFMessage;
use ros::msg::visualization_msgs::MarkerArray;
use ros::topics::{StoreyTopics, TF_STATIC};
use std::sync::Arc;

/// What the server sends.
pub(super) struct Channels {
    pub(super) map: RosChannel<OccupancyGrid>,
    pub(super) localization_map: RosChannel<OccupancyGrid>,
    pub(super) keepout_mask: RosChannel<OccupancyGrid>,
    pub(super) keepout_info: RosChannel<CostmapFilterInfo>,
    /// Limits of speed and what they mean, if the site wants them.
    pub(super) speed: Option<(RosChannel<OccupancyGrid>, RosChannel<CostmapFilterInfo>)>,
    /// Heights, slopes and traversability, if the site wants them.
    pub(super) elevation: Option<RosChannel<FoxgloveGrid>>,
    pub(super) rooms: RosChannel<MarkerArray>,
    pub(super) room_entities: SceneChannel,
    pub(super) world: SceneChannel,
    pub(super) waypoints: RosChannel<MarkerArray>,
    pub(super) route: RosChannel<MarkerArray>,
    pub(super) changed: RosChannel<std_msgs::String>,
    pub(super) alignment: RosChannel<PoseWithCovarianceStamped>,
    pub(super) tf_static: RosChannel<TFMessage>,
    pub(super) diagnostics: RosChannel<DiagnosticArray>,
}

impl Channels {
    /// Opens all of them.
    pub(super) fn open(context: &Arc<Context>, config: &RosConfig) -> Self {
        let name = |name: &str| config.full_name(name);
        let topics = StoreyTopics::below(config.namespace.trim_end_matches('/'));
        let map = config.map_topic.as_deref().map_or(topics.map, name);
        Self {
            map: RosChannel::open(context, &map),
            localization_map: RosChannel::open(context, &topics.localization_map),
            keepout_mask: RosChannel::open(context, &topics.keepout_mask),
            keepout_info: RosChannel::open(context, &topics.keepout_info),
            speed: config.speed_mask.then(|| {
                let mask = RosChannel::open(context, &topics.speed_mask);
                (mask, RosChannel::open(context, &topics.speed_info))
            }),
            elevation: config.grid_map.then(|| RosChannel::open(context, &topics.elevation)),
            rooms: RosChannel::open(context, &topics.rooms),
            room_entities: SceneChannel::open(context, &name("room_entities")),
            world: SceneChannel::open(context, &name("world")),
            waypoints: RosChannel::open(context, &topics.waypoints),
            route: RosChannel::open(context, &topics.route),
            changed: RosChannel::open(context, &name("changed")),
            alignment: RosChannel::open(context, &name("alignment")),
            tf_static: RosChannel::open(context, TF_STATIC),
            diagnostics: RosChannel::open(context, "/diagnostics"),
        }
    }

    /// Takes the newest messages of others.
    pub(super) fn follow(&self, others: &Self) {
        for (latch, other) in self.latches().0.iter().zip(&others.latches().0) {
            latch.follow(other);
        }
    }

    /// All of them.
    pub(super) fn latches(&self) -> Arc<Latches> {
        let latches = [
            &self.map.latch,
            &self.localization_map.latch,
            &self.keepout_mask.latch,
            &self.keepout_info.latch,
            &self.rooms.latch,
            &self.room_entities.latch,
            &self.world.latch,
            &self.waypoints.latch,
            &self.route.latch,
            &self.changed.latch,
            &self.alignment.latch,
            &self.tf_static.latch,
            &self.diagnostics.latch,
        ];
        let speed = self.speed.iter().flat_map(|(mask, info)| [&mask.latch, &info.latch]);
        let elevation = self.elevation.iter().map(|channel| &channel.latch);
        Arc::new(Latches(latches.into_iter().chain(speed).chain(elevation).cloned().collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;
    use std::path::Path;

    fn topics(config: &RosConfig) -> Vec<String> {
        let channels = Channels::open(&Context::new(), config);
        channels.latches().0.iter().map(|latch| latch.topic().to_owned()).collect()
    }

    #[test]
    fn channels_are_named_as_the_topics_of_ros() {
        let root =
            RosConfig { namespace: "/".to_owned(), map_topic: Some("/planned".to_owned()), ..RosConfig::default() };
        assert_eq!(topics(&root)[..2], ["/planned", "/localization_map"]);
        let other = RosConfig { map_topic: Some("planned".to_owned()), ..RosConfig::default() };
        assert_eq!(topics(&other)[0], "/groundplan/planned");
        let usual = topics(&RosConfig::default());
        let more = topics(&RosConfig { speed_mask: true, grid_map: true, ..RosConfig::default() });
        let added = ["/groundplan/speed_mask", "/groundplan/speed_info", "/groundplan/elevation"];
        assert_eq!((&more[..usual.len()], &more[usual.len()..]), (&usual[..], &added.map(str::to_owned)[..]));
    }

    /// Texts of a JSON document that begin with a slash, keys included.
    fn slashed<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
        match value {
            Value::String(text) => found.push(text),
            Value::Array(values) => values.iter().for_each(|value| slashed(value, found)),
            Value::Object(fields) => fields.iter().for_each(|(key, value)| {
                found.push(key);
                slashed(value, found);
            }),
            _ => {}
        }
        found.retain(|text| text.starts_with('/'));
    }

    #[test]
    fn the_shipped_layout_names_topics_that_there_are() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/foxglove/groundplan.json");
        let layout: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        let config = RosConfig { grid_map: true, ..RosConfig::default() };
        let (topics, mut named) = (topics(&config), Vec::new());
        slashed(&layout, &mut named);
        assert!(named.iter().all(|name| topics.iter().any(|topic| topic == name)), "{named:?} {topics:?}");
        let shown = ["/groundplan/map", "/groundplan/room_entities", "/groundplan/changed", "/diagnostics"];
        assert!(shown.iter().all(|topic| named.contains(topic)), "{named:?}");
        let panels: Vec<&String> = layout["configById"].as_object().unwrap().keys().collect();
        let placed = layout["layout"].to_string();
        assert!(panels.iter().all(|panel| placed.contains(&format!("\"{panel}\""))), "{panels:?}");
    }
}
