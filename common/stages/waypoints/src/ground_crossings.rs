//! Places that the map of a storey and that of the ground outdoors both show: portals between them.

use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::portal::{Portal, PortalKind, Staging};
use crate::start_pose::cells_around;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use grid::Cell;
use messages::{DoorPassageRecord, NONE};
use std::collections::BTreeMap;

/// Vertices are whole tenths of a millimetre.
const HEIGHT_TOLERANCE: i32 = 5;

/// Minimum distance of two portals of one stretch, in metres: a way is longer by as much at most.
const MIN_DISTANCE_M: f64 = 5.0;

/// How far from a doorway a place before it is looked for, in metres.
const BEFORE_DOOR_M: f64 = 1.5;

/// The portals between the ground outdoors and each level: where a place at which the robot can stand is on both maps at one height,
/// and the ground goes on from it beyond the map of the level. Of such places that hang together the clearest, and others 5 m away from
/// all that were taken; before a doorway, where there is such a place, and not in it.
pub(crate) fn ground_crossings(input: &MissionPlanInput<'_>, free_spaces: &[&FreeSpace]) -> Vec<Portal> {
    let (site, robot) = (input.site, &input.index.head.robot);
    let step = frames::tenths(robot.step_height_m).unwrap_or(i32::MAX / 4).saturating_add(HEIGHT_TOLERANCE);
    let Some((ground, _)) = site.outdoors() else { return Vec::new() };
    let doorway = |door: &DoorPassageRecord| {
        let way = door.way.to_box();
        let radius = robot.radius_m * f64::from(TENTHS_PER_M);
        OrientedBox { half: way.half.map(|half| half + radius), ..way }
    };
    let doorways: Vec<OrientedBox> = input.passages_at(ground).iter().map(doorway).collect();
    let portals = |(level, _)| SharedGround { free_spaces, level, ground, step }.portals(&doorways);
    site.levels().flat_map(portals).collect()
}

/// The map of a level and that of the ground outdoors.
struct SharedGround<'a> {
    free_spaces: &'a [&'a FreeSpace],
    level: usize,
    ground: usize,
    /// Heights that differ by this at most are one place, in tenths of a millimetre.
    step: i32,
}

impl SharedGround<'_> {
    /// The cell of the level at a cell of the ground, if the robot can stand there on both and they are one place.
    fn shared(&self, cell: usize) -> Option<usize> {
        let [on_level, on_ground] = [self.level, self.ground].map(|storey| self.free_spaces[storey]);
        let at = on_ground.spec.cell_of(cell);
        let place = |at: u32, k: usize| {
            let first = i64::from(on_ground.spec.first_cell[k]) - i64::from(on_level.spec.first_cell[k]);
            u32::try_from(i64::from(at) + first).ok()
        };
        let (column, row) = (place(at.column, 0)?, place(at.row, 1)?);
        let is_inside = column < on_level.spec.width && row < on_level.spec.height;
        let other = is_inside.then(|| on_level.spec.index(Cell { column, row }))?;
        let off = on_ground.z_tenths(cell).abs_diff(on_level.z_tenths(other));
        (on_ground.part(cell) != 0 && on_level.part(other) != 0 && off <= self.step.unsigned_abs()).then_some(other)
    }

    fn portals(&self, doorways: &[OrientedBox]) -> Vec<Portal> {
        let on_ground = self.free_spaces[self.ground];
        let goes_on = |cell: usize| {
            on_ground.spec.beside(cell).any(|beside| on_ground.part(beside) != 0 && self.shared(beside).is_none())
        };
        // By the parts of level and ground that they join.
        let mut contacts: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
        for cell in on_ground.cells().filter(|&cell| self.shared(cell).is_some() && goes_on(cell)) {
            contacts.entry(self.parts(cell)).or_default().push(cell);
        }
        let mut places: Vec<usize> = contacts.into_values().flat_map(|contacts| spread(on_ground, contacts)).collect();
        places.iter_mut().for_each(|cell| *cell = self.before_door(*cell, doorways));
        places.sort_unstable();
        places.dedup();
        places.into_iter().filter_map(|cell| self.portal(cell)).collect()
    }

    /// Parts of level and ground at a cell of the ground; none if they are not one place there.
    fn parts(&self, cell: usize) -> [u32; 2] {
        let parts = |other: usize| [self.free_spaces[self.level].part(other), self.free_spaces[self.ground].part(cell)];
        self.shared(cell).map_or([0; 2], parts)
    }

    /// The place nearest to one in a doorway that joins the same parts before it; the place itself if there is none, and if it is in
    /// no doorway.
    fn before_door(&self, cell: usize, doorways: &[OrientedBox]) -> usize {
        let on_ground = self.free_spaces[self.ground];
        let is_in_doorway = |p: Point2<Map>| {
            let at = p.coordinates_m().map(|c| c * f64::from(TENTHS_PER_M));
            doorways.iter().any(|doorway| doorway.contains(at))
        };
        let middle = on_ground.middle(cell);
        if !is_in_doorway(middle) {
            return cell;
        }
        let parts = self.parts(cell);
        let is_before =
            |&(_, other): &(f64, usize)| !is_in_doorway(on_ground.middle(other)) && self.parts(other) == parts;
        let before = cells_around(on_ground, middle, BEFORE_DOOR_M).filter(is_before);
        before.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map_or(cell, |(_, other)| other)
    }

    fn portal(&self, cell: usize) -> Option<Portal> {
        let other = self.shared(cell)?;
        let [level_part, ground_part] = self.parts(cell);
        let ends = [
            Staging { storey: self.level, cell: other, part: level_part },
            Staging { storey: self.ground, cell, part: ground_part },
        ];
        Some(Portal { element: NONE as usize, kind: PortalKind::Ground, ends, length_m: 0.0, usable: true })
    }
}

/// Of the contacts of each stretch the clearest, then others that are far enough from all taken; in a stretch each is at most two steps
/// from another.
fn spread(on_ground: &FreeSpace, contacts: Vec<usize>) -> Vec<usize> {
    let stretch_of = stretches(on_ground, &contacts);
    let mut by_clearance = contacts;
    by_clearance.sort_by(|&a, &b| {
        let clearance_m = |cell: usize| on_ground.clearance_of(cell);
        clearance_m(b).total_cmp(&clearance_m(a)).then(a.cmp(&b))
    });
    let mut taken: Vec<usize> = Vec::new();
    for cell in by_clearance {
        let (middle, stretch) = (on_ground.middle(cell), stretch_of[&cell]);
        let is_near = |other: &usize| {
            on_ground.middle(*other).distance_m(&middle) < MIN_DISTANCE_M && stretch_of[other] == stretch
        };
        if !taken.iter().any(is_near) {
            taken.push(cell);
        }
    }
    taken.sort_unstable();
    taken
}

/// The number of the stretch of each contact.
fn stretches(on_ground: &FreeSpace, contacts: &[usize]) -> BTreeMap<usize, usize> {
    let mut stretch_of: BTreeMap<usize, usize> = contacts.iter().map(|&cell| (cell, usize::MAX)).collect();
    let mut waiting = Vec::new();
    for (number, &first) in contacts.iter().enumerate() {
        waiting.push(first);
        while let Some(cell) = waiting.pop() {
            match stretch_of.get_mut(&cell) {
                Some(stretch) if *stretch == usize::MAX => *stretch = number,
                _ => continue,
            }
            let sides = on_ground.spec.beside(cell);
            waiting.extend(sides.flat_map(|side| on_ground.spec.beside(side).chain([side])));
        }
    }
    stretch_of
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::tests::drawn_at;
    use messages::Grid;

    /// Places at which one goes from the map of a level to that of the ground, both drawn as text, the level so much higher.
    fn found(level: &str, ground: &str, rise_tenths: i32) -> Vec<Point2<Map>> {
        let buffers = [drawn_at(level, rise_tenths), drawn_at(ground, 0)];
        let free_spaces = buffers.each_ref().map(|b| FreeSpace::of(&Grid::open(b.bytes()).unwrap(), 0.1));
        let doorway = OrientedBox { centre: [7_500.0, 3_000.0], axis: [0.0, 1.0], half: [2_000.0, 1_500.0] };
        let both = SharedGround { free_spaces: &free_spaces.each_ref(), level: 0, ground: 1, step: 200 };
        let portals = both.portals(&[doorway]);
        for portal in &portals {
            let at = portal.ends.map(|end| free_spaces[end.storey].middle(end.cell));
            assert_eq!((portal.kind, portal.usable, at[0]), (PortalKind::Ground, true, at[1]));
            assert!(portal.ends.iter().all(|end| free_spaces[end.storey].part(end.cell) == end.part && end.part != 0));
        }
        portals.iter().map(|portal| free_spaces[1].middle(portal.ends[1].cell)).collect()
    }

    /// A room with a doorway to the east, whose floor ends there, and the yard with the room in it.
    const LEVEL: &str = "########      \n#......#      \n#......#      \n#........     \n#........     \n#......#      \n########      ";
    const GROUND: &str = "########......\n#......#......\n#......#......\n#.............\n#.............\n#......#......\n########......";

    #[test]
    fn the_map_changes_where_that_of_the_level_ends() {
        let places = found(LEVEL, GROUND, 0);
        assert_eq!(places.len(), 1, "{places:?}");
        assert!((places[0].x_m() - 0.55).abs() < 0.06, "before the doorway: {places:?}");
    }

    #[test]
    fn floor_at_another_height_is_another_place() {
        assert_eq!(found(LEVEL, GROUND, 200).len(), 1, "a step that the robot takes");
        assert_eq!(found(LEVEL, GROUND, 210), []);
    }

    #[test]
    fn ground_that_ends_where_the_level_does_leads_nowhere() {
        assert_eq!(found(LEVEL, LEVEL, 0), []);
        let [level, closed] =
            [LEVEL.replace("#........", "#.......#"), GROUND.replace("#.............", "#......#......")];
        assert_eq!(found(&level, &closed, 0), [], "the door is closed outdoors");
    }

    #[test]
    fn along_a_wide_edge_there_is_a_place_every_five_metres() {
        let row = |n_free: usize| format!("{}{}", ".".repeat(n_free), " ".repeat(20 - n_free));
        let (terrace, yard) = (vec![row(10); 200].join("\n"), vec![row(20); 200].join("\n"));
        let mut places = found(&terrace, &yard, 0);
        places.sort_by(|a, b| a.y_m().total_cmp(&b.y_m()));
        assert!((3..=5).contains(&places.len()), "of 20 m: {places:?}");
        assert!(places.windows(2).all(|pair| pair[1].distance_m(&pair[0]) >= 5.0), "{places:?}");
        assert!(places.windows(2).all(|pair| pair[1].distance_m(&pair[0]) <= 10.0), "{places:?}");
    }
}
