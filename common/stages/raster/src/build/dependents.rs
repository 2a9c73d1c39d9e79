//! Elements that a storey's grid depends on, and the cells that each can change.

use crate::model::other_levels::candidates;
use crate::model::storey_slice::{Dependent, StoreyCut};
use geometry::Slab;
use grid::CellRect;
use messages::{NONE, Site};

/// Elements that reach between these heights, or are drawn on the storey all the same: rather too many than too few. By
/// element.
pub(crate) fn dependents(site: &Site<'_>, storey: &StoreyCut, heights: Slab) -> Vec<Dependent> {
    let mut list = List { places: vec![NONE; site.elements.len()], dependents: Vec::new() };
    for (element, record) in (0..).zip(site.elements) {
        if record.n_parts > 0 && heights.meets(record.min_tenths[2], record.max_tenths[2]) {
            list.of(element);
        }
    }
    for drawn in storey.obstacles.iter().chain(&storey.lidar) {
        add(&mut list.of(drawn.element).cells, drawn.rect);
        if let Some(door) = &drawn.door {
            // What the leaves beside it look like decides, too.
            for element in door.leaves.iter().flat_map(|leaf| [leaf.element, leaf.host]).filter(|e| *e != NONE) {
                add(&mut list.of(element).cells, drawn.rect);
                add(&mut list.of(element).cells, door.around);
            }
        }
    }
    for passage in &storey.passages {
        add(&mut list.of(passage.host).cells, passage.rect);
    }
    for (place, overhead) in (0..).zip(&storey.overhead) {
        list.of(overhead.element).overhead = Some(place);
    }
    let pieces = || storey.floor.iter().chain(&storey.floor_above);
    for piece in pieces() {
        add(&mut list.of(piece.element).floor, piece.rect);
    }
    let mut floors: Vec<u32> = pieces().map(|piece| piece.element).collect();
    floors.extend(candidates(site, storey.floor_z));
    floors.sort_unstable();
    floors.dedup();
    for (place, element) in (0..).zip(floors) {
        list.of(element).floor_place = Some(place);
    }
    list.dependents.sort_by_key(|n| n.element);
    list.dependents
}

struct List {
    /// Place of each element of the site in `dependents`.
    places: Vec<u32>,
    dependents: Vec<Dependent>,
}

impl List {
    fn of(&mut self, element: u32) -> &mut Dependent {
        let place = &mut self.places[element as usize];
        if *place == NONE {
            *place = self.dependents.len() as u32;
            self.dependents.push(Dependent { element, cells: None, floor_place: None, floor: None, overhead: None });
        }
        &mut self.dependents[*place as usize]
    }
}

fn add(cells: &mut Option<CellRect>, more: Option<CellRect>) {
    *cells = match (*cells, more) {
        (Some(a), Some(b)) => Some(a.around_both(&b)),
        (a, b) => a.or(b),
    };
}
