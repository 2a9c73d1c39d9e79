//! Reachability of the parts of each storey, through portals too.

use crate::free_space::FreeSpace;
use crate::options::Start;
use crate::portal::{Portal, Staging};
use crate::start_pose::start_cell;
use frames::{Map, Point2};
use messages::StoreyEntry;

/// Reachability of each part of each storey, and the points of entry.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reachability {
    /// By storey, by part; part 0 is never reached.
    pub(crate) parts: Vec<Vec<bool>>,
    /// By storey: start of the robot and ends of portals used.
    pub(crate) entries: Vec<Vec<Point2<Map>>>,
    /// Storeys in the order in which they are first reached.
    pub(crate) order: Vec<usize>,
    /// By storey, how the robot comes there; [`StoreyEntry::Placed`] for every storey that has a start of its own.
    pub(crate) entered: Vec<StoreyEntry>,
    /// True if the robot cannot stand at the given start.
    pub(crate) start_is_blocked: bool,
}

impl Reachability {
    /// Starts in the part at the start, or in the first part of every storey not reached yet, and follows all usable
    /// portals. `first_parts` has the first part of each storey, 0 for none.
    pub(crate) fn of(
        free_spaces: &[&FreeSpace],
        portals: &[Portal],
        first_parts: &[u32],
        start: Option<Start>,
    ) -> Self {
        let mut reached = Self {
            parts: free_spaces.iter().map(|g| vec![false; g.n_parts() as usize + 1]).collect(),
            entries: vec![Vec::new(); free_spaces.len()],
            order: Vec::new(),
            entered: vec![StoreyEntry::None; free_spaces.len()],
            start_is_blocked: false,
        };
        match start {
            Some(start) => match start_cell(free_spaces, start) {
                Some((storey, cell)) => {
                    reached.entered[storey] = StoreyEntry::Start;
                    reached.enter(free_spaces, storey, free_spaces[storey].part(cell), Some(cell));
                    reached.follow(free_spaces, portals);
                }
                None => reached.start_is_blocked = true,
            },
            None => {
                for (storey, &first) in first_parts.iter().enumerate() {
                    // A storey reached through a portal has no start of its own.
                    if first != 0 && reached.entries[storey].is_empty() {
                        reached.entered[storey] = StoreyEntry::Placed;
                        reached.enter(free_spaces, storey, first, None);
                        reached.follow(free_spaces, portals);
                    }
                }
            }
        }
        reached
    }

    fn is_reached(&self, staging: Staging) -> bool {
        self.parts[staging.storey][staging.part as usize]
    }

    fn enter(&mut self, free_spaces: &[&FreeSpace], storey: usize, part: u32, cell: Option<usize>) {
        self.parts[storey][part as usize] = true;
        self.entries[storey].extend(cell.map(|cell| free_spaces[storey].middle(cell)));
        if !self.order.contains(&storey) {
            self.order.push(storey);
        }
    }

    /// Follows portals until no new part is reached.
    fn follow(&mut self, free_spaces: &[&FreeSpace], portals: &[Portal]) {
        loop {
            let tour_distances =
                portals.iter().filter(|p| p.usable).flat_map(|p| [(p.ends[0], p.ends[1]), (p.ends[1], p.ends[0])]);
            let next = tour_distances.into_iter().find(|(from, to)| self.is_reached(*from) && !self.is_reached(*to));
            let Some((_, to)) = next else { return };
            if self.entered[to.storey] == StoreyEntry::None {
                self.entered[to.storey] = StoreyEntry::Portal;
            }
            self.enter(free_spaces, to.storey, to.part, Some(to.cell));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::tests::drawn;
    use crate::portal::PortalKind;
    use messages::Grid;

    /// Two rooms, the left one larger: parts are numbered from the lowest row, so the left one is 1.
    const TWO_ROOMS: &str = "###########\n#......#..#\n#......#..#\n#......#..#\n###########";
    const LEFT: u32 = 1;
    const RIGHT: u32 = 2;

    fn free_spaces(n: usize) -> Vec<FreeSpace> {
        let buffer = drawn(TWO_ROOMS);
        (0..n).map(|_| FreeSpace::of(&Grid::open(buffer.bytes()).unwrap(), 0.1)).collect()
    }

    /// A place in a room.
    fn in_room(free_space: &FreeSpace, storey: usize, part: u32) -> Staging {
        let cell = (0..free_space.spec.n_cells()).find(|&c| free_space.part(c) == part).unwrap();
        Staging { storey, cell, part }
    }

    /// From a room of a storey to another, usable or not.
    type Way = ((usize, u32), (usize, u32), bool);

    fn reached(n_storeys: usize, tour_distances: &[Way], start: Option<Start>) -> Reachability {
        let free_spaces = free_spaces(n_storeys);
        let end = |(storey, part): (usize, u32)| in_room(&free_spaces[storey], storey, part);
        let portals: Vec<Portal> = tour_distances
            .iter()
            .map(|&(a, b, usable)| Portal {
                element: 0,
                kind: PortalKind::Stair,
                ends: [end(a), end(b)],
                length_m: 1.0,
                usable,
            })
            .collect();
        Reachability::of(&free_spaces.iter().collect::<Vec<_>>(), &portals, &vec![LEFT; n_storeys], start)
    }

    /// Storeys with the rooms that are reached.
    fn rooms(reached: &Reachability) -> Vec<(usize, u32)> {
        let of = |(storey, parts): (usize, &Vec<bool>)| {
            (1..parts.len() as u32).filter(|&p| parts[p as usize]).map(|p| (storey, p)).collect::<Vec<_>>()
        };
        assert!(reached.parts.iter().all(|p| !p[0]), "part 0 is never reached");
        reached.parts.iter().enumerate().flat_map(of).collect()
    }

    fn at(storey: u32, x_m: f64) -> Option<Start> {
        Some(Start { storey, x_m, y_m: 0.25 })
    }

    #[test]
    fn without_a_start_the_first_part_of_every_storey_is_reached() {
        let all = reached(2, &[], None);
        assert_eq!((rooms(&all), &all.order), (vec![(0, LEFT), (1, LEFT)], &vec![0, 1]));
        assert!(all.entries.iter().all(Vec::is_empty), "it may be anywhere there");
    }

    #[test]
    fn who_came_through_a_portal_is_not_put_there_again() {
        let all = reached(2, &[((0, LEFT), (1, RIGHT), true)], None);
        assert_eq!((rooms(&all), all.entries[1].len()), (vec![(0, LEFT), (1, RIGHT)], 1));
        let blocked = reached(2, &[((0, LEFT), (1, RIGHT), false)], None);
        assert_eq!(rooms(&blocked), [(0, LEFT), (1, LEFT)]);
    }

    #[test]
    fn portals_are_followed_in_both_directions_and_on_from_where_they_lead() {
        let tour_distances =
            [((0, RIGHT), (1, LEFT), true), ((1, RIGHT), (2, RIGHT), true), ((1, LEFT), (2, LEFT), true)];
        let from_above = reached(3, &tour_distances, at(2, 0.35));
        assert_eq!(rooms(&from_above), [(0, RIGHT), (1, LEFT), (2, LEFT)]);
        assert_eq!(from_above.order, [2, 1, 0], "in the order in which they are reached");
        let from_right = reached(3, &tour_distances, at(2, 0.85));
        assert_eq!((rooms(&from_right), &from_right.order), (vec![(1, RIGHT), (2, RIGHT)], &vec![2, 1]));
    }

    #[test]
    fn a_way_up_and_down_again_leads_to_the_other_room() {
        let tour_distances = [((0, LEFT), (1, LEFT), true), ((1, LEFT), (0, RIGHT), true)];
        let all = reached(2, &tour_distances, at(0, 0.35));
        assert_eq!((rooms(&all), &all.order), (vec![(0, LEFT), (0, RIGHT), (1, LEFT)], &vec![0, 1]));
        assert_eq!(all.entries[0].len(), 2, "where it starts, and where it comes back");
    }

    #[test]
    fn a_start_counts_from_where_the_robot_can_stand_next_to_it() {
        // The cells of the wall end at 0.1 m; the first on which it stands has its middle at 0.15 m.
        let near = reached(1, &[], at(0, -0.0));
        assert_eq!((near.start_is_blocked, rooms(&near)), (false, vec![(0, LEFT)]));
        assert!((near.entries[0][0].x_m() - 0.15).abs() < 1e-9, "{:?}", near.entries);
        assert!(reached(1, &[], at(0, -0.05)).start_is_blocked, "outside of the grid");
        assert!(reached(1, &[], at(1, 0.35)).start_is_blocked, "there is no such storey");
        assert!(reached(1, &[], at(0, f64::NAN)).start_is_blocked);
        // Between the rooms: the nearer one.
        assert_eq!(rooms(&reached(1, &[], at(0, 0.74))), [(0, LEFT)]);
        assert_eq!(rooms(&reached(1, &[], at(0, 0.76))), [(0, RIGHT)]);
    }
}
