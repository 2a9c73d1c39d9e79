//! Which elements a storey's grid depends on, and what of it each of them can change.

use crate::cut::StoreyCut;
use crate::regions;
use geometry::Slab;
use grid::CellRect;
use messages::{ElementState, NONE, Site};

/// What of an element's state can be seen on a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Look {
    /// Not there yet, or no longer.
    Absent,
    /// Being built or removed: an obstacle, no floor, and nobody must be below it.
    WorkedOn,
    /// Finished.
    Built,
}

impl Look {
    pub(crate) fn of(state: ElementState) -> Self {
        match state {
            ElementState::NotStarted | ElementState::Removed => Self::Absent,
            ElementState::InProgress | ElementState::BeingRemoved => Self::WorkedOn,
            ElementState::Built => Self::Built,
        }
    }

    pub(crate) fn is_obstacle(self) -> bool {
        self != Self::Absent
    }
}

/// An element whose state can change a storey's grid.
#[derive(Debug, Clone)]
pub(crate) struct Near {
    pub(crate) element: u32,
    /// Cells of the element itself, of the doors that hang in it or beside it, and of the passages through it.
    pub(crate) cells: Option<CellRect>,
    /// Its place among the elements that make floor, on this level or on another.
    pub(crate) floor_place: Option<u32>,
    /// Cells of its floor on this level, or on one in the robot's way.
    pub(crate) floor: Option<CellRect>,
    /// Its place in [`StoreyCut::overhead`].
    pub(crate) overhead: Option<u32>,
}

/// Elements that reach between these heights, or are drawn on the storey all the same: rather too many than too few. By
/// element.
pub(crate) fn near(site: &Site<'_>, storey: &StoreyCut, heights: Slab) -> Vec<Near> {
    let mut list = List { places: vec![NONE; site.elements.len()], near: Vec::new() };
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
    floors.extend(regions::candidates(site, storey.floor_z));
    floors.sort_unstable();
    floors.dedup();
    for (place, element) in (0..).zip(floors) {
        list.of(element).floor_place = Some(place);
    }
    list.near.sort_by_key(|n| n.element);
    list.near
}

struct List {
    /// Place of each element of the site in `near`.
    places: Vec<u32>,
    near: Vec<Near>,
}

impl List {
    fn of(&mut self, element: u32) -> &mut Near {
        let place = &mut self.places[element as usize];
        if *place == NONE {
            *place = self.near.len() as u32;
            self.near.push(Near { element, cells: None, floor_place: None, floor: None, overhead: None });
        }
        &mut self.near[*place as usize]
    }
}

fn add(cells: &mut Option<CellRect>, more: Option<CellRect>) {
    *cells = match (*cells, more) {
        (Some(a), Some(b)) => Some(a.around_both(&b)),
        (a, b) => a.or(b),
    };
}
