//! Per-cell flags (obstacle, door, floor, blocked, structure, work, outline) from which all layers are computed. They are set in
//! `incremental/storey_grid.rs`, floor in `incremental/storey_floor.rs`.
//!
//! The planning layer of a cell, the first row that fits:
//!
//! | flag | set where | planning |
//! |---|---|---|
//! | [`OCCUPIED`] | an element that is built, worked on or being removed overlaps the cell within the slab (`RobotProfile::slab_m`: from the step that the robot takes up to its clearance, above the floor of the storey, or above the ramp, terrain or tread that the cell shows, which is in nobody's way itself); a door with its host wall that this robot cannot open or pass, or that is being hung or removed (of another level only where floor is), and fixed parts of one that it passes | 100 |
//! | [`BLOCKED`] | the cell is of a space that the schedule closes | 100 |
//! | [`FLOOR`] | floor that is there: built or assumed (`floor.rs`), of ground (`ground_floor.rs`, outdoors `incremental/outdoor_floor.rs`), or of a passage without a door through what stands, with floor on both sides; not where the ground breaks off | 0 |
//! | [`DOOR`] | the passage of a door that this robot opens and passes, and the rest of its body where floor is | 0 |
//! | none of these | | -1 |
//!
//! A storey before its first slab is unknown as a whole ([`fill_without_floor`]).

use grid::CellRect;
use messages::GridLayers;

/// An obstacle, or a door that this robot cannot pass.
pub(crate) const OCCUPIED: u8 = 1;
/// A door and nothing else.
pub(crate) const DOOR: u8 = 2;
/// Floor without open passages through walls.
pub(crate) const BASE_FLOOR: u8 = 4;
/// Floor.
pub(crate) const FLOOR: u8 = 8;
/// In a blocked space.
pub(crate) const BLOCKED: u8 = 16;
/// Finished structure at the lidar's height.
pub(crate) const STRUCTURE: u8 = 32;
/// Under an element between this floor and the next that is worked on.
pub(crate) const WORK: u8 = 64;
/// Within the outline of the complete storey.
pub(crate) const OUTLINE: u8 = 128;

/// What margins of edges and the mask are made of, but for work.
pub(crate) const OF_EDGES: u8 = OCCUPIED | DOOR | FLOOR | BLOCKED | OUTLINE;
/// What margins of work are made of, and the mask in them.
pub(crate) const OF_WORK: u8 = OCCUPIED | DOOR | FLOOR | WORK;
/// What the localization layer is made of.
pub(crate) const OF_LOCALIZATION: u8 = OCCUPIED | DOOR | FLOOR | STRUCTURE;

/// Occupied in `nav_msgs`.
pub(crate) const NAV_OCCUPIED: i8 = 100;
/// Free in `nav_msgs`.
pub(crate) const NAV_FREE: i8 = 0;
/// Unknown in `nav_msgs`.
pub(crate) const NAV_UNKNOWN: i8 = -1;

/// Floor or an open door without an obstacle, also in blocked spaces.
pub(crate) const fn is_free(flags: u8) -> bool {
    flags & OCCUPIED == 0 && flags & (FLOOR | DOOR) != 0
}

/// No floor and no door. A door without floor beyond stays passable, so it is no drop-off itself.
pub(crate) const fn is_void(flags: u8) -> bool {
    flags & (FLOOR | DOOR) == 0
}

/// True for a drop-off.
pub(crate) const fn is_edge(flags: u8) -> bool {
    is_void(flags) && flags & OCCUPIED == 0
}

/// Value of the planning layer for each combination of flags.
pub(crate) const PLANNING: [i8; 256] = {
    let mut planning = [NAV_UNKNOWN; 256];
    let mut flags = 0;
    while flags < 256 {
        if flags as u8 & (OCCUPIED | BLOCKED) != 0 {
            planning[flags] = NAV_OCCUPIED;
        } else if is_free(flags as u8) {
            planning[flags] = NAV_FREE;
        }
        flags += 1;
    }
    planning
};

/// Layers of a storey before its first slab, in rectangles: everything unknown and keep-out, also where elements already stand.
pub(crate) fn fill_without_floor(layers: &mut GridLayers<'_>, rects: &[CellRect], width: usize) {
    for row in rects.iter().flat_map(|rect| rect.rows(width)) {
        layers.planning[row.clone()].fill(NAV_UNKNOWN);
        layers.localization[row.clone()].fill(NAV_UNKNOWN);
        layers.keepout[row].fill(NAV_OCCUPIED);
    }
}
