//! The grid of a storey, redrawn incrementally for each schedule state.
//!
//! The first draw covers the whole storey. Later draws compare the schedule state with the one drawn, redraw the rectangles
//! of elements and spaces that differ, and recompute keep-out and localization around the cells whose flags differ then. The result
//! equals a full redraw.
//! After one pass through all states it allocates nothing, except on storeys whose floor is what obstacles enclose.

use super::shown_patches::{ShownPatches, StandsInWay};
use super::state_difference::{DrawnState, StateDifference};
use super::storey_floor::StoreyFloor;
use super::version_history::VersionHistory;
use crate::layers::cell_flags::{self, BASE_FLOOR, BLOCKED, DOOR, FLOOR, OCCUPIED, OUTLINE, PLANNING, STRUCTURE, WORK};
use crate::layers::door_passage::{DoorLayers, door_passage};
use crate::layers::doorway_clearance::CoveredSamples;
use crate::layers::doorway_connection::SeenCells;
use crate::layers::floor::outline;
use crate::layers::keepout::{Keepout, Margins, keepout_value};
use crate::layers::localization::{Localization, localization_value};
use crate::layers::shown_surface::LEVEL;
use crate::layers::tile::TILE_CELLS;
use crate::model::cell_area::slab_above_floor;
use crate::model::element_runs::ElementRuns;
use crate::model::gap;
use crate::model::ground_patch::{level_z, z_at};
use crate::model::presence::Presence;
use crate::model::storey_inputs::StoreyInputs;
use crate::model::storey_slice::StoreySlice;
use geometry::Plane;
use grid::{CellRect, Class, GridSpec, Growth, Run, join_rects};
use messages::{
    ArchiveBuffer, ArchiveKind, BlockHashes, ContentHash, DoorPassageRecord, FLOOR_ASSUMED, FLOOR_BUILT, FloorKind,
    GridHead, GridLayers, GridWriter, NO_HEIGHT, NO_SLOPE, NONE, Preamble, RegionRecord, RobotProfile, ScheduleState,
    copy_changed,
};

/// The grid of a storey as drawn last.
#[derive(Debug)]
pub(crate) struct StoreyGrid {
    archive: ArchiveBuffer,
    content_hash: ContentHash,
    block_hashes: BlockHashes,
    versions: VersionHistory,
    /// A byte of [`cell_flags`] per cell.
    flags: Vec<u8>,
    /// Margins that cover a cell, a byte per cell.
    margins: Vec<u8>,
    drawn_state: DrawnState,
    storey_floor: StoreyFloor,
    /// True before the first slab: everything unknown and keep-out.
    has_no_floor_yet: bool,
    /// Passages of the doors.
    doors: Vec<DoorPassageRecord>,
    /// Buffer for the obstacles near a doorway.
    nearby: CoveredSamples,
    seen_cells: SeenCells,
    difference: StateDifference,
    /// What a rectangle shows that is drawn.
    shown_patches: ShownPatches,
    growth: Growth,
}

impl StoreyGrid {
    /// The grid of a storey before the first draw.
    pub(crate) fn new(inputs: StoreyInputs<'_>) -> Self {
        let StoreyInputs { site, robot, storey } = inputs;
        let GridSpec { cell_tenths, first_cell, width, height } = storey.spec;
        let record = &site.map_storeys[storey.map_storey as usize];
        let head = GridHead {
            cell_tenths,
            first_cell,
            width,
            height,
            map_storey: storey.map_storey,
            floor_z_tenths: record.floor_z_tenths,
            slab_tenths: slab_above_floor(robot),
            floor: record.floor,
            frame_epoch: site.head.frame_epoch,
            reserved: 0,
        };
        let n_cells = storey.spec.n_cells();
        let len_of = if storey.ground.is_empty() { GridWriter::len_of } else { GridWriter::len_with_heights };
        let mut archive = ArchiveBuffer::zeroed(len_of(n_cells));
        let mut writer = GridWriter::new(archive.bytes_mut(), &head);
        let whole = storey.whole();
        for space in &storey.spaces {
            // From the largest to the smallest, so that the smaller wins where they overlap.
            for cells in whole.clip(&space.runs, whole.width()) {
                writer.layers().space[cells].fill(space.space as u16 + 1);
            }
        }
        let (storey_floor, complete) = StoreyFloor::new(inputs);
        let flags: Vec<u8> =
            outline(storey, &complete).cells.iter().map(|&inside| if inside { OUTLINE } else { 0 }).collect();
        Self {
            archive,
            content_hash: ContentHash::NONE,
            block_hashes: BlockHashes::default(),
            versions: VersionHistory::default(),
            margins: vec![0; flags.len()],
            flags,
            drawn_state: DrawnState::default(),
            storey_floor,
            has_no_floor_yet: false,
            doors: Vec::new(),
            nearby: CoveredSamples::new(),
            seen_cells: SeenCells::default(),
            difference: StateDifference::default(),
            shown_patches: ShownPatches::default(),
            growth: Growth::default(),
        }
    }

    /// The archive of the grid, as drawn last.
    pub(crate) fn archive(&self) -> &[u8] {
        self.archive.bytes()
    }

    /// Makes memory of the archive's length a copy of it. If that holds one of the latest versions, it takes what differs.
    pub(crate) fn copy_into(&self, memory: &mut [u8]) {
        let archive = self.archive();
        let held = Preamble::of(memory, ArchiveKind::Grid).ok().filter(|held| held.length == archive.len() as u64);
        match held.and_then(|held| self.versions.changed_since(held.content_hash)) {
            Some(changed) => copy_changed(archive, memory, changed),
            None => memory.copy_from_slice(archive),
        }
    }

    /// Its content hash.
    pub(crate) fn content_hash(&self) -> ContentHash {
        self.content_hash
    }

    /// Hash of all inputs from the schedule state.
    pub(crate) fn input_hash(&self) -> ContentHash {
        ContentHash::of(&self.drawn_state.state_bytes)
    }

    /// Passages of the doors.
    pub(crate) fn doors(&self) -> &[DoorPassageRecord] {
        &self.doors
    }

    /// Finished floor at other levels.
    pub(crate) fn regions(&self) -> &[RegionRecord] {
        &self.storey_floor.regions
    }

    /// Draws the grid of a schedule state.
    pub(crate) fn draw(&mut self, inputs: StoreyInputs<'_>, schedule_state: &ScheduleState<'_>) {
        let is_first = self.drawn_state.state_bytes.is_empty();
        let Self { flags, drawn_state, storey_floor, difference, .. } = self;
        if !difference.compare(drawn_state, inputs, schedule_state) {
            return;
        }
        storey_floor.update_floor(flags, difference, &drawn_state.finished_floors, (inputs, schedule_state), is_first);
        storey_floor.update_passages(flags, difference, (inputs, schedule_state), is_first);
        let has_no_floor_yet = schedule_state.head.plan_time().is_some() && !self.storey_floor.has_floor;
        let is_whole = std::mem::replace(&mut self.has_no_floor_yet, has_no_floor_yet) != has_no_floor_yet || is_first;
        let whole = inputs.storey.whole();
        if is_first {
            self.difference.cells.clear();
            self.difference.cells.push(whole);
        }
        if self.difference.cells.is_empty() && !is_whole {
            return;
        }
        join_rects(&mut self.difference.cells);
        self.difference.flags.clear();
        for index in 0..self.difference.cells.len() {
            let rect = self.difference.cells[index];
            if is_whole {
                self.draw_cells(inputs, schedule_state, &rect);
                continue;
            }
            self.difference.flags.begin(&self.flags, &rect, whole.width());
            self.draw_cells(inputs, schedule_state, &rect);
            self.difference.flags.add(&self.flags, &rect, whole.width());
        }
        let Self { archive, flags, difference, .. } = self;
        let StateDifference { cells, changed, flags: differing, .. } = difference;
        changed.clear();
        changed.extend_from_slice(if is_whole { std::slice::from_ref(&whole) } else { cells });
        if has_no_floor_yet {
            let mut writer = GridWriter::resume(archive.bytes_mut(), flags.len());
            cell_flags::fill_without_floor(&mut writer.layers(), changed, whole.width());
        } else {
            if is_whole {
                differing.set_to_free(flags, &whole);
                self.start_layers();
            }
            self.derive(inputs);
        }
        self.update_door_passages(inputs, schedule_state);
        self.seal();
    }

    /// Makes the layers an archive, and remembers in which cells it may differ from the one before.
    fn seal(&mut self) {
        let Self { archive, flags, block_hashes, versions, difference, .. } = self;
        join_rects(&mut difference.changed);
        let writer = GridWriter::resume(archive.bytes_mut(), flags.len());
        self.content_hash = writer.seal_changed(block_hashes, &difference.changed);
        versions.push(self.content_hash, &difference.changed);
    }

    /// The archive, given up; what only a later draw would need is freed.
    pub(crate) fn into_archive(self) -> ArchiveBuffer {
        self.archive
    }

    /// Draws flags, class, floor and planning of a rectangle from the runs that meet it.
    fn draw_cells(&mut self, inputs: StoreyInputs<'_>, schedule_state: &ScheduleState<'_>, rect: &CellRect) {
        let StoreyInputs { site, robot, storey } = inputs;
        let width = storey.spec.width as usize;
        let Self { archive, flags, storey_floor, difference, shown_patches: shown, .. } = self;
        let mut writer = GridWriter::resume(archive.bytes_mut(), flags.len());
        let GridLayers { class, floor, planning, elevation, slope, .. } = writer.layers();
        for row in rect.rows(width) {
            class[row.clone()].fill(Class::None.id());
            flags[row].iter_mut().for_each(|f| *f = *f & (BASE_FLOOR | OUTLINE) | (*f & BASE_FLOOR) << 1);
        }
        let meets = |other: Option<CellRect>| other.is_some_and(|other| other.meets(rect));
        for (passage, _) in
            storey.passages.iter().zip(&storey_floor.open_passages).filter(|(p, open)| **open && meets(p.rect))
        {
            let cells = rect.clip(&passage.runs, width);
            cells.for_each(|cells| flags[cells].iter_mut().for_each(|f| *f |= FLOOR));
        }
        let mut cells = DrawnCells { class, flags, rect: *rect, width };
        for obstacle in storey.obstacles.iter().filter(|o| meets(o.rect)) {
            cells.draw_obstacle(obstacle, (robot, schedule_state), |_, _| true);
        }
        let is_built = |element: u32| {
            element == NONE || Presence::of(schedule_state.effective(element as usize)) == Presence::Built
        };
        for structure in storey.lidar.iter().filter(|l| meets(l.rect) && is_built(l.element)) {
            cells.set_runs(&structure.runs, STRUCTURE, |_, _| true);
        }
        if !storey_floor.patch_of.is_empty() {
            let patch_of = storey_floor.patch_of.as_slice();
            shown.find(patch_of, cells.flags, rect, width);
            cells.clear_patches(patch_of, |patch| storey.ground[patch as usize].is_tread);
            for (k, patch) in (0..).zip(&storey.ground).filter(|(_, p)| meets(p.stands) && is_built(p.element)) {
                let way = StandsInWay::of(storey, robot, k);
                let Some(around) = way.around(shown) else { continue };
                let mut cells = cells.within(&around);
                let meets = |other: Option<CellRect>| other.is_some_and(|other| other.meets(&around));
                let applies = |cell: usize, flags: u8| way.stands_on(patch_of[cell], cell, flags);
                for obstacle in patch.obstacles.iter().filter(|o| meets(o.rect)) {
                    cells.draw_obstacle(obstacle, (robot, schedule_state), applies);
                }
                for structure in patch.lidar.iter().filter(|l| meets(l.rect) && is_built(l.element)) {
                    cells.set_runs(&structure.runs, STRUCTURE, applies);
                }
            }
        }
        for space in storey.spaces.iter().filter(|s| meets(s.rect) && schedule_state.is_blocked(s.space as usize)) {
            cells.set_runs(&space.runs, BLOCKED, |_, _| true);
        }
        if !storey_floor.patch_of.is_empty() {
            for (k, around) in shown.iter() {
                let patch = &storey.ground[k as usize];
                if patch.is_tread {
                    cells.within(&around).show_stair(&patch.cells, |cell| storey_floor.patch_of[cell] == k);
                }
            }
        }
        for &index in difference.worked_on.iter().filter(|index| meets(storey.overhead_rect(site, **index))) {
            cells.set_runs(storey.overhead_runs(site, index), WORK, |_, _| true);
        }
        let DrawnCells { flags, .. } = cells;
        let is_assumed = storey.floor_kind == FloorKind::AssumedFromEnclosure;
        let floor_value = if is_assumed { FLOOR_ASSUMED } else { FLOOR_BUILT };
        for row in rect.rows(width) {
            let cells = flags[row.clone()].iter().zip(&mut floor[row.clone()]).zip(&mut planning[row]);
            for ((&flags, floor), planning) in cells {
                *floor = if flags & FLOOR != 0 { floor_value } else { 0 };
                *planning = PLANNING[usize::from(flags)];
            }
        }
        if !storey_floor.patch_of.is_empty() {
            let is_level = |cell: usize| storey_floor.patch_of[cell] == LEVEL;
            let mut heights = DrawnHeights { storey, flags, elevation, slope, rect };
            heights.clear();
            for face in storey.level_faces.iter().filter(|f| f.rect.meets(rect) && is_built(f.element)) {
                heights.raise(&face.plane, (&face.cells, rect), is_level);
            }
            for (k, around) in shown.iter() {
                let patch = &storey.ground[k as usize];
                if is_built(patch.element) {
                    heights.raise(&patch.plane, (&patch.cells, &around), |cell| storey_floor.patch_of[cell] == k);
                }
            }
            heights.fill_level();
        }
        for cells in rect.clip(&storey.assumed_runs, width) {
            floor[cells].iter_mut().filter(|floor| **floor != 0).for_each(|floor| *floor = FLOOR_ASSUMED);
        }
        // Where a slab goes on through a passage it is built there, whatever is beside it.
        for passage in storey.passages.iter().filter(|p| p.is_beside_assumed && meets(p.rect)) {
            for cells in rect.clip(&passage.runs, width) {
                let of_passage = flags[cells.clone()].iter().zip(&mut floor[cells]);
                let of_passage = of_passage.filter(|(flags, _)| **flags & (BASE_FLOOR | FLOOR) == FLOOR);
                of_passage.for_each(|(_, floor)| *floor = FLOOR_ASSUMED);
            }
        }
    }

    /// Makes the layers that [`Self::derive`] recomputes what they are far from floor and doors.
    fn start_layers(&mut self) {
        let Self { archive, flags, margins, .. } = self;
        let mut writer = GridWriter::resume(archive.bytes_mut(), flags.len());
        let GridLayers { planning, keepout, localization, .. } = writer.layers();
        margins.fill(0);
        planning.iter_mut().zip(&*flags).for_each(|(out, &flags)| *out = PLANNING[usize::from(flags)]);
        keepout.iter_mut().zip(&*flags).for_each(|(out, &flags)| *out = keepout_value(flags, 0));
        localization.iter_mut().zip(&*flags).for_each(|(out, &flags)| *out = localization_value(flags, false));
    }

    /// Recomputes keep-out and localization in all cells that the difference can affect.
    fn derive(&mut self, inputs: StoreyInputs<'_>) {
        let Self { archive, flags, margins: cell_margins, difference, growth, .. } = self;
        let mut writer = GridWriter::resume(archive.bytes_mut(), flags.len());
        let GridLayers { keepout: keepout_layer, localization: localization_layer, .. } = writer.layers();
        let (margins, whole) = (Margins::of(inputs), inputs.storey.whole());
        let StateDifference { flags: differing, work, working, affected, changed, .. } = difference;
        let mut each =
            |cells: &[CellRect], reach: u32, wanted: &dyn Fn(&CellRect) -> bool, compute: &mut dyn FnMut(&CellRect)| {
                affected.clear();
                affected.extend(cells.iter().map(|rect| rect.grown(reach, &whole)).filter(|rect| wanted(rect)));
                join_rects(affected);
                changed.extend_from_slice(affected);
                affected.iter().flat_map(|rect| rect.tiles(TILE_CELLS)).for_each(|tile| compute(&tile));
            };
        let mut keepout = Keepout { flags, margins: cell_margins, layer: keepout_layer, whole };
        each(&differing.of_edges, margins.edge_reach(), &|_| true, &mut |tile| keepout.edges(growth, margins, tile));
        let is_near_work = |rect: &CellRect| {
            let around = rect.grown(margins.work_reach(), &whole);
            work.iter().chain(&*working).any(|work| work.meets(&around))
        };
        each(&differing.of_work, margins.work_reach(), &is_near_work, &mut |tile| keepout.work(growth, margins, tile));
        let gap_cells = gap::max_cells(inputs.storey.spec.cell_tenths);
        let mut localization = Localization { flags, layer: localization_layer, whole, gap_cells };
        each(&differing.of_localization, localization.reach(), &|_| true, &mut |tile| localization.draw(growth, tile));
    }

    /// Updates the passages of doors around which cells differ.
    fn update_door_passages(&mut self, inputs: StoreyInputs<'_>, schedule_state: &ScheduleState<'_>) {
        let storey = inputs.storey;
        let Self { archive, flags, doors, nearby, seen_cells, difference, .. } = self;
        let mut writer = GridWriter::resume(archive.bytes_mut(), flags.len());
        let GridLayers { class, floor, .. } = writer.layers();
        let layers = DoorLayers { class, floor, flags };
        let obstacles = storey.obstacles.iter().filter(|o| o.class == Class::Door);
        let at_doors = obstacles.filter_map(|o| Some((o.element, o.door.as_ref().filter(|d| d.stands_here)?)));
        for (index, (element, door)) in at_doors.enumerate() {
            let around = door.around.filter(|_| index < doors.len());
            if around.is_some_and(|around| !difference.cells.iter().any(|rect| rect.meets(&around))) {
                continue;
            }
            let presence = Presence::of(schedule_state.effective(element as usize));
            let record = door_passage(door, inputs, schedule_state, presence, layers, nearby, seen_cells);
            match doors.get_mut(index) {
                Some(door) => *door = record,
                None => doors.push(record),
            }
        }
    }
}

/// Heights and slopes of the cells of a rectangle while they are drawn.
struct DrawnHeights<'a> {
    storey: &'a StoreySlice,
    flags: &'a [u8],
    elevation: &'a mut [i32],
    slope: &'a mut [u16],
    rect: &'a CellRect,
}

impl DrawnHeights<'_> {
    fn width(&self) -> usize {
        self.storey.spec.width as usize
    }

    fn clear(&mut self) {
        for row in self.rect.rows(self.width()) {
            self.elevation[row.clone()].fill(NO_HEIGHT);
            self.slope[row].fill(NO_SLOPE);
        }
    }

    /// Makes cells with floor as high as a plane where they are lower, of those of runs in a rectangle that are wanted.
    fn raise(&mut self, plane: &Plane, (cells, rect): (&[Run], &CellRect), wanted: impl Fn(usize) -> bool) {
        let slope = (plane.slope_rad() * 1_000.0).round() as u16;
        let level = level_z(plane).map(|z| z.round() as i32);
        let width = self.width();
        for cells in rect.clip(cells, width) {
            let [column, row] = [cells.start % width, cells.start / width].map(|k| k as f64 + 0.5);
            for (cell, column) in cells.zip(0..).map(|(cell, k)| (cell, column + f64::from(k))) {
                if self.flags[cell] & FLOOR != 0 && wanted(cell) {
                    let z = || z_at(plane, [column, row], &self.storey.spec).round() as i32;
                    let height = level.unwrap_or_else(z);
                    if height > self.elevation[cell] {
                        (self.elevation[cell], self.slope[cell]) = (height, slope);
                    }
                }
            }
        }
    }

    /// Floor of which no face is known lies at the level of the storey.
    fn fill_level(&mut self) {
        for cell in self.rect.rows(self.width()).flatten() {
            if self.flags[cell] & FLOOR != 0 && self.elevation[cell] == NO_HEIGHT {
                (self.elevation[cell], self.slope[cell]) = (self.storey.floor_z, 0);
            }
        }
    }
}

/// Class and flags of the cells of a rectangle while they are drawn.
struct DrawnCells<'a> {
    class: &'a mut [u8],
    flags: &'a mut [u8],
    rect: CellRect,
    width: usize,
}

impl DrawnCells<'_> {
    /// The cells of a rectangle in this one.
    fn within(&mut self, rect: &CellRect) -> DrawnCells<'_> {
        DrawnCells { class: self.class, flags: self.flags, rect: *rect, width: self.width }
    }

    /// Sets a flag in the cells of runs to which it applies, by cell and flags.
    fn set_runs(&mut self, runs: &[Run], flag: u8, applies: impl Fn(usize, u8) -> bool) {
        let Self { flags, rect, width, .. } = self;
        for cell in rect.clip(runs, *width).flatten() {
            flags[cell] |= if applies(cell, flags[cell]) { flag } else { 0 };
        }
    }

    /// Takes what stands above the level of the storey out of the cells that show a patch. A lidar on the level meets the risers of a
    /// stair all the same.
    fn clear_patches(&mut self, patch_of: &[u32], is_tread: impl Fn(u32) -> bool) {
        for cell in self.rect.rows(self.width).flatten().filter(|&cell| patch_of[cell] != LEVEL) {
            self.class[cell] = Class::None.id();
            let seen = if is_tread(patch_of[cell]) { STRUCTURE } else { 0 };
            self.flags[cell] &= BASE_FLOOR | FLOOR | OUTLINE | seen;
        }
    }

    /// Shows the class of stairs in free cells of a tread.
    fn show_stair(&mut self, tread: &[Run], shows: impl Fn(usize) -> bool) {
        let Self { class, flags, rect, width } = self;
        for cell in rect.clip(tread, *width).flatten().filter(|&cell| shows(cell)) {
            if flags[cell] & (FLOOR | OCCUPIED | DOOR | BLOCKED) == FLOOR {
                class[cell] = Class::Stair.id();
            }
        }
    }

    /// Draws an obstacle or door in its cells, where it applies.
    fn draw_obstacle(
        &mut self,
        obstacle: &ElementRuns,
        (robot, schedule_state): (&RobotProfile, &ScheduleState<'_>),
        applies: impl Fn(usize, u8) -> bool,
    ) {
        let presence = Presence::of(schedule_state.effective(obstacle.element as usize));
        // A door is absent without its host wall.
        if !presence.is_obstacle() || !obstacle.door.as_ref().is_none_or(|d| d.is_hung(schedule_state)) {
            return;
        }
        // A door that is being hung or removed counts as closed.
        let stands_here = obstacle.door.as_ref().is_none_or(|d| d.stands_here);
        let is_open_door = obstacle.class == Class::Door
            && stands_here
            && obstacle.door.as_ref().is_none_or(|d| d.can_pass(schedule_state, robot) && presence == Presence::Built);
        let set = match (is_open_door, obstacle.class == Class::Door) {
            (true, _) => DOOR,
            (false, true) => DOOR | OCCUPIED,
            (false, false) => OCCUPIED,
        };
        // An obstacle drawn over a door hides it.
        let keep = if set & DOOR == 0 { !DOOR } else { u8::MAX };
        for cell in self.rect.clip(&obstacle.runs, self.width).flatten() {
            let flags = &mut self.flags[cell];
            if applies(cell, *flags) {
                self.class[cell] = obstacle.class.id();
                // An open leaf or a threshold is no floor: beside its passage a door is free only where floor is. A door of
                // another level is an obstacle only where floor is.
                let is_set = stands_here && !is_open_door || *flags & FLOOR != 0;
                *flags = *flags & keep | if is_set { set } else { 0 };
            }
        }
        for door in obstacle.door.iter().filter(|_| is_open_door) {
            self.set_runs(&door.passage_runs, DOOR, &applies);
            self.set_runs(&door.fixed_runs, DOOR | OCCUPIED, &applies);
        }
    }
}
