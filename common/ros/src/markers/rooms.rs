//! Outlines and names of spaces.

use super::drawing::{BLOCKED, CHANGING, Drawing, OPEN, outline};
use crate::msg::builtin_interfaces::Time;
use crate::msg::std_msgs::ColorRGBA;
use crate::msg::visualization_msgs::MarkerArray;
use messages::{ScheduleState, ScheduleStateHead, Site, space_flags};

/// The spaces of a map storey: outlines in `rooms`, by ring of the site, and names in `room_names`, by space; green open, orange
/// open and closing soon, red blocked. Gross areas and spaces that are made of others are left out.
pub fn rooms(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    map_storey: u32,
    frame_id: &str,
    stamp: Time,
) -> MarkerArray {
    let mut drawing = Drawing::new(frame_id, stamp);
    let is_drawn = |s: &messages::SpaceRecord| s.map_storey == map_storey && !s.has(space_flags::METADATA_ONLY);
    for (index, space) in site.spaces.iter().enumerate().filter(|(_, space)| is_drawn(space)) {
        let (color, word) = state(schedule_state, index);
        let polygons = site.floor_polygon(space).0;
        let rings = polygons.iter().flat_map(|polygon| std::iter::once(&polygon.exterior).chain(&polygon.holes));
        for (ring, id) in rings.zip(space.first_ring as usize..) {
            drawing.line_strip(("rooms", id), color, outline(ring));
        }
        let name = export::space_name(site, index as u32);
        let lines: Vec<String> = name.into_iter().chain(word.map(str::to_owned)).collect();
        drawing.text(("room_names", index), color, space.centroid_m, lines.join("\n"));
    }
    drawing.finish()
}

/// Colour of a space, and the word for what it is if it is not open.
fn state(schedule_state: &ScheduleState<'_>, space: usize) -> (ColorRGBA, Option<&'static str>) {
    if schedule_state.is_blocked(space) {
        (BLOCKED, Some("blocked"))
    } else if schedule_state.spaces[space].closes_at_s != ScheduleStateHead::NO_TIME {
        (CHANGING, Some("closing"))
    } else {
        (OPEN, None)
    }
}
