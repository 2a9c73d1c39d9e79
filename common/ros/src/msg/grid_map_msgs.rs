//! Maps of several layers of numbers, as the package `grid_map_msgs` of ROS 2 has them.
//!
//! The types are those of its versions for ROS 2, 2.0 (Humble) and 2.2 (Jazzy). In ROS 1 the header is in the info and not in the map.

use crate::interface::ros_message;
use crate::msg::geometry_msgs::Pose;
use crate::msg::std_msgs::{Float32MultiArray, Header};
use serde::{Deserialize, Serialize};

/// Size and place of a map.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct GridMapInfo {
    /// Metres per cell.
    pub resolution: f64,
    /// Metres along x.
    pub length_x: f64,
    /// Metres along y.
    pub length_y: f64,
    /// The middle of the map. Its users take x and y of it and no turn.
    pub pose: Pose,
}
ros_message!(
    GridMapInfo,
    grid_map_msgs / msg / GridMapInfo,
    "0a36d6b5bc9af8463d1d5a5008ef9fcac0c1373ba090f80c3594e47cc565b745",
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
);

/// Layers of numbers over the same cells, NaN where there is none.
///
/// Each layer is a matrix in column-major order: its row counts cells from the side of the largest x towards smaller ones, its
/// column those from the side of the largest y. Cell (0, 0) is therefore at the corner of the largest x and y, and all values
/// are those of a row-major grid from the lower left cell, in reverse.
///
/// # Source
/// ANYbotics' `grid_map` for ROS 2: `getVectorToFirstCell` and `getBufferOrderToMapFrameTransformation` in
/// `grid_map_core/src/GridMapMath.cpp`, `matrixEigenCopyToMultiArrayMessage` in
/// `grid_map_ros/include/grid_map_ros/GridMapMsgHelpers.hpp`, `fromOccupancyGrid` in `grid_map_ros/src/GridMapRosConverter.cpp`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GridMap {
    /// When and in which frame.
    pub header: Header,
    /// Size and place.
    pub info: GridMapInfo,
    /// Names of the layers.
    pub layers: Vec<String>,
    /// Names of those that must have a number in a cell for the cell to be valid.
    pub basic_layers: Vec<String>,
    /// The layers, in the order of their names. The dimensions of each are [`Self::DIMENSIONS`].
    pub data: Vec<Float32MultiArray>,
    /// Row at which the matrices begin; 0 in a map that does not scroll.
    pub outer_start_index: u16,
    /// Column at which they begin.
    pub inner_start_index: u16,
}
ros_message!(
    GridMap,
    grid_map_msgs / msg / GridMap,
    "343b0e72887541beda6b035cc053f2d6fffaad9d6dcb2773c15a808dfca31fde",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    grid_map_msgs / msg / GridMapInfo,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
    std_msgs / msg / Float32MultiArray,
    std_msgs / msg / MultiArrayLayout,
    std_msgs / msg / MultiArrayDimension,
);

impl GridMap {
    /// Labels of the dimensions of a layer in column-major order: cells along y, then cells along x.
    pub const DIMENSIONS: [&'static str; 2] = ["column_index", "row_index"];
}
