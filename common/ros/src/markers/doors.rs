//! Passages of doors.

use super::drawing::{BLOCKED, CHANGING, Drawing, OPEN, rectangle};
use crate::msg::builtin_interfaces::Time;
use crate::msg::visualization_msgs::MarkerArray;
use frames::TENTHS_PER_M;
use messages::{DoorUse, Grids, Site};

/// The doors that stand on a map storey: passages in `doors` and, where one is closed, the first reason in `door_reasons`, by
/// door of the site; green passable, orange an opening without its door, red closed to the robot.
pub fn doors(site: &Site<'_>, index: &Grids<'_>, map_storey: u32, frame_id: &str, stamp: Time) -> MarkerArray {
    let mut drawing = Drawing::new(frame_id, stamp);
    let records = export::each_door(site, index.doors);
    for record in records.iter().filter(|d| d.map_storey == map_storey) {
        let (id, Some(door)) = (record.door as usize, site.doors.get(record.door as usize)) else { continue };
        let color = match record.passage.get().for_robot() {
            DoorUse::Passes => OPEN,
            DoorUse::NotHung => CHANGING,
            DoorUse::Closed => BLOCKED,
        };
        let passage = door.passage.to_box();
        drawing.line_strip(("doors", id), color, rectangle(&passage));
        if let Some(reason) = record.closed_by().next() {
            let text = export::reason_text(site, &index.head.robot, record, reason);
            drawing.text(("door_reasons", id), color, passage.centre.map(|c| c / f64::from(TENTHS_PER_M)), text);
        }
    }
    drawing.finish()
}
