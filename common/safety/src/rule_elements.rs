//! The elements that a rule is about, and their cells on a map storey.

use crate::local_ground::{Band, LocalGround};
use frames::TENTHS_PER_M;
use geometry::{MultiPolygon, Point, Polygon, Slab, SlabCut};
use grid::{CellRect, GridSpec, Run, cells_of_cut, fifths_of, grow_labelled, overlapped_cells};
use messages::{
    ElementRecord, ElementState, Grid, GroundClass, NONE, OpeningRecord, SafetySubject, ScheduleState, Site,
    element_flags,
};
use std::collections::BTreeMap;

/// Floor within this height of the ground is driven on: 2 cm, or a step of the robot.
const MIN_STEP: i32 = TENTHS_PER_M / 50;

/// Parts of a whole up to so far from a part of it are before it: the depth of frames, metres.
const FRAME_M: f64 = 0.2;

/// Least height of a storey, as maps take it: a nearer floor is another level of the same one.
const MIN_STOREY_HEIGHT: i32 = 2 * TENTHS_PER_M;

/// What cells of elements are made from.
#[derive(Clone, Copy)]
pub(crate) struct StoreyElements<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) schedule_state: &'a ScheduleState<'a>,
    pub(crate) grid: &'a Grid<'a>,
    /// Heights of the ground of the grid.
    pub(crate) ground: &'a LocalGround,
}

impl StoreyElements<'_> {
    pub(crate) fn spec(&self) -> GridSpec {
        self.grid.spec()
    }

    /// True if the element is there: it stands, or is worked on.
    pub(crate) fn is_there(&self, element: u32) -> bool {
        self.schedule_state.effective(element as usize).is_obstacle()
    }

    /// The elements that are there and meet the storey's slab, of a rule about elements, each with its cells.
    pub(crate) fn cells_of(&self, subject: SafetySubject<'_>) -> Vec<(u32, Vec<Run>)> {
        let is_work = matches!(subject, SafetySubject::Work);
        // Terrain is driven on, in whatever form the file has it; while it is dug away or filled it is work.
        let is_ground = |record: &ElementRecord| !self.ground.is_level() && record.ground == GroundClass::Terrain;
        let elements = (0..).zip(self.site.elements).filter(|(element, record)| {
            let may_be_meant = record.n_parts > 0 && self.is_there(*element) && (is_work || !is_ground(record));
            may_be_meant && self.is_meant(subject, *element, record)
        });
        let mut wholes = BTreeMap::new();
        elements
            .map(|(element, record)| (element, record, self.cells_of_element(element, record, is_work)))
            .filter(|(.., runs)| !runs.is_empty())
            .map(|(element, record, runs)| (element, self.with_frame(record, runs, &mut wholes)))
            .collect()
    }

    /// The cells of an element with those of the other parts of its whole that lie before it: a pane lies in a frame, and is as
    /// near as its frame's face. `wholes` are cells of wholes, by element.
    fn with_frame(
        &self,
        record: &ElementRecord,
        mut runs: Vec<Run>,
        wholes: &mut BTreeMap<u32, Vec<bool>>,
    ) -> Vec<Run> {
        if record.whole == NONE {
            return runs;
        }
        let spec = self.spec();
        let all = CellRect::whole(spec.width, spec.height);
        let of_whole = wholes.entry(record.whole).or_insert_with(|| {
            let mut cells = vec![false; spec.n_cells()];
            let parts =
                (0..).zip(self.site.elements).filter(|(_, part)| part.whole == record.whole && part.n_parts > 0);
            for (part, part_record) in parts.filter(|(part, _)| self.is_there(*part)) {
                let runs = self.cells_of_element(part, part_record, false);
                all.clip(&runs, spec.width as usize).for_each(|row| cells[row].fill(true));
            }
            cells
        });
        let reach = fifths_of(FRAME_M / spec.resolution_m());
        let face = grow_labelled(all, |cell| of_whole[cell], [(0, runs.as_slice())].into_iter(), reach);
        let cells =
            face.iter().enumerate().filter(|(_, nearest)| nearest.is_some()).map(|(cell, _)| spec.cell_of(cell));
        runs.extend(cells.map(|at| Run { row: at.row, start: at.column, end: at.column + 1 }));
        runs
    }

    fn is_meant(&self, subject: SafetySubject<'_>, element: u32, record: &ElementRecord) -> bool {
        match subject {
            SafetySubject::Glass => record.has(element_flags::GLASS),
            SafetySubject::Class(class) => record.class() == class,
            SafetySubject::Work => {
                let state = self.schedule_state.effective(element as usize);
                matches!(state, ElementState::InProgress | ElementState::BeingRemoved)
            }
            SafetySubject::Material(words) => {
                let words = words.to_lowercase();
                let whole = self.site.elements.get(record.whole as usize);
                let of = |record: &ElementRecord| {
                    self.site.element_materials(record).any(|name| name.to_lowercase().contains(&words))
                };
                of(record) || whole.is_some_and(of)
            }
            SafetySubject::StairEdge | SafetySubject::DoorSwing | SafetySubject::Stair => false,
        }
    }

    /// True if any of an element is at the heights of the robot over the ground there.
    pub(crate) fn is_at_robot(&self, element: u32) -> bool {
        !self.cells_of_element(element, &self.site.elements[element as usize], false).is_empty()
    }

    /// Cells that the element overlaps at the heights of the robot over the ground there, also as the floor that it drives on; of work
    /// those below it.
    fn cells_of_element(&self, element: u32, record: &ElementRecord, is_work: bool) -> Vec<Run> {
        let [low, high] = self.grid.head.slab_tenths;
        let low = if record.has(element_flags::FLOOR) { -low.max(MIN_STEP) } else { low };
        let slab = |[lowest, highest]: Band| {
            if is_work {
                Slab { lo: lowest, hi: self.site.next_floor_z_tenths(highest, MIN_STOREY_HEIGHT) }
            } else {
                Slab { lo: lowest + low, hi: highest + high }
            }
        };
        let filled = self.site.openings.iter().filter(|opening| opening.filling == element);
        let rect = self.ground.rect_of(record, filled.flat_map(corners_of));
        self.ground.cells(rect, |band| self.cells_in_slab(element, record, slab(band)))
    }

    /// Cells that the element overlaps in a slab. What fills an opening is in all of the opening: a window is as near as the wall's
    /// face.
    fn cells_in_slab(&self, element: u32, record: &ElementRecord, slab: Slab) -> Vec<Run> {
        if record.max_tenths[2] <= slab.lo || slab.hi <= record.min_tenths[2] {
            return Vec::new();
        }
        let mut runs = self.cut(record, slab);
        let is_filled = |opening: &&OpeningRecord| {
            opening.filling == element && opening.bottom_z_tenths < slab.hi && slab.lo < opening.top_z_tenths
        };
        for opening in self.site.openings.iter().filter(is_filled).filter(|opening| opening.is_in_wall()) {
            runs.extend(self.overlapped(&corners_of(opening)));
        }
        runs.sort_unstable();
        runs
    }

    /// Cells that the element overlaps in a slab.
    pub(crate) fn cut(&self, record: &ElementRecord, slab: Slab) -> Vec<Run> {
        cells_of_cut(&SlabCut::of(self.site.element_meshes(record), slab), &self.spec())
    }

    /// Cells that a polygon in `map`, counter-clockwise and in tenths of a millimetre, overlaps.
    pub(crate) fn overlapped(&self, corners: &[[f64; 2]]) -> Vec<Run> {
        #[expect(clippy::cast_possible_truncation, reason = "coordinates of a site fit into i32")]
        let ring: Vec<Point> = corners.iter().map(|corner| corner.map(|c| c.round() as i32)).collect();
        overlapped_cells(&MultiPolygon(vec![Polygon { exterior: ring, holes: Vec::new() }]), &[], &self.spec())
    }

    /// True if the door stands, and the wall that it hangs in.
    pub(crate) fn is_hung(&self, door: &messages::DoorRecord) -> bool {
        let host = self.site.openings.get(door.opening as usize).map_or(NONE, |opening| opening.host);
        self.is_there(door.element) && (host == NONE || self.is_there(host))
    }
}

/// Corners of an opening in plan, counter-clockwise, in tenths of a millimetre.
fn corners_of(opening: &OpeningRecord) -> [[f64; 2]; 4] {
    let plan = opening.plan.to_box();
    let [u, v] = plan.half;
    [[-u, -v], [u, -v], [u, v], [-u, v]].map(|[u, v]| plan.at(u, v))
}
