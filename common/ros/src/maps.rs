//! Layers of a grid as occupancy grids and masks for Nav2.
//!
//! A message holds what Nav2's map_server publishes when it reads the file of the same layer (`planning.pgm`,
//! `localization.pgm`, `keepout.pgm` with the YAML beside them): -1, 0 or 100 for each cell, row-major from the lower left.
//! A mask of speeds has the steps of `speed.pgm`.

use crate::layers::{Layers, OCCUPIED};
use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::{Point, Pose};
use crate::msg::nav_msgs::{Int8Array, MapMetaData, OccupancyGrid};
use crate::msg::nav2_msgs::CostmapFilterInfo;
use crate::msg::std_msgs::Header;
use grid::GridSpec;

/// The map for global planning: 100 where an obstacle stands, 0 where there is floor and none, -1 elsewhere.
pub fn planning(layers: &Layers, frame_id: &str, stamp: Time) -> OccupancyGrid {
    occupancy_grid(&layers.spec, layers.planning.clone(), frame_id, stamp)
}

/// The map for localization: finished structure at the height of the lidar.
pub fn localization(layers: &Layers, frame_id: &str, stamp: Time) -> OccupancyGrid {
    occupancy_grid(&layers.spec, layers.localization.clone(), frame_id, stamp)
}

/// The keep-out mask: 100 where the robot must not be, -1 elsewhere, never 0.
pub fn keepout_mask(layers: &Layers, frame_id: &str, stamp: Time) -> OccupancyGrid {
    occupancy_grid(&layers.spec, layers.keepout.clone(), frame_id, stamp)
}

/// The mask of limits of speed: 0 without one, else so many steps of metres per second; `None` where the layers have none.
pub fn speed_mask(layers: &Layers, frame_id: &str, stamp: Time) -> Option<OccupancyGrid> {
    layers.speed.as_ref().map(|speed| occupancy_grid(&layers.spec, speed.clone(), frame_id, stamp))
}

/// What the mask of speeds on a topic means to Nav2's SpeedFilter: its data are steps of metres per second.
pub fn speed_info(mask_topic: &str, step_m_s: f64, frame_id: &str, stamp: Time) -> CostmapFilterInfo {
    #[expect(clippy::cast_possible_truncation, reason = "the message has 32 bits")]
    let multiplier = step_m_s as f32;
    CostmapFilterInfo {
        header: Header { stamp, frame_id: frame_id.to_owned() },
        r#type: CostmapFilterInfo::SPEED_ABSOLUTE,
        filter_mask_topic: mask_topic.to_owned(),
        base: 0.0,
        multiplier,
    }
}

/// A mask that keeps the robot out of every cell, in the place of another one.
pub fn keepout_everywhere(header: Header, info: MapMetaData) -> OccupancyGrid {
    let n_cells = info.width as usize * info.height as usize;
    OccupancyGrid { header, info, data: Int8Array(vec![OCCUPIED; n_cells]) }
}

/// What the keep-out mask on a topic means to Nav2's KeepoutFilter: its data are costs in percent.
pub fn keepout_info(mask_topic: &str, frame_id: &str, stamp: Time) -> CostmapFilterInfo {
    CostmapFilterInfo {
        header: Header { stamp, frame_id: frame_id.to_owned() },
        r#type: CostmapFilterInfo::KEEPOUT,
        filter_mask_topic: mask_topic.to_owned(),
        base: 0.0,
        multiplier: 1.0,
    }
}

fn occupancy_grid(spec: &GridSpec, cells: Vec<i8>, frame_id: &str, stamp: Time) -> OccupancyGrid {
    let [x, y] = spec.origin_m();
    // The file says it in full; the message has 32 bits.
    #[expect(clippy::cast_possible_truncation, reason = "the message has 32 bits")]
    let resolution = spec.resolution_m() as f32;
    OccupancyGrid {
        header: Header { stamp, frame_id: frame_id.to_owned() },
        info: MapMetaData {
            map_load_time: stamp,
            resolution,
            width: spec.width,
            height: spec.height,
            origin: Pose { position: Point { x, y, z: 0.0 }, ..Pose::default() },
        },
        data: Int8Array(cells),
    }
}
