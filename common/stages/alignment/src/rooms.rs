//! Rooms of a site, by which places are named.

use diagnostics::Called;
use frames::metres;
use messages::{NONE, Site, SpaceRecord, space_flags};

/// A room of a map storey.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Room {
    /// GlobalId.
    pub global_id: String,
    /// Name, often a number; may be empty.
    pub name: String,
    /// LongName; may be empty.
    pub long_name: String,
    /// Index of its map storey.
    pub map_storey: u32,
    /// Area in square metres.
    pub area_m2: f64,
    /// Rings of its floor polygon, in metres in the model's map: what lies in an odd number of them lies in the room.
    pub rings_m: Vec<Vec<[f64; 2]>>,
}

impl Room {
    /// The rooms of a site; gross areas and spaces made of spaces are none.
    pub fn all_of(site: &Site<'_>) -> Vec<Self> {
        let is_room = |space: &&SpaceRecord| !space.has(space_flags::METADATA_ONLY) && space.map_storey != NONE;
        let room = |space: &SpaceRecord| Self {
            global_id: site.text(space.global_id).to_owned(),
            name: site.text(space.name).to_owned(),
            long_name: site.text(space.long_name).to_owned(),
            map_storey: space.map_storey,
            area_m2: space.area_m2,
            rings_m: site.floor_polygon(space).rings().map(|r| r.iter().map(|p| p.map(metres)).collect()).collect(),
        };
        site.spaces.iter().filter(is_room).map(room).collect()
    }

    /// What people call it: its number, else its name, else its GlobalId.
    pub fn label(&self) -> &str {
        [&self.name, &self.long_name].into_iter().find(|text| !text.is_empty()).unwrap_or(&self.global_id)
    }

    /// Distance of a point of the model's map from the room, in metres; 0 inside.
    pub fn distance_m(&self, point: [f64; 2]) -> f64 {
        let edges = || self.rings_m.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        let [x, y] = point;
        let is_crossed = |(a, b): &(&[f64; 2], &[f64; 2])| {
            (a[1] <= y) != (b[1] <= y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        };
        if edges().filter(is_crossed).count() % 2 == 1 {
            return 0.0;
        }
        edges().map(|(a, b)| distance_to_edge_m(point, *a, *b)).fold(f64::INFINITY, f64::min)
    }
}

fn distance_to_edge_m([x, y]: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let squared = (d[0] * d[0] + d[1] * d[1]).max(f64::MIN_POSITIVE);
    let share = (((x - a[0]) * d[0] + (y - a[1]) * d[1]) / squared).clamp(0.0, 1.0);
    libm::hypot(a[0] + share * d[0] - x, a[1] + share * d[1] - y)
}

/// The room of a storey in which a point lies; of several the smallest.
pub(crate) fn room_at(rooms: &[Room], map_storey: u32, point: [f64; 2]) -> Option<&Room> {
    let holds = |room: &&Room| room.map_storey == map_storey && room.distance_m(point) == 0.0;
    rooms.iter().filter(holds).min_by(|a, b| a.area_m2.total_cmp(&b.area_m2))
}

impl Called for &Room {
    fn global_id(&self) -> &str {
        &self.global_id
    }

    fn names(&self) -> Vec<&str> {
        vec![&self.name, &self.long_name]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn room(name: &str, long_name: &str, [x0, y0, x1, y1]: [f64; 4]) -> Room {
        Room {
            global_id: format!("id-{name}"),
            name: name.to_owned(),
            long_name: long_name.to_owned(),
            area_m2: (x1 - x0) * (y1 - y0),
            rings_m: vec![vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]],
            ..Room::default()
        }
    }

    proptest! {
        #[test]
        fn the_distance_from_a_rectangle_is_that_of_its_bounds(x in -5.0..9.0f64, y in -5.0..9.0f64, is_closed: bool) {
            let mut room = room("1", "", [0.0, 0.0, 4.0, 3.0]);
            if is_closed {
                room.rings_m[0].push([0.0, 0.0]);
            }
            let expected = (x.clamp(0.0, 4.0) - x).hypot(y.clamp(0.0, 3.0) - y);
            prop_assert!((room.distance_m([x, y]) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn a_hole_is_no_part_of_a_room_and_a_smaller_room_goes_before_a_larger_one() {
        let mut court = room("court", "", [0.0, 0.0, 9.0, 9.0]);
        court.rings_m.push(vec![[3.0, 3.0], [3.0, 6.0], [6.0, 6.0], [6.0, 3.0]]);
        assert_eq!([court.distance_m([4.0, 4.5]), court.distance_m([1.0, 1.0])], [1.0, 0.0]);
        let rooms = [court, room("booth", "", [1.0, 1.0, 2.0, 2.0])];
        let at = |point, storey| room_at(&rooms, storey, point).map(Room::label);
        assert_eq!([at([1.5, 1.5], 0), at([2.5, 1.5], 0), at([4.0, 4.5], 0)], [Some("booth"), Some("court"), None]);
        assert_eq!(at([1.5, 1.5], 1), None);
    }
}
