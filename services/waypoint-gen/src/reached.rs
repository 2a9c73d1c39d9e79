//! What a robot can get to, storey by storey.

use crate::ground::Ground;
use crate::options::Start;
use crate::portals::{Portal, Staging};
use frames::{Map, Point2};

/// Whether the robot can get to each part of each storey, and where it comes onto it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reached {
    /// By storey, by part; part 0 is never reached.
    pub(crate) parts: Vec<Vec<bool>>,
    /// By storey: where the robot starts, or comes out of a portal.
    pub(crate) entries: Vec<Vec<Point2<Map>>>,
    /// Storeys in the order in which they are first come to.
    pub(crate) order: Vec<usize>,
    /// True if a start was given at which the robot cannot stand.
    pub(crate) start_is_blocked: bool,
}

/// A start is moved to the nearest place where the robot can stand, at most this far: no pose is known better.
const START_TOLERANCE_M: f64 = 0.3;

impl Reached {
    /// From the part at the start, or from the largest part of every storey that no portal has led to yet, through every
    /// portal that the robot can take.
    pub(crate) fn of(grounds: &[&Ground], portals: &[Portal], start: Option<Start>) -> Self {
        let mut reached = Self {
            parts: grounds.iter().map(|g| vec![false; g.n_parts() as usize + 1]).collect(),
            entries: vec![Vec::new(); grounds.len()],
            order: Vec::new(),
            start_is_blocked: false,
        };
        match start {
            Some(start) => match start_cell(grounds, start) {
                Some((storey, cell)) => {
                    reached.enter(grounds, storey, grounds[storey].part(cell), Some(cell));
                    reached.follow(grounds, portals);
                }
                None => reached.start_is_blocked = true,
            },
            None => {
                for (storey, ground) in grounds.iter().enumerate() {
                    // Who came here through a portal is not put here again.
                    if ground.largest() != 0 && reached.entries[storey].is_empty() {
                        reached.enter(grounds, storey, ground.largest(), None);
                        reached.follow(grounds, portals);
                    }
                }
            }
        }
        reached
    }

    fn is_reached(&self, staging: Staging) -> bool {
        self.parts[staging.storey][staging.part as usize]
    }

    fn enter(&mut self, grounds: &[&Ground], storey: usize, part: u32, cell: Option<usize>) {
        self.parts[storey][part as usize] = true;
        self.entries[storey].extend(cell.map(|cell| grounds[storey].middle(cell)));
        if !self.order.contains(&storey) {
            self.order.push(storey);
        }
    }

    /// Goes on through portals until nothing new is come to.
    fn follow(&mut self, grounds: &[&Ground], portals: &[Portal]) {
        loop {
            let ways =
                portals.iter().filter(|p| p.usable).flat_map(|p| [(p.ends[0], p.ends[1]), (p.ends[1], p.ends[0])]);
            let next = ways.into_iter().find(|(from, to)| self.is_reached(*from) && !self.is_reached(*to));
            let Some((_, to)) = next else { return };
            self.enter(grounds, to.storey, to.part, Some(to.cell));
        }
    }
}

fn start_cell(grounds: &[&Ground], start: Start) -> Option<(usize, usize)> {
    let ground = grounds.get(start.storey as usize)?;
    let p = Point2::<Map>::new(start.x_m, start.y_m);
    let spec = &ground.spec;
    let at = spec.cell_at(p)?;
    let reach = (START_TOLERANCE_M / spec.resolution_m()).ceil() as u32;
    let range = |at: u32, n: u32| at.saturating_sub(reach)..(at + reach + 1).min(n);
    let cells = range(at.row, spec.height)
        .flat_map(|row| range(at.column, spec.width).map(move |column| spec.index(grid::Cell { column, row })));
    let far = |cell: usize| {
        let middle = ground.middle(cell);
        libm::hypot(middle.x_m - p.x_m, middle.y_m - p.y_m)
    };
    let standing = cells.filter(|&c| ground.part(c) != 0 && far(c) <= START_TOLERANCE_M + spec.resolution_m());
    let nearest = standing.min_by(|&a, &b| far(a).total_cmp(&far(b)).then(a.cmp(&b)))?;
    Some((start.storey as usize, nearest))
}
