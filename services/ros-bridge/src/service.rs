//! The ros-bridge service: publishes the maps of the robot's storey whenever they change, and takes its SLAM map.

use crate::foxglove::FoxgloveServer;
use crate::graph::{Publishers, RosGraph};
use crate::outputs::{Outputs, diagnostics, outputs_of, transform_of};
use crate::slam_map::SlamMapInput;
use crate::storey::storey_of_robot;
use bus::{Bus, CheckedSample, GridSlot, RawSubscriber, SiteSample, SiteSamples, TopicName, topics};
use daemon::facts::RosBridgeFacts;
use daemon::{
    Asked, CurrentActivity, Done, Event, Failure, RosBridgeRequest, RosConfig, Service, SiteConfig, SiteProcess,
    Standing, StatusBoard,
};
use messages::{Activity, PoseValidity};
use ros::markers::each_room;
use ros::msg::builtin_interfaces::Time;
use ros::transforms::alignment_pose;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};
use tracing::info;

daemon::inputs! {
    /// What is shown to ROS 2.
    pub(crate) enum BridgeInput { Site, ScheduleState, Grids, MissionPlan, Alignment }
}

/// Content hashes of what was published, and the storey.
type Published = (usize, u64, Option<u64>);

/// Publishes in ROS 2.
pub(crate) struct BridgeService {
    config: SiteConfig,
    activity: CurrentActivity,
    /// The node; it leaves the graph with the daemon.
    _graph: RosGraph,
    publishers: Publishers,
    foxglove: Option<FoxgloveServer>,
    slam_map: Option<Arc<Mutex<SlamMapInput>>>,
    samples: SiteSamples,
    grids: Vec<RawSubscriber>,
    alignment: Option<CheckedSample<topics::Alignment>>,
    published: Option<Published>,
    /// True while `/tf_static` has a transform.
    has_transform: bool,
    /// Why there is nothing to show.
    warning: Option<String>,
}

impl BridgeService {
    /// Joins the graph.
    ///
    /// # Errors
    /// A configuration that cannot be used, no network.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let ros = &config.ros;
        check(ros)?;
        let mut graph = RosGraph::join(ros)?;
        let publishers = Publishers::open(&mut graph, ros)?;
        let foxglove = ros.foxglove.as_ref().map(|foxglove| FoxgloveServer::start(foxglove, ros)).transpose()?;
        let slam_map = match &ros.slam_map_topic {
            Some(topic) => {
                let input = Arc::new(Mutex::new(SlamMapInput::new(config)?));
                let taken = Arc::clone(&input);
                graph.take_grids(topic, move |grid| {
                    taken.lock().unwrap_or_else(PoisonError::into_inner).take(&grid);
                })?;
                Some(input)
            }
            None => None,
        };
        Ok(Self {
            config: config.clone(),
            activity,
            _graph: graph,
            publishers,
            foxglove,
            slam_map,
            samples: SiteSamples::default(),
            grids: Vec::new(),
            alignment: None,
            published: None,
            has_transform: false,
            warning: None,
        })
    }

    /// Publishes the newest set, if it belongs together and is not published.
    fn show(&mut self) -> Result<Done, Failure> {
        for subscriber in &self.grids {
            if let Some(sample) = subscriber.take()? {
                SiteSample::check(sample)?.into_iter().for_each(|grid| self.samples.insert(grid));
            }
        }
        let Some(set) = self.samples.set() else { return Ok(Done::default()) };
        let views = set.views()?;
        let aligned = self.alignment.as_ref().map(CheckedSample::view);
        let aligned = aligned.filter(|alignment| alignment.validity() == PoseValidity::Effective);
        let aligned_storey = aligned.and_then(|alignment| alignment.pose().map(|pose| pose.map_storey));
        let Some(storey) = storey_of_robot(self.config.ros.storey, aligned_storey, views.grids.len()) else {
            self.warning = Some(format!("ros.storey: there is no such storey among {}", views.grids.len()));
            return Ok(Done::default());
        };
        self.warning = None;
        let plan = set.mission_plan.map(CheckedSample::content_hash);
        let now = (storey, set.index.content_hash(), plan);
        if self.published == Some(now) {
            return Ok(Done::default());
        }
        self.activity.set(Activity::Writing);
        let epoch = set.index.bytes().header().epoch;
        let outputs = outputs_of(&views, storey, epoch, &self.config.ros, self.publishers.keepout_mask.name(), stamp());
        if let Some(foxglove) = &self.foxglove {
            let map_storey = views.grids[storey].head.map_storey;
            foxglove.show(&outputs, each_room(&views.site, &views.state, map_storey));
        }
        self.publishers.send(outputs);
        info!(service = "ros-bridge", storey, epoch, "maps published");
        self.published = Some(now);
        self.activity.set(Activity::Published);
        Ok(Done::default())
    }

    /// The transform of an effective alignment; what is not effective any more is not repeated, and no other one is made up.
    fn show_alignment(&mut self) {
        let Some(alignment) = &self.alignment else { return };
        let RosConfig { slam_frame, frame, .. } = &self.config.ros;
        let (alignment, now) = (alignment.view(), stamp());
        if let Some(transform) = transform_of(&alignment, slam_frame, frame, now) {
            if let (Some(foxglove), Some(pose)) = (&self.foxglove, alignment.pose()) {
                foxglove.show_alignment(&transform, &alignment_pose(pose, frame, now));
            }
            self.publishers.tf_static.publish(transform);
            self.has_transform = true;
        }
    }

    fn show_diagnostics(&self) {
        let board = StatusBoard::of(&self.config.bus.root);
        let processes = SiteProcess::supervised(&self.config);
        let diagnostics = diagnostics(&board, processes, stamp());
        if let Some(foxglove) = &self.foxglove {
            foxglove.show_diagnostics(&diagnostics);
        }
        self.publishers.diagnostics.publish(diagnostics);
    }
}

impl Publishers {
    /// The keep-out mask before the map that needs it.
    fn send(&self, outputs: Outputs) {
        let Outputs { map, localization_map, keepout_mask, keepout_info, rooms, waypoints, route, changed } = outputs;
        self.keepout_info.publish(keepout_info);
        self.keepout_mask.publish(keepout_mask);
        self.localization_map.publish(localization_map);
        self.map.publish(map);
        self.rooms.publish(rooms);
        self.waypoints.publish(waypoints);
        self.route.publish(route);
        self.changed.publish(changed);
    }
}

/// Refuses a configuration with which the bridge would take its own map for the robot's.
fn check(config: &RosConfig) -> Result<(), Failure> {
    let own = crate::graph::full_name(&config.namespace, config.map_topic.as_deref().unwrap_or("map"));
    let taken = config.slam_map_topic.as_deref().map(|topic| crate::graph::full_name(&config.namespace, topic));
    if taken.as_ref() == Some(&own) {
        return Err(
            format!("ros.slam_map_topic is {own}, on which the bridge publishes: set another ros.map_topic").into()
        );
    }
    if config.frame == config.slam_frame {
        return Err(format!("ros.frame and ros.slam_frame are both {:?}: they are two frames", config.frame).into());
    }
    Ok(())
}

/// The machine's clock.
fn stamp() -> Time {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Time { sec: i32::try_from(now.as_secs()).unwrap_or(i32::MAX), nanosec: now.subsec_nanos() }
}

impl Service for BridgeService {
    type Input = BridgeInput;
    type Request = RosBridgeRequest;
    type Facts = RosBridgeFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // Samples belong to a generation of the bus that is gone; they come again.
        (self.samples, self.alignment) = (SiteSamples::default(), None);
        let slots = GridSlot::all().map(TopicName::Grid);
        self.grids = slots.map(|slot| bus.raw_subscriber(slot)).collect::<Result<_, _>>()?;
        match &self.slam_map {
            Some(input) => input.lock().unwrap_or_else(PoisonError::into_inner).attach(),
            None => Ok(()),
        }
    }

    fn handle(&mut self, event: Event<BridgeInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(BridgeInput::Site(site)) => self.samples.insert(SiteSample::Site(site)),
            Event::Input(BridgeInput::ScheduleState(state)) => self.samples.insert(SiteSample::ScheduleState(state)),
            Event::Input(BridgeInput::Grids(index)) => self.samples.insert(SiteSample::Index(index)),
            Event::Input(BridgeInput::MissionPlan(plan)) => self.samples.insert(SiteSample::MissionPlan(plan)),
            Event::Input(BridgeInput::Alignment(alignment)) => {
                self.alignment = Some(alignment);
                self.show_alignment();
            }
            Event::Configuration(config) => {
                if config.ros != self.config.ros {
                    return Err("[ros] cannot change while ros-bridge runs: restart it".into());
                }
            }
            Event::Tick => {
                self.foxglove.iter_mut().for_each(FoxgloveServer::listen);
                self.show_diagnostics();
            }
            Event::Attached => {}
        }
        self.show()
    }

    fn answer(&mut self, request: RosBridgeRequest, _asked: &Asked) -> Result<Done<()>, Failure> {
        match request {}
    }

    fn standing(&self) -> Standing {
        Standing { error: self.foxglove.as_ref().and_then(FoxgloveServer::error), warning: self.warning.clone() }
    }

    fn facts(&self) -> RosBridgeFacts {
        RosBridgeFacts {
            storey: self.published.map(|(storey, ..)| storey),
            has_transform: self.has_transform,
            foxglove: self.foxglove.as_ref().and_then(FoxgloveServer::address),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_topic_out_and_in_are_two_topics_and_frames_are_two_frames() {
        let config = |slam_map_topic: &str, map_topic: Option<&str>| RosConfig {
            slam_map_topic: Some(slam_map_topic.to_owned()),
            map_topic: map_topic.map(str::to_owned),
            ..RosConfig::default()
        };
        assert!(check(&config("/map", None)).is_ok() && check(&config("/map", Some("planned"))).is_ok());
        for same in [config("/map", Some("/map")), config("map", None), config("/groundplan/map", None)] {
            assert!(check(&same).unwrap_err().to_string().contains("slam_map_topic"), "{same:?}");
        }
        assert!(check(&RosConfig { frame: "map".to_owned(), ..RosConfig::default() }).is_err());
    }
}
