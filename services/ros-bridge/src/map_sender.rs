//! The thread that publishes maps: Nav2 may take seconds to stop the robot, and the service does not wait for it.

use crate::graph::MapTopics;
use crate::nav2::{Nav2, RouteGraph};
use crate::outputs::{GridMessages, GridsKey, Outputs};
use daemon::{Failure, Watched, chain, joined, write_durably};
use ros::maps::keepout_everywhere;
use ros::msg::nav_msgs::MapMetaData;
use ros::msg::std_msgs::{self, Header};
use site_view::MapsInUse;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// How long mask and map wait for their readers: what does not fit into the buffer of a reader's socket is lost, and sent again slowly.
const TIMEOUT: Duration = Duration::from_secs(3);
/// The same while Nav2 stands. A reader that leaves the graph without saying so is known to be gone after that time.
const NAV2_TIMEOUT: Duration = Duration::from_secs(10);
/// Interval at which readers that are late are looked at again.
const LATE_INTERVAL: Duration = Duration::from_secs(1);

/// What is to be published.
pub(crate) enum Job {
    /// A set of maps.
    Maps(Box<Outputs>),
    /// The maps must not be used: the robot stops.
    Stale {
        /// True to keep it out of everything, too.
        closes_mask: bool,
    },
}

/// What has been published.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sent {
    /// The newest maps.
    pub(crate) maps: Option<MapsInUse>,
    /// Their storey.
    pub(crate) storey: Option<u32>,
    /// Metres per cell.
    pub(crate) resolution_m: Option<f64>,
    /// What an operator should know of the last publication.
    pub(crate) warning: Option<String>,
}

/// Shared with the thread: the newest job, an older one is left out, and what was done last.
#[derive(Default)]
struct Shared {
    job: Watched<Option<Job>>,
    sent: Watched<Sent>,
}

/// Publishes maps on a thread.
pub(crate) struct MapSender(Arc<Shared>);

impl MapSender {
    /// Starts the thread. Route graphs are written into a folder, which is made.
    ///
    /// # Errors
    /// The folder cannot be made, the system cannot start a thread.
    pub(crate) fn start(topics: MapTopics, nav2: Option<Nav2>, route_folder: PathBuf) -> Result<Self, Failure> {
        std::fs::create_dir_all(&route_folder)?;
        let shared = Arc::new(Shared::default());
        let of_thread = Arc::clone(&shared);
        let mut publication = Publication {
            topics,
            nav2,
            route_folder,
            grids: None,
            mask: None,
            route_graph: None,
            is_paused: false,
            late: None,
            sent: Sent::default(),
        };
        let publish = move || {
            loop {
                match of_thread.next(publication.late.is_some().then_some(LATE_INTERVAL)) {
                    Some(job) => publication.run(job),
                    None => publication.look_at_late_readers(),
                }
                *of_thread.sent.lock() = publication.sent();
            }
        };
        thread::Builder::new().name("ros-maps".to_owned()).spawn(publish)?;
        Ok(Self(shared))
    }

    /// Publishes this next.
    pub(crate) fn send(&self, job: Job) {
        self.0.job.change(|next| *next = Some(job));
    }

    /// What has been published.
    pub(crate) fn sent(&self) -> Sent {
        self.0.sent.lock().clone()
    }
}

impl Shared {
    /// The next job; `None` if there is none within this time.
    fn next(&self, longest: Option<Duration>) -> Option<Job> {
        self.job.wait_while(longest, |job| job.is_none()).take()
    }
}

/// The work of the thread.
struct Publication {
    topics: MapTopics,
    nav2: Option<Nav2>,
    route_folder: PathBuf,
    /// The grids that are out; `None` before the first, and while a mask of everything is in their place.
    grids: Option<GridsKey>,
    /// Where the newest mask lies.
    mask: Option<(Header, MapMetaData)>,
    /// The route graph that is out.
    route_graph: Option<RouteGraph>,
    /// True while Nav2 has been told to stop, and not to go on.
    is_paused: bool,
    /// What an operator should know while a reader has not taken mask or map.
    late: Option<String>,
    sent: Sent,
}

impl Publication {
    fn run(&mut self, job: Job) {
        match job {
            Job::Stale { closes_mask } => {
                self.sent.warning = warning_of(self.pause());
                if let Some((header, info)) = self.mask.clone().filter(|_| closes_mask) {
                    let closed = self.topics.keepout_mask.publish(keepout_everywhere(header, info));
                    self.sent.warning = self.sent.warning.take().or(warning_of(closed));
                    self.grids = None;
                }
            }
            Job::Maps(outputs) => self.publish(*outputs),
        }
    }

    /// The robot stops before its map changes; the keep-out mask is out before the map that needs it.
    fn publish(&mut self, outputs: Outputs) {
        let Outputs { key, grids, rooms, waypoints, route, route_graph, changed, maps } = outputs;
        let resolution_m = grids.resolution_m;
        let is_changed = self.grids != Some(key);
        let mut called = Ok(());
        if is_changed {
            called = self.pause();
            self.mask = Some((grids.keepout_mask.header.clone(), grids.keepout_mask.info));
            let sent = self.publish_grids(grids);
            // Grids that are not sent go out with the next set, also if they are the same.
            self.grids = sent.is_ok().then_some(key);
            called = called.and(sent);
        }
        self.topics.rooms.publish(rooms);
        self.topics.waypoints.publish(waypoints);
        self.topics.route.publish(route);
        if let Some(graph) = route_graph {
            self.write_route_graph(key.storey, graph);
        }
        if let Some(nav2) = &mut self.nav2 {
            called = called.and(nav2.load(self.route_graph.as_ref(), is_changed));
        }
        self.topics.changed.publish(changed);
        called = called.and(self.resume());
        info!(service = "ros-bridge", storey = key.storey, epoch = maps.epoch, resolution_m, "maps published");
        self.sent = Sent {
            maps: Some(maps),
            storey: Some(key.storey),
            resolution_m: Some(resolution_m),
            warning: warning_of(called),
        };
    }

    fn pause(&mut self) -> Result<(), Failure> {
        let Some(nav2) = self.nav2.as_ref().filter(|_| !self.is_paused) else { return Ok(()) };
        self.is_paused = true;
        nav2.pause()
    }

    fn resume(&mut self) -> Result<(), Failure> {
        let Some(nav2) = self.nav2.as_ref().filter(|_| self.is_paused) else { return Ok(()) };
        self.is_paused = false;
        nav2.resume()
    }

    /// What has been published, with all that an operator should know.
    fn sent(&self) -> Sent {
        let warnings = [&self.sent.warning, &self.late].into_iter().flatten().map(String::as_str);
        Sent { warning: joined(warnings), ..self.sent.clone() }
    }

    /// The map goes out when the readers have the mask, and a robot that stands goes on when they have both, and not while parts of
    /// them are sent again; but nobody waits for ever for a reader.
    fn publish_grids(&mut self, grids: GridMessages) -> Result<(), Failure> {
        let MapTopics { keepout_info, keepout_mask, speed_mask, speed_info, map, localization_map, grid_map, .. } =
            &self.topics;
        let deadline = Instant::now() + if self.is_paused { NAV2_TIMEOUT } else { TIMEOUT };
        keepout_info.publish(grids.keepout_info);
        let mut sent = keepout_mask.publish(grids.keepout_mask);
        if let Some((mask, info)) = grids.speed {
            speed_info.publish(info);
            sent = sent.and(speed_mask.publish(mask));
        }
        keepout_mask.is_taken_until(deadline);
        sent = sent.and(map.publish(grids.map));
        map.is_taken_until(deadline);
        sent = sent.and(localization_map.publish(grids.localization_map));
        if let Some(heights) = grids.grid_map {
            sent = sent.and(grid_map.publish(heights));
        }
        self.look_at_late_readers();
        sent
    }

    fn look_at_late_readers(&mut self) {
        let MapTopics { keepout_mask, map, .. } = &self.topics;
        let late = [keepout_mask, map].into_iter().find(|topic| !topic.is_taken_until(Instant::now()));
        let late = late.map(|topic| format!("a reader has not taken {} yet", topic.name()));
        if late.is_some() && late != self.late {
            warn!(service = "ros-bridge", late);
        }
        self.late = late;
    }

    /// The file of another route graph; one that cannot be written is logged, and the graph before it stays in use.
    fn write_route_graph(&mut self, storey: u32, graph: Vec<u8>) {
        let path = self.route_folder.join(format!("storey-{storey:02}.geojson"));
        let graph = RouteGraph { path, bytes: graph };
        if self.route_graph.as_ref() == Some(&graph) {
            return;
        }
        let path = graph.path.display().to_string();
        if let Err(why) = write_durably(&graph.path, &graph.bytes) {
            warn!(service = "ros-bridge", path, error = chain(&why), "the route graph cannot be written");
            return;
        }
        self.topics.route_graph.publish(std_msgs::String { data: path });
        self.route_graph = Some(graph);
    }
}

/// What an operator should know of a call that failed.
fn warning_of(called: Result<(), Failure>) -> Option<String> {
    let why = called.err()?;
    let warning = chain(why.as_ref());
    warn!(service = "ros-bridge", warning);
    Some(warning)
}
