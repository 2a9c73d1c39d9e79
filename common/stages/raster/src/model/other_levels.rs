//! Elements whose floor may lie at another level of a storey.

use frames::TENTHS_PER_M;
use messages::{ElementRecord, Site, element_flags};

/// Maximum height difference between the floor and a region of the storey at another level, in tenths of a millimetre.
pub(crate) const MAX_LEVEL_OFFSET: i32 = TENTHS_PER_M;

/// Elements with floor that may lie at another level of a storey.
pub(crate) fn candidates(site: &Site<'_>, floor_z: i32) -> impl Iterator<Item = u32> {
    let is_near = move |e: &ElementRecord| {
        e.min_tenths[2] <= floor_z + MAX_LEVEL_OFFSET && floor_z - MAX_LEVEL_OFFSET <= e.max_tenths[2]
    };
    let elements = (0..).zip(site.elements);
    elements.filter(move |(_, e)| e.has(element_flags::FLOOR) && is_near(e)).map(|(element, _)| element)
}
