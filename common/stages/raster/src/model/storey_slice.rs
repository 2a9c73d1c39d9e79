//! The date-independent slice of a storey: runs of cells per element, space and passage.

use super::element_runs::ElementRuns;
use super::ground_patch::{GroundPatch, LevelFace};
use super::obstacle_squares::ObstacleSquares;
use frames::TENTHS_PER_M;
use geometry::{Footprint, LazyFootprint, MultiPolygon, OrientedBox, Ring, Slab, SlabCut};
use grid::{CellRect, GridSpec, Run, cells_of_cut};
use messages::{FloorKind, MapStoreyRecord, Site};
use std::sync::OnceLock;

/// Upward faces of an element within a step of the floor.
#[derive(Debug)]
pub(crate) struct FloorPiece {
    pub(crate) element: u32,
    pub(crate) rings: Vec<Ring>,
    /// Cells that the faces touch.
    pub(crate) rect: Option<CellRect>,
}

/// A space on the storey.
#[derive(Debug)]
pub(crate) struct SpaceRuns {
    pub(crate) space: u32,
    pub(crate) polygon: MultiPolygon,
    pub(crate) runs: Vec<Run>,
    /// Around the runs.
    pub(crate) rect: Option<CellRect>,
}

/// An opening through a wall at the height of the floor.
#[derive(Debug)]
pub(crate) struct Passage {
    pub(crate) host: u32,
    pub(crate) plan: OrientedBox,
    pub(crate) runs: Vec<Run>,
    /// Around the runs.
    pub(crate) rect: Option<CellRect>,
    /// Cells in which floor is searched.
    pub(crate) around: Option<CellRect>,
    /// True if the floor on one of its sides is assumed: what it adds to the floor is, too.
    pub(crate) is_beside_assumed: bool,
}

/// A map storey, cut to its slab.
#[derive(Debug)]
pub(crate) struct StoreySlice {
    pub(crate) map_storey: u32,
    pub(crate) spec: GridSpec,
    pub(crate) floor_z: i32,
    pub(crate) floor_kind: FloorKind,
    /// Of the elements in the slab, by element.
    pub(crate) footprints: Vec<(u32, LazyFootprint)>,
    /// In drawing order of the classes; later ones are drawn over earlier ones.
    pub(crate) obstacles: Vec<ElementRuns>,
    /// Where to find them.
    pub(crate) obstacle_squares: ObstacleSquares,
    /// Sections of lasting elements at the lidar's height.
    pub(crate) lidar: Vec<ElementRuns>,
    pub(crate) floor: Vec<FloorPiece>,
    /// Ground that leads from this floor to other heights.
    pub(crate) ground: Vec<GroundPatch>,
    /// Floor within a step of this floor, where there is such ground.
    pub(crate) level_faces: Vec<LevelFace>,
    /// Upward faces in the slab: floor of another level, in the robot's way.
    pub(crate) floor_above: Vec<FloorPiece>,
    /// From the largest to the smallest: where spaces overlap the smaller wins.
    pub(crate) spaces: Vec<SpaceRuns>,
    pub(crate) passages: Vec<Passage>,
    /// Floor that is assumed in rooms without a slab.
    pub(crate) assumed_floor: MultiPolygon,
    /// Cells that it covers whole.
    pub(crate) assumed_runs: Vec<Run>,
    /// Lift shafts, risers and pits: never floor.
    pub(crate) shafts: MultiPolygon,
    /// Cells that are no floor although obstacles enclose them, on a storey whose floor is assumed from that.
    pub(crate) open_to_below: Vec<Run>,
    /// Elements between this floor and the next.
    pub(crate) overhead: Vec<Overhead>,
    /// Elements whose state can change the storey's grid, and where.
    pub(crate) dependents: Vec<Dependent>,
}

/// An element between this floor and the next. The cells below it are keep-out while it is worked on.
#[derive(Debug)]
pub(crate) struct Overhead {
    pub(crate) element: u32,
    /// Its cells and the rectangle around them, computed on first use.
    cells: OnceLock<(Vec<Run>, Option<CellRect>)>,
}

impl Overhead {
    /// An element whose cells are not computed yet.
    pub(crate) fn new(element: u32) -> Self {
        Self { element, cells: OnceLock::new() }
    }
}

/// An element whose state can change a storey's grid.
#[derive(Debug, Clone)]
pub(crate) struct Dependent {
    pub(crate) element: u32,
    /// Cells of the element itself, of the doors that hang in it or beside it, and of the passages through it.
    pub(crate) cells: Option<CellRect>,
    /// Its index among the elements that make floor, on this level or on another.
    pub(crate) floor_index: Option<u32>,
    /// Cells of its floor on this level, or on one in the robot's way.
    pub(crate) floor: Option<CellRect>,
    /// Its index in [`StoreySlice::overhead`].
    pub(crate) overhead: Option<u32>,
}

/// Minimum height difference of two storeys, in tenths of a millimetre; a nearer floor is another level of the same storey.
pub(crate) const MIN_STOREY_HEIGHT: i32 = 2 * TENTHS_PER_M;

impl StoreySlice {
    /// A map storey on which nothing is.
    pub(crate) fn empty(map_storey: usize, spec: GridSpec, record: &MapStoreyRecord) -> Self {
        Self {
            map_storey: map_storey as u32,
            spec,
            floor_z: record.floor_z_tenths,
            floor_kind: record.floor.get(),
            footprints: Vec::new(),
            obstacles: Vec::new(),
            obstacle_squares: ObstacleSquares::default(),
            lidar: Vec::new(),
            floor: Vec::new(),
            ground: Vec::new(),
            level_faces: Vec::new(),
            floor_above: Vec::new(),
            spaces: Vec::new(),
            passages: Vec::new(),
            assumed_floor: MultiPolygon::default(),
            assumed_runs: Vec::new(),
            shafts: MultiPolygon::default(),
            open_to_below: Vec::new(),
            overhead: Vec::new(),
            dependents: Vec::new(),
        }
    }

    /// A map storey of the ground outdoors, on which nothing is.
    #[cfg(test)]
    pub(crate) fn of_ground_outdoors(spec: GridSpec, floor_z: i32) -> Self {
        let record = MapStoreyRecord {
            global_id: messages::Text::default(),
            name: messages::Text::default(),
            floor_z_tenths: floor_z,
            floor: FloorKind::Ground.into(),
            bounds_tenths: [0; 4],
        };
        Self::empty(0, spec, &record)
    }

    /// All cells.
    pub(crate) fn whole(&self) -> CellRect {
        CellRect::whole(self.spec.width, self.spec.height)
    }

    /// The footprint of an element in the slab; `None` for others.
    pub(crate) fn footprint(&self, site: &Site<'_>, element: u32) -> Option<&Footprint> {
        let at = self.footprints.binary_search_by_key(&element, |(e, _)| *e).ok()?;
        Some(self.footprints[at].1.get(|| site.element_meshes(&site.elements[element as usize])))
    }

    /// The cells of the footprint of an overhead element, by its index in [`Self::overhead`].
    pub(crate) fn overhead_runs(&self, site: &Site<'_>, index: u32) -> &[Run] {
        &self.overhead_cells(site, index).0
    }

    /// The rectangle around these cells.
    pub(crate) fn overhead_rect(&self, site: &Site<'_>, index: u32) -> Option<CellRect> {
        self.overhead_cells(site, index).1
    }

    fn overhead_cells(&self, site: &Site<'_>, index: u32) -> &(Vec<Run>, Option<CellRect>) {
        let overhead = &self.overhead[index as usize];
        overhead.cells.get_or_init(|| {
            let slab = overhead_slab(site, self.floor_kind, self.floor_z);
            let cut = SlabCut::of(site.element_meshes(&site.elements[overhead.element as usize]), slab);
            let runs = cells_of_cut(&cut, &self.spec);
            let rect = CellRect::around(&runs);
            (runs, rect)
        })
    }
}

/// Heights between which an element that is worked on makes what lies below it keep-out: to the next floor, outdoors all.
pub(crate) fn overhead_slab(site: &Site<'_>, floor_kind: FloorKind, floor_z: i32) -> Slab {
    if floor_kind == FloorKind::Ground {
        return Slab { lo: i32::MIN / 2, hi: i32::MAX / 2 };
    }
    Slab { lo: floor_z, hi: next_floor_z(site, floor_z) }
}

/// Height of the next floor above, or of the top of the highest element.
pub(crate) fn next_floor_z(site: &Site<'_>, floor_z: i32) -> i32 {
    site.next_floor_z_tenths(floor_z, MIN_STOREY_HEIGHT)
}
