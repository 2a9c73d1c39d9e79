//! Finds the elements on whose state the grid of a storey depends, and the cells that each can change.

use crate::model::other_levels::candidates;
use crate::model::storey_slice::{Dependent, StoreySlice};
use geometry::Slab;
use grid::CellRect;
use messages::{FloorKind, NONE, Site};

/// Elements that reach between these heights or are drawn on the storey, sorted by element. May include elements without
/// effect.
pub(crate) fn dependents(site: &Site<'_>, storey: &StoreySlice, heights: Slab) -> Vec<Dependent> {
    let mut list = DependentList { indices: vec![NONE; site.elements.len()], dependents: Vec::new() };
    for (element, record) in (0..).zip(site.elements) {
        if record.n_parts > 0 && heights.meets(record.min_tenths[2], record.max_tenths[2]) {
            list.of(element);
        }
    }
    let on_patches = storey.ground.iter().flat_map(|patch| patch.obstacles.iter().chain(&patch.lidar));
    for drawn in storey.obstacles.iter().chain(&storey.lidar).chain(on_patches) {
        add(&mut list.of(drawn.element).cells, drawn.rect);
        if let Some(door) = &drawn.door {
            // The passage also depends on the presence of the adjoining leaves.
            for element in door.leaves.iter().flat_map(|leaf| [leaf.element, leaf.host]).filter(|e| *e != NONE) {
                add(&mut list.of(element).cells, drawn.rect);
                add(&mut list.of(element).cells, door.around);
            }
        }
    }
    for patch in storey.ground.iter().filter(|patch| patch.element != NONE) {
        add(&mut list.of(patch.element).floor, Some(patch.rect));
    }
    for passage in &storey.passages {
        add(&mut list.of(passage.host).cells, passage.rect);
    }
    for (index, overhead) in (0..).zip(&storey.overhead) {
        list.of(overhead.element).overhead = Some(index);
    }
    let pieces = || storey.floor.iter().chain(&storey.floor_above);
    for piece in pieces() {
        add(&mut list.of(piece.element).floor, piece.rect);
    }
    let mut floors: Vec<u32> = pieces().map(|piece| piece.element).collect();
    floors.extend(storey.ground.iter().map(|patch| patch.element).filter(|e| *e != NONE));
    if storey.floor_kind != FloorKind::Ground {
        floors.extend(candidates(site, storey.floor_z));
    }
    floors.sort_unstable();
    floors.dedup();
    for (index, element) in (0..).zip(floors) {
        list.of(element).floor_index = Some(index);
    }
    list.dependents.sort_by_key(|n| n.element);
    list.dependents
}

struct DependentList {
    /// Index of each element of the site in `dependents`.
    indices: Vec<u32>,
    dependents: Vec<Dependent>,
}

impl DependentList {
    fn of(&mut self, element: u32) -> &mut Dependent {
        let index = &mut self.indices[element as usize];
        if *index == NONE {
            *index = self.dependents.len() as u32;
            self.dependents.push(Dependent { element, cells: None, floor_index: None, floor: None, overhead: None });
        }
        &mut self.dependents[*index as usize]
    }
}

fn add(cells: &mut Option<CellRect>, more: Option<CellRect>) {
    *cells = match (*cells, more) {
        (Some(a), Some(b)) => Some(a.around_both(&b)),
        (a, b) => a.or(b),
    };
}
