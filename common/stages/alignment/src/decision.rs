//! Places to drive to that decide between poses of an ambiguous alignment, as data and as text with the names of rooms.

use crate::rooms::Room;

/// What would decide between the poses of an ambiguous alignment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decision {
    /// Places to drive to, the best first.
    pub places: Vec<NamedPlace>,
    /// Pairs of poses, by index, that nothing in the model tells apart that the robot can reach.
    pub undecided: Vec<[usize; 2]>,
}

/// A place at which the robot finds out which pose is right.
#[derive(Debug, Clone, PartialEq)]
pub struct DecidingPlace {
    /// In the frame of the SLAM map, in metres: there the robot can drive whichever pose is right.
    pub in_slam_m: [f64; 2],
    /// In the model's map by each pose, in metres.
    pub in_map_m: Vec<[f64; 2]>,
    /// Way from the nearest place that the SLAM map shows, along its rows and columns, in metres.
    pub way_m: f64,
    /// Length of the walls in view that stand by one pose and not by another, averaged over all pairs of poses, in metres.
    pub differing_m: f64,
    /// Pairs of poses, by index, that are told apart here.
    pub decided: Vec<[usize; 2]>,
}

/// A place to drive to.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPlace {
    /// The place.
    pub place: DecidingPlace,
    /// The room in which it lies by each pose; `None` in no room, or where the model's map has none.
    pub rooms: Vec<Option<Room>>,
}

impl std::fmt::Display for Decision {
    /// What to do, for people.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(place) = self.places.first() else {
            return write!(f, "nothing in the model that the robot can reach tells them apart: give {HINTS}");
        };
        write!(f, "{place} to tell them apart")?;
        if self.undecided.is_empty() {
            return Ok(());
        }
        let pairs: Vec<String> = self.undecided.iter().map(|[a, b]| format!("{} and {}", a + 1, b + 1)).collect();
        write!(f, ", though nothing tells poses {} apart: for them give {HINTS}", pairs.join(", "))
    }
}

const HINTS: &str = "--start-room, --hint or --storey";

impl std::fmt::Display for NamedPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x_m, y_m] = self.place.in_slam_m;
        let at = format!("x {x_m:.1} m, y {y_m:.1} m of the SLAM map");
        let known: Vec<&Room> = self.rooms.iter().flatten().collect();
        let is_one_storey = known.windows(2).all(|pair| pair[0].map_storey == pair[1].map_storey);
        let mut names: Vec<String> = Vec::new();
        for room in known {
            let storey = if is_one_storey { String::new() } else { format!(" of storey {}", room.map_storey) };
            let name = format!("{}{storey}", room.label());
            if !names.contains(&name) {
                names.push(name);
            }
        }
        match names.is_empty() {
            true => write!(f, "drive to {at}"),
            false => write!(f, "drive through {} ({at})", names.join(" or ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(rooms: &[Option<(&str, u32)>]) -> NamedPlace {
        let room = |(name, map_storey): (&str, u32)| Room { name: name.to_owned(), map_storey, ..Room::default() };
        let in_map_m = vec![[0.0; 2]; rooms.len()];
        let place =
            DecidingPlace { in_slam_m: [3.11, -4.0], in_map_m, way_m: 1.0, differing_m: 2.0, decided: vec![[0, 1]] };
        NamedPlace { place, rooms: rooms.iter().map(|named| named.map(room)).collect() }
    }

    #[test]
    fn what_to_do_is_told_with_the_rooms_where_there_are_some() {
        let at = "x 3.1 m, y -4.0 m of the SLAM map";
        let nothing =
            "nothing in the model that the robot can reach tells them apart: give --start-room, --hint or --storey";
        for (places, undecided, expected) in [
            (vec![], vec![[0, 1]], nothing.to_owned()),
            (vec![place(&[None, None])], vec![], format!("drive to {at} to tell them apart")),
            (
                vec![place(&[Some(("U.04", 1)), Some(("U.09", 1)), Some(("U.04", 1)), None]), place(&[None])],
                vec![],
                format!("drive through U.04 or U.09 ({at}) to tell them apart"),
            ),
            (
                vec![place(&[Some(("1", 0)), Some(("1", 2)), None])],
                vec![[0, 2]],
                format!(
                    "drive through 1 of storey 0 or 1 of storey 2 ({at}) to tell them apart, though nothing tells poses \
                     1 and 3 apart: for them give --start-room, --hint or --storey"
                ),
            ),
        ] {
            assert_eq!(Decision { places, undecided }.to_string(), expected);
        }
    }
}
