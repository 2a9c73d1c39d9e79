//! A storey as it was built: cells with the element that each of them belongs to.

use super::changes::{Change, GroupChange};
use super::model::ModelStorey;
use super::section::cells;
use crate::plane::{Rectangle, distance};
use crate::reference::{Reference, ReferenceError};
use crate::world::{Material, World};
use occupancy::{Cell, OccupancyMap};

/// No element.
pub(crate) const NO_ELEMENT: u32 = u32::MAX;

/// A storey with its changes.
pub(crate) struct ChangedBuilding {
    /// Walls are all elements as built.
    pub(crate) reference: Reference,
    /// Element of each cell of the storey's grid, as built.
    pub(crate) owners: Vec<u32>,
    /// Cells that an element of a change has in the model and not in the building, by element.
    pub(crate) vacated: Vec<Vec<usize>>,
    is_glass: Vec<bool>,
}

impl ChangedBuilding {
    /// The storey with these changes.
    ///
    /// # Errors
    /// Too little floor or walls.
    pub(crate) fn new(storey: &ModelStorey, changes: &[GroupChange]) -> Result<Self, ReferenceError> {
        let grid = &storey.grid;
        let mut owners = vec![NO_ELEMENT; grid.floor.len()];
        let mut change_of = vec![None; storey.elements.len()];
        for change in changes {
            change.members.iter().for_each(|k| change_of[*k] = Some(change));
        }
        // What fills an opening of a wall goes where the wall goes.
        for (k, element) in storey.elements.iter().enumerate().filter(|(_, e)| e.class == "window") {
            change_of[k] = changes.iter().find(|c| c.rectangle.grown(0.1).contains(element.rectangle.centre));
        }
        let planned: Vec<Vec<usize>> = storey.elements.iter().map(|e| cells(grid, &e.borders, [0.0; 2])).collect();
        // Where a pane reaches into a wall there is wall.
        let (panes, solid): (Vec<_>, Vec<_>) = storey.elements.iter().enumerate().partition(|(_, e)| e.is_glass());
        for (k, element) in panes.into_iter().chain(solid) {
            let built = match change_of[k].map(|c| (c.change, &c.rectangle)) {
                None | Some((Change::Kept, _)) => planned[k].clone(),
                Some((Change::Removed, _)) => Vec::new(),
                Some((Change::Displaced { by_m }, _)) => cells(grid, &element.borders, by_m),
                Some((Change::Hole { ends_m: [a, b] }, wall)) => {
                    let hole = Rectangle {
                        half: [distance(a, b) / 2.0, wall.half[1] + 0.05],
                        ..Rectangle::between(a, b, 0.0)
                    };
                    planned[k].iter().copied().filter(|c| !hole.contains(grid.middle(*c))).collect()
                }
            };
            built.into_iter().for_each(|c| owners[c] = k as u32);
        }
        let is_changed = |k: usize| change_of[k].is_some();
        let vacated = planned.into_iter().enumerate().map(|(k, of)| {
            of.into_iter().filter(|c| is_changed(k) && owners[*c] == NO_ELEMENT).collect::<Vec<usize>>()
        });
        let vacated: Vec<Vec<usize>> = vacated.collect();
        let is_glass = owners.iter().map(|k| *k != NO_ELEMENT && storey.elements[*k as usize].is_glass()).collect();
        let map = OccupancyMap {
            width: grid.width,
            cells: as_built(storey, &owners, &vacated),
            resolution_m: grid.resolution_m,
            origin: [grid.origin[0], grid.origin[1], 0.0],
        };
        let name = format!("{}-{}", storey.building, storey.storey);
        let reference = Reference::new(name, storey.building.clone(), map, None)?;
        Ok(Self { reference, owners, vacated, is_glass })
    }

    /// Its cells for the simulation.
    pub(crate) fn world(&self) -> World {
        let mut world = World::of(&self.reference.grid);
        for index in 0..world.cells.len() {
            if self.reference.grid.index_at(world.middle(index)).is_some_and(|k| self.is_glass[k]) {
                world.cells[index] = Material::Glass;
            }
        }
        world
    }
}

/// Elements, floor, and floor where elements are gone; the planning map leaves a border of a cell around them.
fn as_built(storey: &ModelStorey, owners: &[u32], vacated: &[Vec<usize>]) -> Vec<Cell> {
    let grid = &storey.grid;
    let mut out: Vec<Cell> = grid.floor.iter().map(|f| if *f { Cell::Free } else { Cell::Unknown }).collect();
    for cell in vacated.iter().flatten() {
        let [column, row] = [cell % grid.width, cell / grid.width];
        for y in row.saturating_sub(2)..(row + 3).min(grid.height) {
            for x in column.saturating_sub(2)..(column + 3).min(grid.width) {
                out[y * grid.width + x] = Cell::Free;
            }
        }
    }
    let built = out.iter_mut().zip(owners).filter(|(_, owner)| **owner != NO_ELEMENT);
    built.for_each(|(cell, _)| *cell = Cell::Occupied);
    out
}
