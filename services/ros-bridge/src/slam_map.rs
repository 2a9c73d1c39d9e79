//! The robot's SLAM map: grids of ROS 2 in, the topic `slam-map` out.

use bus::{Bus, Daemon, topics};
use daemon::{Epochs, Failure, LatchedOutput, NewSample, OutputEnd, SiteConfig, chain, joined, state_files};
use messages::{ArchiveBuffer, Checked, InputHashes, SlamMap, SlamMapHead};
use ros::msg::geometry_msgs::Quaternion;
use ros::msg::nav_msgs::OccupancyGrid;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tracing::{info, warn};

/// A cell of which nothing is known.
const UNKNOWN: i8 = -1;
/// A pose that is turned out of the plane by more than this is none of a map.
const MAX_TILT: f64 = 1e-3;

/// A grid that is no map of a robot.
#[derive(Debug, thiserror::Error, PartialEq)]
pub(crate) enum GridFault {
    #[error("the grid has {cells} cells, and its width and height make {expected}")]
    Cells { cells: usize, expected: u64 },
    #[error("the grid has no cells")]
    Empty,
    #[error("no cell of the grid is known")]
    Unknown,
    #[error("the grid has {cells} cells: at most {} are taken", SlamMapHead::MAX_CELLS)]
    TooManyCells { cells: usize },
    #[error("the resolution of the grid is {resolution_m} m: {least_m} to {most_m} m is meant")]
    Resolution { resolution_m: f32, least_m: f64, most_m: f64 },
    #[error("the origin of the grid is at {x_m}, {y_m}: that is no place in metres")]
    Origin { x_m: f64, y_m: f64 },
    #[error("the orientation of the grid's origin is no rotation")]
    Orientation,
    #[error("the origin of the grid is turned out of the plane")]
    Tilted,
    #[error("the grid has a cell of {value}: -1 or 0 to 100 is meant")]
    Value { value: i8 },
}

/// The archive of a grid, without rows and columns at its borders of which nothing is known: some SLAM nodes publish a square
/// of fixed size around what the robot has seen.
///
/// # Errors
/// A grid that is no map of a robot.
pub(crate) fn slam_map_of(grid: &OccupancyGrid) -> Result<ArchiveBuffer, GridFault> {
    let (info, cells) = (&grid.info, &grid.data.0);
    let expected = u64::from(info.width) * u64::from(info.height);
    if cells.len() as u64 != expected {
        return Err(GridFault::Cells { cells: cells.len(), expected });
    }
    if cells.is_empty() {
        return Err(GridFault::Empty);
    }
    if expected > SlamMapHead::MAX_CELLS {
        return Err(GridFault::TooManyCells { cells: cells.len() });
    }
    // As the map server reads its own files: seven digits of a resolution are what a float has.
    let resolution_m = (f64::from(info.resolution) * 1e7).round() / 1e7;
    let [least_m, most_m] = SlamMapHead::RESOLUTION_M;
    if !(least_m..=most_m).contains(&resolution_m) {
        return Err(GridFault::Resolution { resolution_m: info.resolution, least_m, most_m });
    }
    let [x_m, y_m] = [info.origin.position.x, info.origin.position.y];
    if ![x_m, y_m].iter().all(|c| c.abs() < SlamMapHead::MAX_COORDINATE_M) {
        return Err(GridFault::Origin { x_m, y_m });
    }
    let yaw_rad = yaw_rad(&info.origin.orientation)?;
    if let Some(&value) = cells.iter().find(|value| !(-1..=100).contains(*value)) {
        return Err(GridFault::Value { value });
    }
    let width = info.width as usize;
    let [columns, rows] = known_extent(cells, width).ok_or(GridFault::Unknown)?;
    let [dx_m, dy_m] = [&columns, &rows].map(|range| range.start as f64 * resolution_m);
    let (sin, cos) = libm::sincos(yaw_rad);
    let origin = [x_m + cos * dx_m - sin * dy_m, y_m + sin * dx_m + cos * dy_m, yaw_rad];
    let head = SlamMapHead { resolution_m, origin, width: columns.len() as u32, height: rows.len() as u32 };
    let known: Vec<i8> =
        cells.chunks(width).take(rows.end).skip(rows.start).flat_map(|row| &row[columns.clone()]).copied().collect();
    Ok(SlamMap::write(&head, &known))
}

/// Columns and rows between the first and the last in which a cell is known.
fn known_extent(cells: &[i8], width: usize) -> Option<[Range<usize>; 2]> {
    let is_known = |cell: &i8| *cell != UNKNOWN;
    let rows = cells.iter().position(is_known)? / width..cells.iter().rposition(is_known)? / width + 1;
    let known_rows = || cells[rows.start * width..rows.end * width].chunks(width);
    let first = known_rows().filter_map(|row| row.iter().position(is_known)).min()?;
    let last = known_rows().filter_map(|row| row.iter().rposition(is_known)).max()?;
    Some([first..last + 1, rows])
}

/// The turn about the vertical axis. The length of a quaternion says nothing; one of zeros, as from a publisher that sets
/// none, is no turn.
fn yaw_rad(q: &Quaternion) -> Result<f64, GridFault> {
    let Quaternion { x, y, z, w } = *q;
    let norm = libm::sqrt(x * x + y * y + z * z + w * w);
    if norm == 0.0 {
        return Ok(0.0);
    }
    if !norm.is_finite() {
        return Err(GridFault::Orientation);
    }
    let is_flat = libm::hypot(x, y) / norm <= MAX_TILT;
    if is_flat { Ok(2.0 * libm::atan2(z, w)) } else { Err(GridFault::Tilted) }
}

/// Brings grids to the bus. They come on a thread of their own, which the service does not wait for.
pub(crate) struct SlamMapInput {
    config: SiteConfig,
    output: Mutex<Output>,
    warnings: Mutex<Warnings>,
}

/// What a person should know.
#[derive(Default)]
struct Warnings {
    /// Why the last message is not taken; `None` if it is.
    refusal: Option<String>,
    /// Why the last map is not on the bus; `None` if it is.
    no_room: Option<String>,
}

/// Tells and keeps a warning; one that stands already is not told again.
fn warn_once(standing: &mut Option<String>, warning: Option<String>) {
    if let Some(warning) = warning.as_ref().filter(|_| *standing != warning) {
        warn!(service = "ros-bridge", warning);
    }
    *standing = warning;
}

/// The robot's side of the bus.
struct Output {
    epochs: Epochs,
    /// The current generation, as the robot joins it.
    bus: Option<Bus>,
    maps: LatchedOutput<topics::SlamMap>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl SlamMapInput {
    /// Nothing has come yet.
    ///
    /// # Errors
    /// State that cannot be used.
    pub(crate) fn new(config: &SiteConfig) -> Result<Self, Failure> {
        let epochs = Epochs::at(&config.state, state_files::SLAM_MAP_EPOCHS)?;
        let output = Output { epochs, bus: None, maps: LatchedOutput::new(topics::SlamMap) };
        Ok(Self { config: config.clone(), output: Mutex::new(output), warnings: Mutex::default() })
    }

    /// The bus has another generation: the last map comes there, too.
    ///
    /// # Errors
    /// Another robot publishes maps.
    pub(crate) fn attach(&self) -> Result<(), Failure> {
        let mut output = lock(&self.output);
        let Output { epochs, bus, maps } = &mut *output;
        *bus = None;
        let (joined, _waiter) = Bus::join(&self.config.domain()?, Daemon::Robot)?;
        maps.attach(&joined, epochs)?;
        *bus = Some(joined);
        Ok(())
    }

    /// A message has come; `Err` has why it cannot be read. What is no map is refused, and the map before it stays.
    pub(crate) fn take(&self, message: Result<OccupancyGrid, String>) {
        let message = message.map_err(|why| Failure::from(format!("its message cannot be read: {why}")));
        let map = message.and_then(|grid| {
            let archive = slam_map_of(&grid)?;
            Ok((archive, grid))
        });
        let refusal = map.as_ref().err().map(|why| format!("a SLAM map is not taken: {}", chain(why.as_ref())));
        warn_once(&mut lock(&self.warnings).refusal, refusal);
        if let Ok((archive, grid)) = map {
            self.is_published(self.pass_on(archive, &grid));
        }
    }

    /// A map that had no room on the bus comes there as soon as there is.
    pub(crate) fn retry(&self) {
        let mut output = lock(&self.output);
        let Output { epochs, maps, .. } = &mut *output;
        let retried = maps.retry(epochs);
        drop(output);
        self.is_published(retried);
    }

    /// What came of publishing a map.
    fn is_published(&self, published: Result<(), Failure>) {
        let why = published.err().map(|why| format!("the SLAM map is not published: {}", chain(why.as_ref())));
        warn_once(&mut lock(&self.warnings).no_room, why);
    }

    /// That the last message was not taken, or that the last map is not on the bus, and why.
    pub(crate) fn warning(&self) -> Option<String> {
        let Warnings { refusal, no_room } = &*lock(&self.warnings);
        joined([no_room, refusal].into_iter().flatten().map(String::as_str))
    }

    fn pass_on(&self, archive: ArchiveBuffer, grid: &OccupancyGrid) -> Result<(), Failure> {
        let mut output = lock(&self.output);
        let Output { epochs, maps, .. } = &mut *output;
        // The same grid comes from a latched and from another subscription; what could not be published is tried again.
        if maps.is_last(&archive) {
            return maps.retry(epochs);
        }
        let archive = Arc::new(Checked::new(archive)?);
        let (width, height) = (grid.info.width, grid.info.height);
        info!(service = "ros-bridge", width, height, frame = grid.header.frame_id, "SLAM map taken");
        maps.publish_for_good(epochs, NewSample { archive, frame_epoch: 0, inputs: InputHashes::default() })
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
        let long = grid(|grid| grid.info.origin.orientation = Quaternion { x: 0.0, y: 0.0, z: 3.0, w: 3.0 });
        let turned_rad = SlamMap::open(slam_map_of(&long).unwrap().bytes()).unwrap().head.origin[2];
        assert!((turned_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12, "a quaternion that is no unit is scaled");
    }

    #[test]
    fn borders_of_which_nothing_is_known_are_cut_off_and_the_rest_stays_where_it_is() {
        let whole = grid(|_| {});
        let archive = slam_map_of(&whole).unwrap();
        let whole = SlamMap::open(archive.bytes()).unwrap();
        let (sin, cos) = libm::sincos(0.5);
        // Two columns before and one behind, one row below and two above.
        let bordered = grid(|grid| {
            (grid.info.width, grid.info.height) = (6, 5);
            grid.info.origin.position.x -= 0.05 * (cos * 2.0 - sin);
            grid.info.origin.position.y -= 0.05 * (sin * 2.0 + cos);
            grid.data.0 = vec![-1; 30];
            grid.data.0[8..11].copy_from_slice(&whole.occupancy[..3]);
            grid.data.0[14..17].copy_from_slice(&whole.occupancy[3..]);
        });
        let archive = slam_map_of(&bordered).unwrap();
        let map = SlamMap::open(archive.bytes()).unwrap();
        assert_eq!((map.head.width, map.head.height, map.occupancy), (3, 2, whole.occupancy));
        assert!(map.head.origin.iter().zip(whole.head.origin).all(|(a, b)| (a - b).abs() < 1e-9), "{:?}", map.head);
    }

    #[test]
    fn a_grid_that_is_no_map_is_refused_with_why() {
        let refused = |change: fn(&mut OccupancyGrid)| slam_map_of(&grid(change)).map(drop).unwrap_err();
        assert_eq!(refused(|grid| grid.info.width = 4), GridFault::Cells { cells: 6, expected: 8 });
        assert_eq!(
            refused(|grid| grid.info.width = u32::MAX).to_string(),
            "the grid has 6 cells, and its width and height make 8589934590"
        );
        let words = |change: fn(&mut OccupancyGrid)| refused(change).to_string();
        assert_eq!(refused(|grid| grid.data.0.fill(-1)), GridFault::Unknown);
        let no_cells = |grid: &mut OccupancyGrid| {
            grid.info.width = 0;
            grid.data.0.clear();
        };
        assert_eq!(refused(no_cells), GridFault::Empty);
        assert_eq!(refused(|grid| grid.data.0[1] = 101), GridFault::Value { value: 101 });
        assert_eq!(refused(|grid| grid.info.origin.orientation.x = 1.0), GridFault::Tilted);
        assert_eq!(refused(|grid| grid.info.origin.orientation.w = f64::NAN), GridFault::Orientation);
        assert_eq!(
            words(|grid| grid.info.resolution = f32::NAN),
            "the resolution of the grid is NaN m: 0.001 to 10 m is meant"
        );
        assert!(words(|grid| grid.info.resolution = -0.05).contains("is -0.05 m"));
        assert_eq!(
            words(|grid| grid.info.origin.position.x = f64::INFINITY),
            "the origin of the grid is at inf, -2: that is no place in metres"
        );
        assert!(words(|grid| grid.info.origin.position.y = f64::NAN).contains("at 1, NaN"));
    }
}
