//! The robot's SLAM map: grids of ROS 2 in, the topic `slam-map` out.

use bus::{Bus, Daemon, Origin, Publisher, topics};
use daemon::{Epochs, Failure, SiteConfig, chain};
use messages::{ArchiveBuffer, InputHashes, SlamMap, SlamMapHead};
use ros::msg::geometry_msgs::Quaternion;
use ros::msg::nav_msgs::OccupancyGrid;
use tracing::{info, warn};

/// Bytes that the topic begins with; it grows with the map.
const FIRST_BYTES: usize = 1 << 20;
/// A pose that is turned out of the plane by more than this is none of a map.
const MAX_TILT: f64 = 1e-3;

/// A grid that is no map of a robot.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub(crate) enum GridFault {
    #[error("the grid has {cells} cells, and its width and height make {expected}")]
    Cells { cells: usize, expected: u64 },
    #[error("the grid has a cell of {value}: -1 or 0 to 100 is meant")]
    Value { value: i8 },
    #[error("the origin of the grid is turned out of the plane")]
    Tilted,
    #[error("{0}")]
    Unusable(String),
}

/// The archive of a grid.
///
/// # Errors
/// A grid that is no map of a robot.
pub(crate) fn slam_map_of(grid: &OccupancyGrid) -> Result<ArchiveBuffer, GridFault> {
    let (info, cells) = (&grid.info, &grid.data.0);
    let expected = u64::from(info.width) * u64::from(info.height);
    if cells.len() as u64 != expected {
        return Err(GridFault::Cells { cells: cells.len(), expected });
    }
    if let Some(&value) = cells.iter().find(|value| !(-1..=100).contains(*value)) {
        return Err(GridFault::Value { value });
    }
    let origin = [info.origin.position.x, info.origin.position.y, yaw_rad(&info.origin.orientation)?];
    // As the map server reads its own files: seven digits of a resolution are what a float has.
    let resolution_m = (f64::from(info.resolution) * 1e7).round() / 1e7;
    let head = SlamMapHead { resolution_m, origin, width: info.width, height: info.height };
    let archive = SlamMap::write(&head, cells);
    match SlamMap::open(archive.bytes()) {
        Ok(_) => Ok(archive),
        Err(why) => Err(GridFault::Unusable(chain(&why))),
    }
}

/// The turn about the vertical axis; a quaternion of zeros, as from a publisher that sets none, is no turn.
fn yaw_rad(q: &Quaternion) -> Result<f64, GridFault> {
    let Quaternion { x, y, z, w } = *q;
    let norm = libm::sqrt(x * x + y * y + z * z + w * w);
    if norm == 0.0 {
        return Ok(0.0);
    }
    let is_flat = norm.is_finite() && libm::hypot(x, y) / norm <= MAX_TILT;
    if is_flat { Ok(2.0 * libm::atan2(z, w)) } else { Err(GridFault::Tilted) }
}

/// Brings grids to the bus.
pub(crate) struct SlamMapInput {
    config: SiteConfig,
    epochs: Epochs,
    /// The robot's side of the current generation of the bus.
    publisher: Option<(Bus, Publisher<topics::SlamMap>)>,
    /// The last map and its content hash: the same grid comes from a latched and from another subscription.
    last: Option<(ArchiveBuffer, u64)>,
}

impl SlamMapInput {
    /// Nothing has come yet.
    ///
    /// # Errors
    /// State that cannot be used.
    pub(crate) fn new(config: &SiteConfig) -> Result<Self, Failure> {
        let epochs = Epochs::at(&config.state, "ros-bridge-slam-map-epochs.json")?;
        Ok(Self { config: config.clone(), epochs, publisher: None, last: None })
    }

    /// The bus has another generation: the last map comes there, too.
    ///
    /// # Errors
    /// Another robot publishes maps, no room in shared memory.
    pub(crate) fn attach(&mut self) -> Result<(), Failure> {
        self.publisher = None;
        let (bus, _waiter) = Bus::join(&self.config.domain()?, Daemon::Robot)?;
        let publisher = bus.publisher(topics::SlamMap, FIRST_BYTES)?;
        self.publisher = Some((bus, publisher));
        match self.last.take() {
            Some((archive, hash)) => self.publish(archive, hash),
            None => Ok(()),
        }
    }

    /// A grid has come. What is no map is refused, and the map before it stays.
    pub(crate) fn take(&mut self, grid: &OccupancyGrid) {
        if let Err(why) = self.pass_on(grid) {
            let error = chain(why.as_ref());
            warn!(service = "ros-bridge", frame = grid.header.frame_id, error, "a SLAM map is not taken");
        }
    }

    fn pass_on(&mut self, grid: &OccupancyGrid) -> Result<(), Failure> {
        let archive = slam_map_of(grid)?;
        let hash = SlamMap::open(archive.bytes())?.content_hash();
        if self.last.as_ref().is_some_and(|(_, last)| *last == hash) {
            return Ok(());
        }
        self.publish(archive, hash)?;
        let (width, height) = (grid.info.width, grid.info.height);
        info!(service = "ros-bridge", width, height, frame = grid.header.frame_id, "SLAM map taken");
        Ok(())
    }

    /// Publishes a map; without a bus it comes to the next one.
    fn publish(&mut self, archive: ArchiveBuffer, hash: u64) -> Result<(), Failure> {
        let sent = match &self.publisher {
            Some((_, publisher)) => {
                let origin = Origin { epoch: self.epochs.take()?, frame_epoch: 0, inputs: InputHashes::default() };
                publisher.publish_copy(archive.bytes(), origin).map(drop).map_err(Failure::from)
            }
            None => Ok(()),
        };
        self.last = Some((archive, hash));
        sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ros::msg::geometry_msgs::{Point, Pose};
    use ros::msg::nav_msgs::{Int8Array, MapMetaData};

    fn grid(change: impl FnOnce(&mut OccupancyGrid)) -> OccupancyGrid {
        let orientation = Quaternion { x: 0.0, y: 0.0, z: libm::sin(0.25), w: libm::cos(0.25) };
        let origin = Pose { position: Point { x: 1.0, y: -2.0, z: 0.0 }, orientation };
        let mut grid = OccupancyGrid {
            info: MapMetaData { resolution: 0.05, width: 3, height: 2, origin, ..MapMetaData::default() },
            data: Int8Array(vec![-1, 0, 100, 50, 0, -1]),
            ..OccupancyGrid::default()
        };
        change(&mut grid);
        grid
    }

    #[test]
    fn a_grid_is_a_slam_map_with_its_place() {
        let archive = slam_map_of(&grid(|_| {})).unwrap();
        let map = SlamMap::open(archive.bytes()).unwrap();
        assert_eq!((map.head.width, map.head.height, map.head.resolution_m), (3, 2, 0.05));
        assert!((map.head.origin[2] - 0.5).abs() < 1e-12 && map.head.origin[..2] == [1.0, -2.0]);
        assert_eq!(map.occupancy, [-1, 0, 100, 50, 0, -1]);
        let unturned = grid(|grid| grid.info.origin.orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 });
        assert_eq!(SlamMap::open(slam_map_of(&unturned).unwrap().bytes()).unwrap().head.origin[2], 0.0);
    }

    #[test]
    fn a_grid_that_is_no_map_is_refused_with_why() {
        let refused = |change: fn(&mut OccupancyGrid)| slam_map_of(&grid(change)).map(drop).unwrap_err();
        assert_eq!(refused(|grid| grid.info.width = 4), GridFault::Cells { cells: 6, expected: 8 });
        assert_eq!(
            refused(|grid| grid.info.width = u32::MAX).to_string(),
            "the grid has 6 cells, and its width and height make 8589934590"
        );
        assert_eq!(refused(|grid| grid.data.0[1] = 101), GridFault::Value { value: 101 });
        assert_eq!(refused(|grid| grid.info.origin.orientation.x = 1.0), GridFault::Tilted);
        assert_eq!(refused(|grid| grid.info.origin.orientation.w = f64::NAN), GridFault::Tilted);
        assert!(matches!(refused(|grid| grid.info.resolution = f32::NAN), GridFault::Unusable(_)));
        assert!(matches!(refused(|grid| grid.info.origin.position.x = f64::INFINITY), GridFault::Unusable(_)));
    }
}
