//! The ros-bridge service: publishes the maps of the robot's storey whenever they change, and takes its SLAM map.

use crate::calls;
use crate::followed_transform::FollowedTransform;
use crate::foxglove::FoxgloveServer;
use crate::graph::{MapTopics, RosGraph, StateTopics};
use crate::kept_slam_frame::KeptSlamFrame;
use crate::machine_clock::{stamp, utc_ms};
use crate::map_sender::{Job, MapSender};
use crate::nav2::Nav2;
use crate::outdoors::OutdoorFollower;
use crate::outputs::{Outputs, Target, diagnostics, heartbeat, outputs_of, state_on};
use crate::portals::PortalFollower;
use crate::rivals::Rivals;
use crate::robot::Robot;
use crate::sim_time::ClockFollower;
use crate::slam_map::SlamMapInput;
use crate::storey::RobotStorey;
use bus::{Bus, CheckedSample, Stamp, topics};
use daemon::facts::{Pose, RosBridgeFacts};
use daemon::{
    Asked, CurrentActivity, Done, Event, Failure, RosBridgeRequest, RosConfig, Service, SiteConfig, Standing,
    StatusBoard, joined, state_files,
};
use frames::Point2;
use messages::{Activity, AlignmentVerdict, ContentHash, ContentId, PoseRecord, PoseValidity};
use ros::markers::each_room;
use ros::msg::tf2_msgs::TFMessage;
use ros::transforms::{alignment_pose, pose_in_map, site_map_from_map};
use site_view::{Freshness, MapState, SiteReader, SiteSample, SiteSamples};
use std::sync::Arc;
use std::time::Instant;
use tracing::{error, info};

daemon::inputs! {
    /// What is shown to ROS 2.
    pub(crate) enum BridgeInput { Site, ScheduleState, Grids, MissionPlan, Alignment }
}

/// Content hashes of what was handed to the sender, the storey, and the number of the robot's frame that grids are moved into.
type Published = (usize, ContentHash, Option<ContentHash>, Option<u64>);

/// Publishes in ROS 2.
pub(crate) struct BridgeService {
    config: SiteConfig,
    activity: CurrentActivity,
    /// The node; it leaves the graph with the daemon.
    graph: RosGraph,
    topics: StateTopics,
    mask_topic: String,
    speed_topic: String,
    rivals: Rivals,
    sender: MapSender,
    foxglove: Option<FoxgloveServer>,
    slam_map: Option<Arc<SlamMapInput>>,
    robot: Robot,
    clock: ClockFollower,
    samples: SiteSamples,
    grids: SiteReader,
    alignment: Option<CheckedSample<topics::Alignment>>,
    slam_frame: KeptSlamFrame,
    storey: RobotStorey,
    portals: PortalFollower,
    outdoors: OutdoorFollower,
    published: Option<Published>,
    freshness: Freshness,
    /// True from the moment that maps are stale until maps are published again.
    is_stopped: bool,
    /// The transform on `/tf_static`.
    transform: FollowedTransform,
    transform_updated: Instant,
    /// Why there is nothing to show, and that a person has to change it.
    warning: Option<String>,
    /// The same, and that it comes by itself.
    obstacle: Option<String>,
}

impl BridgeService {
    /// Joins the graph.
    ///
    /// # Errors
    /// A configuration that cannot be used, no network.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let ros = &config.ros;
        ros.check()?;
        let mut graph = RosGraph::join(ros)?;
        let map_topics = MapTopics::open(&mut graph, ros)?;
        let topics = StateTopics::open(&mut graph, ros)?;
        let topics_of_grids = [&map_topics.map, &map_topics.keepout_mask, &map_topics.speed_mask];
        let [map_topic, mask_topic, speed_topic] = topics_of_grids.map(|topic| topic.name().to_owned());
        let slam_map_topic = ros.slam_map_topic.as_deref().map(|topic| ros.full_name(topic));
        let rivals = Rivals::on(vec![map_topic, mask_topic.clone()], slam_map_topic);
        let foxglove = ros.foxglove.as_ref().map(|foxglove| FoxgloveServer::start(foxglove, config)).transpose()?;
        let nav2 = ros.nav2.as_ref().map(|nav2| Nav2::of(&mut graph, nav2, ros.service_mapping)).transpose()?;
        let slam_map = match &ros.slam_map_topic {
            Some(topic) => {
                let input = Arc::new(SlamMapInput::new(config)?);
                let taken = Arc::clone(&input);
                graph.take_grids(topic, move |grid| taken.take(grid))?;
                Some(input)
            }
            None => None,
        };
        let robot = Robot::follow(&mut graph, ros)?;
        calls::serve(&mut graph, config)?;
        let clock = ClockFollower::start(&mut graph, config)?;
        Ok(Self {
            config: config.clone(),
            activity,
            graph,
            topics,
            mask_topic,
            speed_topic,
            rivals,
            sender: MapSender::start(map_topics, nav2, config.state.join(state_files::ROS_MAPS))?,
            foxglove,
            slam_map,
            robot,
            clock,
            samples: SiteSamples::default(),
            grids: SiteReader::default(),
            alignment: None,
            slam_frame: KeptSlamFrame::default(),
            storey: RobotStorey::of(config)?,
            portals: PortalFollower::default(),
            outdoors: OutdoorFollower::default(),
            published: None,
            freshness: Freshness::default(),
            is_stopped: false,
            transform: FollowedTransform::default(),
            transform_updated: Instant::now(),
            warning: None,
            obstacle: None,
        })
    }

    /// Publishes the newest set, if it belongs together and is not published.
    fn show(&mut self) -> Result<Done, Failure> {
        self.grids.take(|grid| self.samples.insert(grid))?;
        (self.warning, self.obstacle) = (None, None);
        let Some(set) = self.samples.set() else { return Ok(Done::default()) };
        let views = set.views()?;
        let Some(storey) = self.storey.index(self.slam_frame.map_storey(), views.grids.len()) else {
            self.warning = Some(format!("the robot's storey: there is no such storey among {}", views.grids.len()));
            return Ok(Done::default());
        };
        // All storeys lie in one frame, also where the robot's map is that of another storey.
        let slam_frame = self.slam_frame.get().filter(|_| self.config.ros.in_slam_frame);
        if self.config.ros.in_slam_frame && slam_frame.is_none() {
            self.obstacle = Some("no pose of the robot's map is in effect for any part of it".to_owned());
            return Ok(Done::default());
        }
        let plan = set.mission_plan.map(CheckedSample::content_hash);
        let now = (storey, set.index.content_hash(), plan, slam_frame.map(|(number, _)| number));
        if self.published == Some(now) {
            return Ok(Done::default());
        }
        self.activity.set(Activity::Writing);
        let epoch = set.index.bytes().header().epoch;
        let target = Target {
            config: &self.config.ros,
            mask_topic: &self.mask_topic,
            speed_topic: &self.speed_topic,
            slam_frame,
            stamp: stamp(),
        };
        let outputs: Outputs = outputs_of(&views, storey, epoch, target)?;
        if let Some(foxglove) = &self.foxglove {
            foxglove.show(&outputs, each_room(&views.site, &views.state, outputs.key.storey));
            foxglove.show_world(&views.grids[storey], ContentId::of(set.index.bytes().bytes()).short());
        }
        self.sender.send(Job::Maps(Box::new(outputs)));
        self.is_stopped = false;
        self.published = Some(now);
        self.activity.set(Activity::Published);
        Ok(Done::default())
    }

    /// The pose of the robot's map around the robot with what it is worth there, or of all of it if nobody tells where the robot is.
    fn pose_around_robot(&self) -> Option<(PoseRecord, PoseValidity)> {
        self.alignment.as_ref()?.view().pose_around(self.robot_m())
    }

    /// That pose, if it may be used.
    fn usable_pose(&self) -> Option<PoseRecord> {
        self.alignment.as_ref()?.view().usable(self.robot_m()).ok()
    }

    /// Where the robot is in its map, if somebody tells that.
    fn robot_m(&self) -> Option<[f64; 2]> {
        self.robot.pose().map(|robot| [robot.x_m, robot.y_m])
    }

    /// Publishes the transform of the alignment around the robot, which follows the robot slowly through a map that bends; what is not
    /// effective where the robot is is not repeated, and no other one is made up. A localiser begins anew at each initial pose: it is
    /// told with a new alignment whose search was accepted only.
    fn show_alignment(&mut self, is_new: bool) {
        let elapsed = std::mem::replace(&mut self.transform_updated, Instant::now()).elapsed();
        let RosConfig { slam_frame, frame, .. } = &self.config.ros;
        let Some(around) = self.pose_around_robot().filter(|_| frame != slam_frame) else { return };
        let robot = self.robot.pose();
        if !self.transform.update(around, self.robot_m(), elapsed) {
            return;
        }
        let (Some(pose), now) = (self.transform.published(), stamp()) else { return };
        let message = TFMessage { transforms: vec![site_map_from_map(pose, slam_frame, frame, now)] };
        if let Some(foxglove) = &self.foxglove {
            foxglove.show_alignment(&message, &alignment_pose(pose, frame, now));
        }
        self.topics.tf_static.publish(message);
        let is_accepted = self.alignment.as_ref().is_some_and(|a| a.view().verdict() == AlignmentVerdict::Accepted);
        if let Some(Pose { x_m, y_m, yaw_rad }) = robot.filter(|_| is_new && is_accepted) {
            self.topics.initial_pose.publish(pose_in_map(pose, [x_m, y_m, yaw_rad], frame, stamp()));
        }
    }

    /// The robot in the model's map, by the alignment that is in effect.
    fn robot_in_map(&self) -> Option<Pose> {
        self.robot.pose_in_map(&self.usable_pose()?)
    }

    /// Takes the storey at the end of a portal that the robot has gone through, and that on which it has driven outdoors or come in.
    fn follow_robot(&mut self) -> Result<(), Failure> {
        let follows = self.config.ros.follow_portals;
        let (true, Some(shown), Some(pose)) = (follows, self.published, self.usable_pose()) else {
            return Ok(());
        };
        let Some(robot) = self.robot.pose_in_map(&pose) else { return Ok(()) };
        let Some(set) = self.samples.set() else { return Ok(()) };
        let views = set.views()?;
        let at = Point2::new(robot.x_m, robot.y_m);
        let plan = views.mission_plan.as_ref();
        let behind = plan.and_then(|plan| self.portals.update(plan, u32::try_from(shown.0).unwrap_or(u32::MAX), at));
        let step_m = views.index.head.robot.step_height_m;
        let beside = self.outdoors.update(&views.grids, shown.0, at, step_m);
        if let Some(storey) = behind.or(beside.and_then(|storey| u32::try_from(storey).ok())) {
            info!(service = "ros-bridge", storey, "the robot has gone to another storey");
            self.storey.follow(storey, pose.map_storey)?;
        }
        Ok(())
    }

    /// Once a second: heartbeat, diagnostics, and what follows when maps become stale or fresh.
    fn tick(&mut self) {
        let board = StatusBoard::of_own(&self.config);
        daemon::hear_daemons(&board, &mut self.freshness);
        self.freshness.set_obstacle(self.warning.clone().or_else(|| self.obstacle.clone()));
        let sent = self.sender.sent();
        if let Some(maps) = &sent.maps {
            self.freshness.on_maps(maps.clone());
        }
        let now = Stamp::now();
        let state = self.freshness.state(now, utc_ms());
        let state = state_on(sent.storey, state, self.freshness.late_storeys(now));
        match &state {
            MapState::Stale { .. } if !self.is_stopped => {
                self.sender.send(Job::Stale { closes_mask: self.config.ros.keepout_when_stale });
                self.is_stopped = true;
            }
            // Fresh ones come again, also if they are the same.
            MapState::Fresh { .. } if self.is_stopped => self.published = None,
            _ => {}
        }
        let head = self.freshness.schedule_state();
        self.topics.heartbeat.publish(heartbeat(&state, self.freshness.maps(), head, sent.storey));
        self.graph.tell_entities();
        self.rivals.look(&self.graph);
        let processes = board.processes(&self.config);
        let diagnostics = diagnostics(&board, processes, stamp());
        if let Some(foxglove) = &mut self.foxglove {
            foxglove.listen();
            foxglove.show_diagnostics(&diagnostics);
        }
        self.topics.diagnostics.publish(diagnostics);
    }
}

impl Service for BridgeService {
    type Input = BridgeInput;
    type Request = RosBridgeRequest;
    type Facts = RosBridgeFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // Samples belong to a generation of the bus that is gone; they come again.
        (self.samples, self.alignment) = (SiteSamples::default(), None);
        self.freshness.joined(Stamp::now());
        self.grids = SiteReader::of_grids(bus)?;
        match &self.slam_map {
            Some(input) => input.attach(),
            None => Ok(()),
        }
    }

    fn handle(&mut self, event: Event<BridgeInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(BridgeInput::Site(site)) => self.samples.insert(SiteSample::Site(site)),
            Event::Input(BridgeInput::ScheduleState(state)) => {
                self.freshness.on_schedule_state(Stamp::now(), state.content_hash(), state.view().head);
                self.samples.insert(SiteSample::ScheduleState(state));
            }
            Event::Input(BridgeInput::Grids(index)) => {
                self.freshness.on_index(Stamp::now(), index.view().head, index.view().slots.to_vec());
                self.samples.insert(SiteSample::Index(index));
            }
            Event::Input(BridgeInput::MissionPlan(plan)) => self.samples.insert(SiteSample::MissionPlan(plan)),
            Event::Input(BridgeInput::Alignment(alignment)) => {
                self.slam_frame.take(alignment.view().slam_frame());
                self.alignment = Some(alignment);
                self.show_alignment(true);
            }
            Event::Configuration(config) => {
                if config.ros != self.config.ros {
                    return Err("[ros] cannot change while ros-bridge runs: restart it".into());
                }
            }
            Event::Tick => {
                if let Some(why) = self.graph.failure() {
                    error!(service = "ros-bridge", why, "this process ends, and is started again");
                    std::process::exit(1);
                }
                self.slam_map.iter().for_each(|input| input.retry());
                self.tick();
                self.show_alignment(false);
                self.follow_robot()?;
            }
            Event::Attached => {}
        }
        self.show()
    }

    fn answer(&mut self, request: RosBridgeRequest, _asked: &Asked) -> Result<Done<Option<()>>, Failure> {
        let RosBridgeRequest::SetStorey { storey } = request;
        let set = self.samples.set();
        let n_storeys = set.map(|set| set.grids.len());
        if let (Some(storey), Some(n_storeys)) = (storey, n_storeys)
            && storey as usize >= n_storeys
        {
            return Err(format!("there is no storey {storey} among {n_storeys}").into());
        }
        self.storey.set(storey)?;
        Ok(self.show()?.answered(Some(())))
    }

    fn standing(&self) -> Standing {
        let warnings = [
            self.warning.clone(),
            self.storey.finding().map(str::to_owned),
            self.sender.sent().warning,
            self.rivals.of_maps(),
            self.rivals.of_slam_maps(),
            self.slam_map.as_ref().and_then(|input| input.warning()),
            self.clock.warning(),
        ];
        let error = self.foxglove.as_ref().and_then(FoxgloveServer::error);
        Standing { error, warning: joined(warnings.into_iter().flatten()) }
    }

    fn facts(&self) -> RosBridgeFacts {
        let sent = self.sender.sent();
        RosBridgeFacts {
            storey: sent.storey,
            set_storey: self.storey.was_set(),
            known_storey: self.storey.known(self.slam_frame.map_storey()),
            resolution_m: sent.resolution_m,
            has_transform: self.transform.published().is_some(),
            robot_in_slam_map: self.robot.pose(),
            robot_in_map: self.robot_in_map(),
            robot_seen_ns: self.robot.seen_ago().map(|age| Stamp::now().0.saturating_sub(age.as_nanos() as u64)),
            domain_id: self.graph.domain_id(),
            peers: self.rivals.peers().clone(),
            foxglove: self.foxglove.as_ref().and_then(FoxgloveServer::address),
        }
    }
}
