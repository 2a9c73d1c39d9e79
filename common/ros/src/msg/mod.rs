//! Message types by interface package, with their fields in the order of the definitions.
//!
//! Lengths are metres, angles radians, frames right-handed with Z up (REP 103). What a field holds is what ROS says of it.

pub mod builtin_interfaces;
pub mod std_msgs;

pub mod geometry_msgs;
pub mod grid_map_msgs;
pub mod nav2_msgs;
pub mod nav_msgs;
pub mod tf2_msgs;

pub mod foxglove_msgs;
pub mod sensor_msgs;
pub mod visualization_msgs;

pub mod diagnostic_msgs;
pub mod rosgraph_msgs;
pub mod std_srvs;
