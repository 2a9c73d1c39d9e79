//! Per-cell flags (obstacle, door, floor, blocked, structure, work, outline) from which all layers are computed.

use messages::GridLayers;

/// An obstacle, or a door that this robot cannot pass.
pub(crate) const OCCUPIED: u8 = 1;
/// A door and nothing else.
pub(crate) const DOOR: u8 = 2;
/// Floor, passages through walls not counted.
pub(crate) const GROUND: u8 = 4;
/// Floor.
pub(crate) const FLOOR: u8 = 8;
/// In a blocked space.
pub(crate) const BLOCKED: u8 = 16;
/// Finished structure at the lidar's height.
pub(crate) const STRUCTURE: u8 = 32;
/// Below work.
pub(crate) const WORK: u8 = 64;
/// Inside the storey when it is complete.
pub(crate) const OUTLINE: u8 = 128;

/// Occupied in `nav_msgs`.
pub(crate) const NAV_OCCUPIED: i8 = 100;
/// Free in `nav_msgs`.
pub(crate) const NAV_FREE: i8 = 0;
/// Unknown in `nav_msgs`.
pub(crate) const NAV_UNKNOWN: i8 = -1;

/// Floor or an open door, without an obstacle; blocked spaces included.
pub(crate) const fn is_free(facts: u8) -> bool {
    facts & OCCUPIED == 0 && facts & (FLOOR | DOOR) != 0
}

/// No floor. A door without floor beyond stays passable, so it is no drop-off itself.
pub(crate) const fn is_void(facts: u8) -> bool {
    facts & (FLOOR | DOOR) == 0
}

/// Where a robot would fall.
pub(crate) const fn is_edge(facts: u8) -> bool {
    is_void(facts) && facts & OCCUPIED == 0
}

/// The planning layer by facts.
pub(crate) const PLANNING: [i8; 256] = {
    let mut planning = [NAV_UNKNOWN; 256];
    let mut facts = 0;
    while facts < 256 {
        if facts as u8 & (OCCUPIED | BLOCKED) != 0 {
            planning[facts] = NAV_OCCUPIED;
        } else if is_free(facts as u8) {
            planning[facts] = NAV_FREE;
        }
        facts += 1;
    }
    planning
};

/// What a storey shows before its first slab: nobody can stand anywhere, whatever stands there already.
pub(crate) fn fill_without_floor(layers: &mut GridLayers<'_>) {
    layers.planning.fill(NAV_UNKNOWN);
    layers.localization.fill(NAV_UNKNOWN);
    layers.keepout.fill(NAV_OCCUPIED);
}
