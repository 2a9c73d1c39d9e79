//! Spaces of a storey as viewers show them, and their outlines and names as markers.

use super::drawing::{BLOCKED, CHANGING, Drawing, OPEN, outline};
use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::Point;
use crate::msg::std_msgs::ColorRGBA;
use crate::msg::visualization_msgs::MarkerArray;
use messages::{ScheduleState, ScheduleStateHead, Site, space_flags};

/// A space as viewers show it.
#[derive(Debug, Clone, PartialEq)]
pub struct Room<'a> {
    /// Its place in the site.
    pub index: usize,
    /// GlobalId.
    pub global_id: &'a str,
    /// Name and long name; `None` if it has neither.
    pub name: Option<String>,
    /// Whether the robot may use it.
    pub state: RoomState,
    /// The middle of its floor, in `map`, metres.
    pub centroid_m: [f64; 2],
    /// The borders of its floor, in `map`, as closed lines, with the place of each ring in the site.
    pub outlines: Vec<(usize, Vec<Point>)>,
}

/// Whether a robot may use a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoomState {
    /// Yes.
    Open,
    /// Yes, but a date is known from which it may not.
    Closing,
    /// No.
    Blocked,
}

impl RoomState {
    fn of(schedule_state: &ScheduleState<'_>, space: usize) -> Self {
        if schedule_state.is_blocked(space) {
            Self::Blocked
        } else if schedule_state.spaces[space].closes_at_s != ScheduleStateHead::NO_TIME {
            Self::Closing
        } else {
            Self::Open
        }
    }

    /// Its name for people and programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Closing => "closing",
            Self::Blocked => "blocked",
        }
    }

    /// Its colour: green open, orange closing, red blocked.
    pub fn color(self) -> ColorRGBA {
        match self {
            Self::Open => OPEN,
            Self::Closing => CHANGING,
            Self::Blocked => BLOCKED,
        }
    }
}

impl Room<'_> {
    /// What stands in it: its name, and its state unless it is open.
    pub fn label(&self) -> String {
        let state = (self.state != RoomState::Open).then(|| self.state.name().to_owned());
        let lines: Vec<String> = self.name.clone().into_iter().chain(state).collect();
        lines.join("\n")
    }
}

/// The spaces of a map storey. Gross areas and spaces that are made of others are left out.
pub fn each_room<'a>(
    site: &'a Site<'_>,
    schedule_state: &'a ScheduleState<'_>,
    map_storey: u32,
) -> impl Iterator<Item = Room<'a>> {
    let is_drawn = move |s: &messages::SpaceRecord| s.map_storey == map_storey && !s.has(space_flags::METADATA_ONLY);
    site.spaces.iter().enumerate().filter(move |(_, space)| is_drawn(space)).map(|(index, space)| {
        let polygons = site.floor_polygon(space);
        Room {
            index,
            global_id: site.text(space.global_id),
            name: export::space_name(site, index as u32),
            state: RoomState::of(schedule_state, index),
            centroid_m: space.centroid_m,
            outlines: (space.first_ring as usize..).zip(polygons.rings().map(|ring| outline(ring))).collect(),
        }
    })
}

/// The spaces of a map storey: outlines in `rooms`, by ring of the site, and names in `room_names`, by space; green open, orange
/// open and closing soon, red blocked.
pub fn rooms(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    map_storey: u32,
    frame_id: &str,
    stamp: Time,
) -> MarkerArray {
    let mut drawing = Drawing::new(frame_id, stamp);
    for room in each_room(site, schedule_state, map_storey) {
        let (color, label) = (room.state.color(), room.label());
        for (ring, line) in room.outlines {
            drawing.line_strip(("rooms", ring), color, line);
        }
        drawing.text(("room_names", room.index), color, room.centroid_m, label);
    }
    drawing.finish()
}
