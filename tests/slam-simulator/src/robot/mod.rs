//! The robot: where it drives, what its lidar sees, what its wheels count, where it believes to be, and the map that it makes.

pub(crate) mod drift;
pub(crate) mod drive;
pub(crate) mod lidar;
pub(crate) mod odometry;
pub(crate) mod people;
pub(crate) mod slam_map;
