//! The grid of a storey, redrawn incrementally for each schedule state.
//!
//! The first draw covers the whole storey. Later draws compare the schedule state with the one drawn, repaint the rectangles
//! of elements and spaces that differ, and recompute keep-out and localization around them. The result equals a full redraw.
//! After one pass through all states it allocates nothing, except on storeys whose floor is what obstacles enclose.

use super::difference::{Difference, Seen};
use super::ground::Ground;
use super::scene::Scene;
use crate::layers::cell_flags::{self, BLOCKED, DOOR, FLOOR, GROUND, OCCUPIED, OUTLINE, PLANNING, STRUCTURE, WORK};
use crate::layers::clear_width::Standing;
use crate::layers::door_passage::{DoorLayers, door_passage};
use crate::layers::floor::{FloorPlans, outline, put};
use crate::layers::keepout::Keepout;
use crate::layers::localization::Localization;
use crate::layers::tiles::SIDE;
use crate::model::cell_area::slab_above_floor;
use crate::model::door::DoorAt;
use crate::model::gap;
use crate::model::presence::Look;
use grid::{CellRect, Class, GridSpec, Growth, join_rects};
use messages::{ArchiveBuffer, DoorPassageRecord, FloorKind, GridHead, GridLayers, GridWriter, Phase, RegionRecord};
use xxhash_rust::xxh3::xxh3_64;

/// A storey as it was drawn last.
#[derive(Debug)]
pub(crate) struct Canvas {
    archive: ArchiveBuffer,
    content_hash: u64,
    /// A byte of [`cell_flags`] per cell.
    facts: Vec<u8>,
    /// A byte of margins per cell.
    margins: Vec<u8>,
    seen: Seen,
    ground: Ground,
    /// True if it shows what a storey shows before its first slab.
    is_blank: bool,
    /// What a robot finds at the doors.
    doors: Vec<DoorPassageRecord>,
    /// What stands in the way through a door, while it is looked at.
    standing: Standing,
    difference: Difference,
    growth: Growth,
}

impl Canvas {
    /// A storey of which nothing is drawn.
    pub(crate) fn new(scene: Scene<'_>) -> Self {
        let Scene { site, robot, storey } = scene;
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
        let mut archive = ArchiveBuffer::zeroed(GridWriter::len_of(n_cells));
        let mut writer = GridWriter::new(archive.bytes_mut(), &head);
        let whole = storey.whole();
        for space in &storey.spaces {
            // From the largest to the smallest: where they overlap the smaller wins.
            for cells in whole.clip(&space.runs, whole.width()) {
                writer.layers().space[cells].fill(space.space as u16 + 1);
            }
        }
        let mut floor_plans = FloorPlans::default();
        let mut all = Vec::new();
        storey.dependents.iter().filter_map(|n| n.floor_place).for_each(|place| put(&mut all, place, true));
        let complete = floor_plans.of(site, robot, storey, &all);
        let facts: Vec<u8> =
            outline(storey, complete).cells.iter().map(|&inside| if inside { OUTLINE } else { 0 }).collect();
        Self {
            archive,
            content_hash: 0,
            margins: vec![0; facts.len()],
            facts,
            seen: Seen::default(),
            ground: Ground::new(floor_plans),
            is_blank: false,
            doors: Vec::new(),
            standing: Standing::new(),
            difference: Difference::default(),
            growth: Growth::default(),
        }
    }

    /// The archive of the grid, as drawn last.
    pub(crate) fn archive(&self) -> &[u8] {
        self.archive.bytes()
    }

    /// Its content hash.
    pub(crate) fn content_hash(&self) -> u64 {
        self.content_hash
    }

    /// Hash of everything of the phase that the grid depends on.
    pub(crate) fn input_hash(&self) -> u64 {
        xxh3_64(&self.seen.looks)
    }

    /// What a robot finds at the doors.
    pub(crate) fn doors(&self) -> &[DoorPassageRecord] {
        &self.doors
    }

    /// Finished floor at other levels.
    pub(crate) fn regions(&self) -> &[RegionRecord] {
        &self.ground.regions
    }

    /// Draws the grid of a phase.
    pub(crate) fn draw(&mut self, scene: Scene<'_>, phase: &Phase<'_>) {
        let is_first = self.seen.looks.is_empty();
        let Self { facts, seen, ground, difference, .. } = self;
        if !difference.find(seen, scene, phase) {
            return;
        }
        ground.lay(facts, difference, &seen.finished, (scene, phase), is_first);
        ground.open(facts, difference, (scene, phase), is_first);
        let is_blank = phase.head.plan_time().is_some() && !self.ground.is_any;
        if is_first || is_blank != self.is_blank {
            self.is_blank = is_blank;
            self.difference.cells.clear();
            self.difference.cells.push(scene.storey.whole());
            // While it is blank nobody follows the work.
            self.margins.fill(0);
        }
        if self.difference.cells.is_empty() {
            return;
        }
        join_rects(&mut self.difference.cells);
        for index in 0..self.difference.cells.len() {
            let rect = self.difference.cells[index];
            self.paint(scene, phase, &rect);
        }
        if is_blank {
            cell_flags::fill_without_floor(&mut self.writer().layers());
        } else {
            self.derive(scene);
        }
        self.look_at_doors(scene, phase);
        self.content_hash = self.writer().seal();
    }

    fn writer(&mut self) -> GridWriter<'_> {
        GridWriter::resume(self.archive.bytes_mut(), self.facts.len())
    }

    /// Writes facts, class, floor and planning of a rectangle from the runs of everything that meets it.
    fn paint(&mut self, scene: Scene<'_>, phase: &Phase<'_>, rect: &CellRect) {
        let Scene { site, robot, storey } = scene;
        let width = storey.spec.width as usize;
        let Self { archive, facts, ground, difference, .. } = self;
        let mut writer = GridWriter::resume(archive.bytes_mut(), facts.len());
        let GridLayers { class, floor, planning, .. } = writer.layers();
        for row in rect.rows(width) {
            class[row.clone()].fill(Class::None.id());
            facts[row].iter_mut().for_each(|f| *f = *f & (GROUND | OUTLINE) | (*f & GROUND) << 1);
        }
        let meets = |other: Option<CellRect>| other.is_some_and(|other| other.meets(rect));
        for (passage, _) in
            storey.passages.iter().zip(&ground.open_passages).filter(|(p, open)| **open && meets(p.rect))
        {
            let cells = rect.clip(&passage.runs, width);
            cells.for_each(|cells| facts[cells].iter_mut().for_each(|f| *f |= FLOOR));
        }
        let is_hung = |door: &Option<DoorAt>| door.as_ref().is_none_or(|d| d.is_hung(phase));
        for obstacle in storey.obstacles.iter().filter(|o| meets(o.rect)) {
            let look = Look::of(phase.effective(obstacle.element as usize));
            // A door stands with the wall that it hangs in.
            if !look.is_obstacle() || !is_hung(&obstacle.door) {
                continue;
            }
            // A door that is being hung or taken down is as good as closed.
            let stands_here = obstacle.door.as_ref().is_none_or(|d| d.stands_here);
            let is_open_door = obstacle.class == Class::Door
                && stands_here
                && obstacle.door.as_ref().is_none_or(|d| d.can_pass(phase, robot) && look == Look::Built);
            let set = match (is_open_door, obstacle.class == Class::Door) {
                (true, _) => DOOR,
                (false, true) => DOOR | OCCUPIED,
                (false, false) => OCCUPIED,
            };
            // What is drawn over a door is no door.
            let keep = if set & DOOR == 0 { !DOOR } else { u8::MAX };
            for cells in rect.clip(&obstacle.runs, width) {
                class[cells.clone()].fill(obstacle.class.id());
                // A leaf that stands open, or a threshold, is no floor: beside its passage a door is free where floor is.
                // A door of another level is in the way where floor is.
                let is_set = |f: u8| stands_here && !is_open_door || f & FLOOR != 0;
                facts[cells].iter_mut().for_each(|f| *f = *f & keep | if is_set(*f) { set } else { 0 });
            }
            for door in obstacle.door.iter().filter(|_| is_open_door) {
                let passage = rect.clip(&door.passage_runs, width);
                passage.for_each(|cells| facts[cells].iter_mut().for_each(|f| *f |= DOOR));
            }
        }
        let mut set_runs = |runs: &[grid::Run], fact: u8| {
            rect.clip(runs, width).for_each(|cells| facts[cells].iter_mut().for_each(|f| *f |= fact));
        };
        for structure in storey.lidar.iter().filter(|l| meets(l.rect)) {
            if Look::of(phase.effective(structure.element as usize)) == Look::Built {
                set_runs(&structure.runs, STRUCTURE);
            }
        }
        for space in storey.spaces.iter().filter(|s| meets(s.rect) && phase.is_blocked(s.space as usize)) {
            set_runs(&space.runs, BLOCKED);
        }
        for &place in &difference.worked_on {
            set_runs(storey.overhead_runs(site, place), WORK);
        }
        let floor_value = match storey.floor_kind {
            FloorKind::Built | FloorKind::Missing => 1,
            FloorKind::AssumedFromSpaces | FloorKind::AssumedFromEnclosure => 2,
        };
        for row in rect.rows(width) {
            let cells = facts[row.clone()].iter().zip(&mut floor[row.clone()]).zip(&mut planning[row]);
            for ((&facts, floor), planning) in cells {
                *floor = if facts & FLOOR != 0 { floor_value } else { 0 };
                *planning = PLANNING[usize::from(facts)];
            }
        }
    }

    /// Computes keep-out and localization as far as the difference can reach.
    fn derive(&mut self, scene: Scene<'_>) {
        let Self { archive, facts, margins: marked, difference, growth, .. } = self;
        let mut writer = GridWriter::resume(archive.bytes_mut(), facts.len());
        let GridLayers { keepout: layer, localization: seen, .. } = writer.layers();
        let (margins, whole) = (scene.margins(), scene.storey.whole());
        let Difference { cells, work, working, windows, .. } = difference;
        let mut each = |reach: u32, wanted: &dyn Fn(&CellRect) -> bool, compute: &mut dyn FnMut(&CellRect)| {
            windows.clear();
            windows.extend(cells.iter().map(|rect| rect.grown(reach, &whole)).filter(|rect| wanted(rect)));
            join_rects(windows);
            windows.iter().flat_map(|rect| rect.tiles(SIDE)).for_each(|window| compute(&window));
        };
        let mut keepout = Keepout { facts, margins: marked, layer, whole };
        each(margins.edge_reach(), &|_| true, &mut |window| keepout.edges(growth, margins, window));
        let is_near_work = |rect: &CellRect| {
            let around = rect.grown(margins.work_reach(), &whole);
            work.iter().chain(&*working).any(|work| work.meets(&around))
        };
        each(margins.work_reach(), &is_near_work, &mut |window| keepout.work(growth, margins, window));
        let gap_cells = gap::most_cells(scene.storey.spec.cell_tenths);
        let mut localization = Localization { facts, layer: seen, whole, gap_cells };
        each(localization.reach(), &|_| true, &mut |window| localization.draw(growth, window));
    }

    /// What a robot finds at the doors around which anything differs.
    fn look_at_doors(&mut self, scene: Scene<'_>, phase: &Phase<'_>) {
        let Scene { robot, storey, .. } = scene;
        let Self { archive, facts, doors, standing, difference, .. } = self;
        let mut writer = GridWriter::resume(archive.bytes_mut(), facts.len());
        let GridLayers { class, floor, .. } = writer.layers();
        let layers = DoorLayers { class, floor };
        let obstacles = storey.obstacles.iter().filter(|o| o.class == Class::Door);
        let at_doors = obstacles.filter_map(|o| Some((o.element, o.door.as_ref().filter(|d| d.stands_here)?)));
        for (place, (element, door)) in at_doors.enumerate() {
            let around = door.around.filter(|_| place < doors.len());
            if around.is_some_and(|around| !difference.cells.iter().any(|rect| rect.meets(&around))) {
                continue;
            }
            let look = Look::of(phase.effective(element as usize));
            let record = door_passage(door, phase, robot, storey, look, layers, standing);
            match doors.get_mut(place) {
                Some(door) => *door = record,
                None => doors.push(record),
            }
        }
    }
}
