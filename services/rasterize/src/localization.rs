//! What a localisation lidar sees of finished structure.

use crate::compose::{FREE, OCCUPIED, UNKNOWN};
use crate::cut::StoreyCut;
use grid::{Class, Mask, grow_through};
use messages::{ElementState, Phase};

/// A wall shows its face and the cell behind it: thicker walls pull scan matchers inward.
const SHELL_CELLS: f64 = 2.0;

/// What the layer is made from.
pub(crate) struct LocalizationInput<'a> {
    pub(crate) phase: &'a Phase<'a>,
    pub(crate) storey: &'a StoreyCut,
    pub(crate) floor: &'a Mask,
    pub(crate) class: &'a [u8],
}

/// Writes the layer: a shell of lasting structure at the lidar's height where it faces floor, floor without anything
/// on it free, all else unknown. Blocking a space changes nothing.
pub(crate) fn localization(input: &LocalizationInput<'_>, layer: &mut [i8]) {
    let (width, height) = (input.storey.spec.width as usize, input.storey.spec.height as usize);
    let mut structure = Mask::new(width, height);
    for element in &input.storey.lidar {
        if input.phase.effective(element.element as usize) == ElementState::Built {
            structure.set_runs(&element.runs);
        }
    }
    let is_open = |i: usize| input.floor.cells[i] && input.class[i] == Class::None.id() && !structure.cells[i];
    let open = Mask { width, cells: (0..layer.len()).map(is_open).collect() };
    // Doors, glass, furniture and the like may hide a face that is structure all the same.
    let facing = Mask { width, cells: (0..layer.len()).map(|i| input.floor.cells[i] && !structure.cells[i]).collect() };
    let shell = grow_through(&facing, &structure, SHELL_CELLS);
    for (index, value) in layer.iter_mut().enumerate() {
        *value = if shell.cells[index] {
            OCCUPIED
        } else if open.cells[index] {
            FREE
        } else {
            UNKNOWN
        };
    }
}
