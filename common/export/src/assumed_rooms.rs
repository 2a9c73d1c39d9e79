//! Rooms whose floor is assumed.

use messages::{NONE, Site, space_flags};

/// Rooms on map storeys whose floor is assumed because they have no slab, from large to small.
pub fn assumed_rooms(site: &Site<'_>) -> Vec<u32> {
    let is_assumed = |space: &u32| {
        let record = &site.spaces[*space as usize];
        record.map_storey != NONE && record.has(space_flags::ASSUMED_FLOOR)
    };
    let mut rooms: Vec<u32> = (0..site.spaces.len() as u32).filter(is_assumed).collect();
    let area_m2 = |space: u32| site.spaces[space as usize].area_m2;
    rooms.sort_by(|a, b| area_m2(*b).total_cmp(&area_m2(*a)).then(a.cmp(b)));
    rooms
}
