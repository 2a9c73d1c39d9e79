//! Floor of a storey in parts between which the robot does not get, and what it would get to if some of them were joined.

use answers::Situation;
use frames::{Map, Point2, metres};
use grid::{GridSpec, Mask, label_components, squared_distances};
use messages::{BoxRecord, DoorPassage, DoorPassageRecord, Grid};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Metres from a doorway within which floor belongs to its side.
const BESIDE_DOOR_M: f64 = 1.2;

/// The parts of the floor of a storey. A part is what is connected for the middle of the robot, with the free cells around it.
pub(crate) struct Regions {
    pub(crate) spec: GridSpec,
    /// The part of each cell from 1; 0 for none.
    labels: Vec<u32>,
    /// Free floor of each part; the first is of none.
    area_m2: Vec<f64>,
    is_reached: Vec<bool>,
    /// The part in which most of a space lies, by the index of the space.
    part_of_space: BTreeMap<u32, u32>,
}

/// Parts of a storey that would be one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Join {
    /// Place of the grid among all.
    pub(crate) grid: usize,
    pub(crate) parts: Vec<u32>,
}

impl Regions {
    pub(crate) fn of(situation: &Situation<'_>, grid: &Grid<'_>) -> Self {
        let radius_m = situation.index.head.robot.radius_m;
        let spec = grid.spec();
        let width = spec.width as usize;
        let free = |cell: usize| grid.planning[cell] == 0;
        let closed: Vec<bool> = (0..spec.n_cells()).map(|cell| !free(cell)).collect();
        let needed = (radius_m - 1e-4) / spec.resolution_m();
        let distances = squared_distances(&closed, width);
        let mut standing = Mask::new(width, spec.height as usize);
        for (cell, stands) in standing.cells.iter_mut().enumerate() {
            *stands = free(cell) && !grid.is_keepout(cell) && f64::from(distances[cell]) > needed * needed;
        }
        let (mut labels, n) = label_components(&standing);
        grow(&mut labels, &spec, needed.ceil() as u32 + 2, free);
        let mut area_m2 = vec![0.0; n as usize + 1];
        let mut in_space: BTreeMap<u32, BTreeMap<u32, u32>> = BTreeMap::new();
        let cell_m2 = spec.resolution_m() * spec.resolution_m();
        for (cell, &label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
            area_m2[label as usize] += cell_m2;
            if let Some(space) = grid.space[cell].checked_sub(1) {
                *in_space.entry(u32::from(space)).or_default().entry(label).or_insert(0) += 1;
            }
        }
        let most = |parts: BTreeMap<u32, u32>| parts.into_iter().max_by_key(|(_, n)| *n).map_or(0, |(part, _)| part);
        let part_of_space = in_space.into_iter().map(|(space, parts)| (space, most(parts))).collect();
        let is_reached = vec![false; area_m2.len()];
        let mut regions = Self { spec, labels, area_m2, is_reached, part_of_space };
        let own = |part: &&messages::FloorPartRecord| {
            // To a part with a stair or an outer door of its own a robot can be brought: another dwelling is no fault.
            part.map_storey == grid.head.map_storey && (part.is_reached == 1 || part.has_way_in == 1)
        };
        for part in situation.mission_plan.floor_parts.iter().filter(own) {
            let label = regions.part_at(part.at_m) as usize;
            regions.is_reached[label] |= label > 0;
        }
        // Outer doors from which no floor leads on: another building of the site.
        let is_outer = |passage: &&DoorPassageRecord| {
            passage.map_storey == grid.head.map_storey
                && passage.passage == DoorPassage::Passable
                && passage.sides_with_floor == 1
        };
        for passage in situation.index.doors.iter().filter(is_outer) {
            for part in regions.beside(&passage.way) {
                regions.is_reached[part as usize] = true;
            }
        }
        regions
    }

    /// The part at a place in `map`; 0 for none.
    pub(crate) fn part_at(&self, [x_m, y_m]: [f64; 2]) -> u32 {
        self.spec.cell_at(Point2::<Map>::new(x_m, y_m)).map_or(0, |cell| self.labels[self.spec.index(cell)])
    }

    /// True if the robot gets to the part of a cell.
    pub(crate) fn is_reached(&self, cell: usize) -> bool {
        self.is_reached[self.labels[cell] as usize]
    }

    /// The part of a cell; 0 for none.
    pub(crate) fn part(&self, cell: usize) -> u32 {
        self.labels[cell]
    }

    /// True if the part in which most of a space lies is one that the robot gets to.
    pub(crate) fn has_reached(&self, space: u32) -> bool {
        self.part_of_space.get(&space).is_some_and(|part| self.is_reached[*part as usize])
    }

    /// True if other spaces lie in the part of a space.
    pub(crate) fn is_shared(&self, space: u32) -> bool {
        let Some(own) = self.part_of_space.get(&space) else { return false };
        self.part_of_space.iter().any(|(other, part)| *other != space && part == own)
    }

    /// The parts on the two sides of a way through a wall.
    pub(crate) fn beside(&self, way: &BoxRecord) -> Vec<u32> {
        let across = [-way.axis[1], way.axis[0]];
        let centre = way.centre.map(|c| c / f64::from(frames::TENTHS_PER_M));
        let depth_m = way.half[1] / f64::from(frames::TENTHS_PER_M);
        let half_width_m = way.half[0] / f64::from(frames::TENTHS_PER_M);
        let side = |sign: f64| {
            let mut steps = (1..).map(|k| depth_m + f64::from(k) * self.spec.resolution_m());
            let steps = steps.by_ref().take_while(|off| *off <= depth_m + BESIDE_DOOR_M);
            let at = |off: f64, along: f64| {
                [0, 1].map(|k| centre[k] + sign * off * across[k] + along * half_width_m * way.axis[k])
            };
            let mut places = steps.flat_map(|off| [0.0, -0.5, 0.5].map(|along| at(off, along)));
            places.find_map(|place| Some(self.part_at(place)).filter(|part| *part > 0))
        };
        [1.0, -1.0].into_iter().filter_map(side).collect()
    }

    /// The parts that the robot gets to.
    fn reached(&self) -> BTreeSet<u32> {
        (1..self.is_reached.len() as u32).filter(|part| self.is_reached[*part as usize]).collect()
    }
}

/// Spreads labels over free cells, so far.
fn grow(labels: &mut [u32], spec: &GridSpec, reach: u32, free: impl Fn(usize) -> bool) {
    let mut queue: VecDeque<(usize, u32)> = (0..labels.len()).filter(|c| labels[*c] > 0).map(|c| (c, 0)).collect();
    while let Some((cell, far)) = queue.pop_front() {
        for next in spec.beside(cell).filter(|_| far < reach) {
            if labels[next] == 0 && free(next) {
                labels[next] = labels[cell];
                queue.push_back((next, far + 1));
            }
        }
    }
}

/// What the robot would get to.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Gain {
    /// Storey and part.
    parts: BTreeSet<(usize, u32)>,
}

impl Gain {
    pub(crate) fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Free floor.
    pub(crate) fn area_m2(&self, storeys: &[Regions]) -> f64 {
        self.parts.iter().map(|(storey, part)| storeys[*storey].area_m2[*part as usize]).sum()
    }

    /// Those of spaces that lie in it.
    pub(crate) fn rooms(&self, storeys: &[Regions], spaces: &BTreeSet<u32>) -> BTreeSet<u32> {
        let lies = |space: &&u32| {
            let part = |k: usize| storeys[k].part_of_space.get(space).map(|part| (k, *part));
            (0..storeys.len()).filter_map(part).any(|part| self.parts.contains(&part))
        };
        spaces.iter().filter(lies).copied().collect()
    }

    /// Both.
    pub(crate) fn joined(&self, other: &Self) -> Self {
        Self { parts: self.parts.union(&other.parts).copied().collect() }
    }

    /// What is not in another gain.
    pub(crate) fn without(&self, other: &Self) -> Self {
        Self { parts: self.parts.difference(&other.parts).copied().collect() }
    }
}

/// What the robot would get to if parts were joined, and does not get to now.
pub(crate) fn gain<'a>(storeys: &[Regions], joins: impl Iterator<Item = &'a Join> + Clone) -> Gain {
    let mut gain = Gain::default();
    for (k, regions) in storeys.iter().enumerate() {
        let before = regions.reached();
        let mut reached = before.clone();
        loop {
            let n = reached.len();
            for join in joins.clone().filter(|join| join.grid == k) {
                if join.parts.iter().any(|part| reached.contains(part)) {
                    reached.extend(&join.parts);
                }
            }
            if reached.len() == n {
                break;
            }
        }
        gain.parts.extend(reached.difference(&before).map(|part| (k, *part)));
    }
    gain
}

/// Metres of a length in tenths of a millimetre, as floats of boxes are.
pub(crate) fn box_metres(tenths: f64) -> f64 {
    tenths * metres(1)
}
