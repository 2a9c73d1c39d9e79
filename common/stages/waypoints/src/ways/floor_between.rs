//! Floor on which nothing stands and the robot cannot stand, between parts of the free space of a storey.

use crate::barriers::{FloorBetween, FloorEnd};
use crate::free_space::FreeSpace;
use frames::{Map, Point2};
use grid::Class;
use messages::Grid;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// A stretch of such floor that would have to be crossed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Crossing {
    /// A space that is closed by the schedule.
    Space(usize),
    /// Keep-out, or only narrower than the robot, from here on.
    Floor(Point2<Map>, bool),
}

/// Cost of a step over floor on which the robot cannot stand: a way keeps off it.
const CLOSED_STEP: u32 = 20;

/// The space of a cell, if it is closed by the schedule.
fn closed_space(grid: &Grid<'_>, is_closed_space: &[bool], cell: usize) -> Option<usize> {
    usize::from(grid.space[cell]).checked_sub(1).filter(|space| is_closed_space[*space])
}

/// True if there is floor in a cell and nothing stands on it; a space that is closed by the schedule is occupied everywhere.
fn is_open(grid: &Grid<'_>, is_closed_space: &[bool], cell: usize) -> bool {
    let is_closed = || closed_space(grid, is_closed_space, cell).is_some();
    grid.floor[cell] != 0 && (grid.planning[cell] == 0 || grid.class[cell] == Class::None.id() && is_closed())
}

/// Pairs of parts, and of parts and closed spaces, between which there is such floor: each with the largest part of what hangs
/// together so.
pub(super) fn floors_between(
    storey: usize,
    grid: &Grid<'_>,
    free_space: &FreeSpace,
    is_closed_space: &[bool],
) -> Vec<FloorBetween> {
    let spec = grid.spec();
    let mut is_seen = vec![false; spec.n_cells()];
    let mut found = Vec::new();
    let mut waiting = Vec::new();
    for start in free_space.cells() {
        if std::mem::replace(&mut is_seen[start], true) {
            continue;
        }
        let (mut parts, mut spaces) = (BTreeSet::new(), BTreeSet::new());
        waiting.push(start);
        while let Some(cell) = waiting.pop() {
            parts.extend(Some(free_space.part(cell)).filter(|part| *part != 0));
            spaces.extend(closed_space(grid, is_closed_space, cell));
            for next in spec.beside(cell) {
                if is_open(grid, is_closed_space, next) && !std::mem::replace(&mut is_seen[next], true) {
                    waiting.push(next);
                }
            }
        }
        let largest = parts.iter().copied().max_by_key(|part| (free_space.size(*part), Reverse(*part)));
        let Some(largest) = largest else { continue };
        let others = parts.into_iter().filter(|part| *part != largest).map(FloorEnd::Part);
        let others = others.chain(spaces.into_iter().map(FloorEnd::Space));
        found.extend(others.map(|other| FloorBetween { storey, ends: [FloorEnd::Part(largest), other] }));
    }
    found
}

/// What would have to be crossed from a place to another, in this order: of such floor as little as can be.
pub(super) fn crossings(
    grid: &Grid<'_>,
    free_space: &FreeSpace,
    is_closed_space: &[bool],
    [from, to]: [FloorEnd; 2],
) -> Vec<Crossing> {
    let spec = grid.spec();
    let mut cost = vec![u32::MAX; spec.n_cells()];
    let mut came_from = vec![u32::MAX; spec.n_cells()];
    let mut heap = BinaryHeap::new();
    let is_at = |end: FloorEnd, cell: usize| match end {
        FloorEnd::Part(part) => free_space.part(cell) == part,
        FloorEnd::Space(space) => closed_space(grid, is_closed_space, cell) == Some(space),
    };
    for cell in (0..spec.n_cells()).filter(|cell| is_at(from, *cell) && is_open(grid, is_closed_space, *cell)) {
        cost[cell] = 0;
        heap.push(Reverse((0, cell)));
    }
    let mut end = None;
    while let Some(Reverse((so_far, cell))) = heap.pop() {
        if is_at(to, cell) {
            end = Some(cell);
            break;
        }
        if so_far > cost[cell] {
            continue;
        }
        for next in spec.beside(cell).filter(|next| is_open(grid, is_closed_space, *next)) {
            let total = so_far.saturating_add(if free_space.part(next) == 0 { CLOSED_STEP } else { 1 });
            if total < cost[next] {
                (cost[next], came_from[next]) = (total, cell as u32);
                heap.push(Reverse((total, next)));
            }
        }
    }
    let before = |cell: &usize| Some(came_from[*cell]).filter(|cell| *cell != u32::MAX).map(|cell| cell as usize);
    let mut path: Vec<usize> = std::iter::successors(end, before).collect();
    path.reverse();
    let mut found: Vec<Crossing> = Vec::new();
    let mut was_free = true;
    for cell in path {
        let is_free = free_space.part(cell) != 0;
        if !is_free {
            let floor = || Crossing::Floor(free_space.middle(cell), grid.is_keepout(cell));
            let crossing = closed_space(grid, is_closed_space, cell).map_or_else(floor, Crossing::Space);
            let is_known = !was_free
                && match (found.last(), crossing) {
                    (Some(Crossing::Space(last)), Crossing::Space(space)) => *last == space,
                    (Some(Crossing::Floor(_, last)), Crossing::Floor(_, is_keepout)) => *last || !is_keepout,
                    // The margin around a closed space is a part of it.
                    (Some(Crossing::Space(_)), Crossing::Floor(..)) => true,
                    _ => false,
                };
            if !is_known {
                // The margin before a closed space, too.
                let is_margin =
                    !was_free && matches!((found.last(), crossing), (Some(Crossing::Floor(..)), Crossing::Space(_)));
                if is_margin {
                    found.pop();
                }
                found.push(crossing);
            }
        }
        was_free = is_free;
    }
    found
}
