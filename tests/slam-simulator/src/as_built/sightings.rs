//! Counts of the beams that met each element, and of those that passed through its place.

use super::changed_building::{ChangedBuilding, NO_ELEMENT};
use super::changes::{Change, GroupChange};
use super::model::ModelStorey;
use crate::plane::{Rectangle, difference, dot, moved};
use crate::robot::lidar::Beam;
use crate::world::CELL_M;
use std::collections::BTreeSet;

/// Beams are followed in steps of so much of a cell.
const STEP: f64 = 0.7;

/// What the lidar saw in a drive.
pub(super) struct Sightings<'a> {
    building: &'a ChangedBuilding,
    /// Rectangles of the elements as built.
    rectangles: Vec<Rectangle>,
    /// By element: cells along its length in which a beam ended.
    met: Vec<BTreeSet<i32>>,
    is_crossed: Vec<bool>,
}

impl<'a> Sightings<'a> {
    pub(super) fn new(storey: &ModelStorey, building: &'a ChangedBuilding, changes: &[GroupChange]) -> Self {
        let mut rectangles: Vec<Rectangle> = storey.elements.iter().map(|e| e.rectangle).collect();
        for change in changes {
            if let Change::Displaced { by_m } = change.change {
                change.members.iter().for_each(|k| rectangles[*k] = rectangles[*k].shifted(by_m));
            }
        }
        let met = vec![BTreeSet::new(); storey.elements.len()];
        Self { building, rectangles, met, is_crossed: vec![false; building.owners.len()] }
    }

    /// Beams without an answer show nothing: most maps leave what they passed unknown.
    pub(super) fn add(&mut self, beam: &Beam) {
        if !beam.range_m.is_finite() {
            return;
        }
        let grid = &self.building.reference.grid;
        let steps = (beam.range_m / (STEP * CELL_M)) as usize;
        for k in 0..steps {
            if let Some(cell) = grid.index_at(moved(beam.from, beam.direction, k as f64 * STEP * CELL_M)) {
                self.is_crossed[cell] = true;
            }
        }
        let Some(cell) = beam.ended_at.and_then(|p| grid.index_at(p)) else { return };
        let owner = self.building.owners[cell];
        if owner != NO_ELEMENT {
            let rectangle = &self.rectangles[owner as usize];
            let along_m = dot(difference(grid.middle(cell), rectangle.centre), rectangle.along);
            self.met[owner as usize].insert((along_m / CELL_M).floor() as i32);
        }
    }

    /// Length of the element on which beams ended.
    pub(super) fn met_m(&self, element: usize) -> f64 {
        self.met[element].len() as f64 * CELL_M
    }

    /// Share of what the element vacated that beams crossed.
    pub(super) fn crossed_share(&self, element: usize) -> f64 {
        let vacated = &self.building.vacated[element];
        vacated.iter().filter(|c| self.is_crossed[**c]).count() as f64 / vacated.len().max(1) as f64
    }
}
