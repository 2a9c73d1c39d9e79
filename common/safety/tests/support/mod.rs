//! A floor of 0.1 m cells with boxes on it, and the layer of a robot with rules there.
#![allow(dead_code, reason = "every test file uses a part of this")]

#[path = "../../../messages/tests/support/box_part.rs"]
mod box_part;

use grid::Class;
use messages::*;
use safety::{NO_SOURCE, SafetyInput, SafetyLayer};

/// Side of a cell in metres.
pub(crate) const CELL_M: f64 = 0.1;

/// Metres to tenths of a millimetre.
pub(crate) fn t(m: f64) -> i32 {
    frames::tenths(m).unwrap()
}

/// Height of the ground at a place in plan; `None` where there is none.
pub(crate) type Heights = fn([f64; 2]) -> Option<f64>;

/// A floor from the origin, its boxes, and how it is mapped.
pub(crate) struct Floor {
    pub(crate) site: SiteBuilder,
    pub(crate) rules: SafetyRules,
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// Height of the storey.
    pub(crate) floor_z_m: f64,
    pub(crate) kind: FloorKind,
    pub(crate) heights: Heights,
    /// The map has a height for each cell.
    pub(crate) has_heights: bool,
    boxes: Vec<[[f64; 3]; 2]>,
    /// Elements that are worked on.
    pub(crate) in_progress: Vec<usize>,
}

/// A layer with what it was made from.
pub(crate) struct Drawn {
    pub(crate) layer: SafetyLayer,
    pub(crate) width: usize,
    /// Cells on which nothing stands.
    pub(crate) open: Vec<bool>,
}

impl Floor {
    /// A level floor of so many cells at 0 m.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        Self {
            site: SiteBuilder::default(),
            rules: SafetyRules::default(),
            size,
            floor_z_m: 0.0,
            kind: FloorKind::Built,
            heights: |_| Some(0.0),
            has_heights: false,
            boxes: Vec::new(),
            in_progress: Vec::new(),
        }
    }

    /// The same on ground of heights, outdoors or as part of a storey.
    pub(crate) fn on_ground(size: [u32; 2], kind: FloorKind, floor_z_m: f64, heights: Heights) -> Self {
        Self { heights, has_heights: true, kind, floor_z_m, ..Self::new(size) }
    }

    pub(crate) fn rule(mut self, subject: SafetySubject<'_>, distance_m: f64, speed_m_s: Option<f64>) -> Self {
        self.rules.add(subject, Some(distance_m), speed_m_s).unwrap();
        self
    }

    /// Adds a box, in metres.
    pub(crate) fn add(&mut self, class: Class, flags: u32, corners: [[f64; 3]; 2]) -> usize {
        let [min, max] = corners.map(|c| c.map(t));
        let first_part = box_part::add_box_part(&mut self.site, min, max);
        let element = box_part::box_element(class, first_part, [min, max]);
        self.site.elements.push(ElementRecord { flags, ..element });
        self.boxes.push(corners);
        self.boxes.len() - 1
    }

    /// Adds a door 0.1 m thick in a wall along x, that swings to +y about its left jamb.
    pub(crate) fn door(&mut self, [from, to]: [f64; 2], y: f64, z: f64, map_storey: u32) -> usize {
        let element = self.add(Class::Door, 0, [[from, y, z], [to, y + 0.1, z + 2.1]]);
        let (middle, half) = ((from + to) / 2.0, (to - from) / 2.0);
        let operation = self.site.texts.add("SINGLE_SWING_LEFT");
        self.site.elements[element].door = self.site.doors.len() as u32;
        self.site.doors.push(DoorRecord {
            element: element as u32,
            opening: NONE,
            spaces: [NONE; 2],
            beside: [NONE; 2],
            operation,
            opens: DoorCapability::Swing as u32,
            clear_width_from: ClearWidth::Assumed.into(),
            overall_width_m: to - from,
            overall_height_m: 2.1,
            clear_width_m: to - from,
            passage: BoxRecord {
                centre: [middle * 1e4, (y + 0.05) * 1e4],
                axis: [1.0, 0.0],
                half: [half * 1e4, 500.0],
            },
            hanging: DoorHanging { along: [1.0, 0.0], towards: [0.0, 1.0], ..DoorHanging::default() },
            map_storey,
            reserved: 0,
        });
        element
    }

    /// Middle of a cell in metres.
    pub(crate) fn middle(&self, cell: usize) -> [f64; 2] {
        let width = self.size[0] as usize;
        [cell % width, cell / width].map(|k| (k as f64 + 0.5) * CELL_M)
    }

    /// True if a box reaches into a cell, grown by so many cells, in plan.
    pub(crate) fn overlaps(&self, element: usize, cell: usize, grown: f64) -> bool {
        self.overlaps_at(element, self.middle(cell), [0.5 + grown; 2])
    }

    /// True if a box reaches in plan into a rectangle around a place, with half its sides in cells.
    pub(crate) fn overlaps_at(&self, element: usize, middle: [f64; 2], half_cells: [f64; 2]) -> bool {
        let [low, high] = self.boxes[element];
        let half = half_cells.map(|cells| cells * CELL_M - 1e-6);
        (0..2).all(|k| low[k] < middle[k] + half[k] && middle[k] - half[k] < high[k])
    }

    /// Number of elements.
    pub(crate) fn site_len(&self) -> usize {
        self.boxes.len()
    }

    /// Lower and upper end of a box.
    pub(crate) fn z_of(&self, element: usize) -> [f64; 2] {
        self.boxes[element].map(|c| c[2])
    }

    /// Heights above the ground between which something is in the robot's way.
    pub(crate) fn slab_m() -> [f64; 2] {
        let robot = RobotProfile::DEFAULT;
        [robot.step_height_m, robot.height_m + robot.clearance_above_m]
    }

    /// True if a box stands in the way in a cell with ground at a height.
    pub(crate) fn is_in_the_way(&self, element: usize, cell: usize) -> bool {
        let Some(ground) = (self.heights)(self.middle(cell)) else { return false };
        let [low, high] = Self::slab_m();
        let [bottom, top] = self.z_of(element);
        self.overlaps(element, cell, 0.0) && bottom < ground + high && ground + low < top
    }

    fn grid(&self) -> ArchiveBuffer {
        let [low, high] = Self::slab_m().map(t);
        let head = GridHead {
            cell_tenths: t(CELL_M),
            width: self.size[0],
            height: self.size[1],
            floor_z_tenths: t(self.floor_z_m),
            slab_tenths: [low, high],
            floor: self.kind.into(),
            ..GridHead::EMPTY
        };
        let n = (self.size[0] * self.size[1]) as usize;
        let length = if self.has_heights { GridWriter::len_with_heights(n) } else { GridWriter::len_of(n) };
        let mut buffer = ArchiveBuffer::zeroed(length);
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        for cell in 0..n {
            let ground = (self.heights)(self.middle(cell));
            let is_blocked = (0..self.boxes.len()).any(|element| self.is_in_the_way(element, cell));
            layers.planning[cell] = if is_blocked { 100 } else { ground.map_or(-1, |_| 0) };
            layers.class[cell] = if is_blocked { Class::Wall.id() } else { Class::None.id() };
            layers.floor[cell] = u8::from(ground.is_some());
            if self.has_heights {
                layers.elevation[cell] = ground.map_or(NO_HEIGHT, t);
                layers.slope[cell] = if ground.is_some() { 0 } else { NO_SLOPE };
            }
        }
        writer.seal();
        buffer
    }

    /// The layer; the site is used up.
    pub(crate) fn drawn(&mut self) -> Drawn {
        let mut builder = std::mem::take(&mut self.site);
        let kind = self.kind.into();
        let bounds_tenths = [0, 0, self.size[0] as i32 * t(CELL_M), self.size[1] as i32 * t(CELL_M)];
        let name = builder.texts.add("Storey");
        let storey = MapStoreyRecord {
            global_id: Text::default(),
            name,
            floor_z_tenths: t(self.floor_z_m),
            floor: kind,
            bounds_tenths,
        };
        builder.map_storeys.insert(0, storey);
        let site = builder.finish();
        let site = Site::open(site.bytes()).unwrap();
        let mut states = ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), 0);
        for &element in &self.in_progress {
            states.set_element(element, ElementState::InProgress, ElementState::InProgress);
        }
        let states = states.finish();
        let schedule_state = ScheduleState::open(states.bytes()).unwrap();
        let grid = self.grid();
        let grid = Grid::open(grid.bytes()).unwrap();
        let head = GridsHead {
            site_hash: site.content_hash(),
            schedule_state_hash: schedule_state.content_hash(),
            plan_time_s: ScheduleStateHead::NO_TIME,
            robot: RobotProfile::DEFAULT,
        };
        let index = GridsBuilder {
            safety_rules: self.rules.records(),
            safety_materials: self.rules.materials(),
            ..GridsBuilder::of(head, &[], "test")
        };
        let index = index.finish();
        let index = Grids::open(index.bytes()).unwrap();
        let input = SafetyInput { site: &site, schedule_state: &schedule_state, index: &index };
        let layer = SafetyLayer::of(input, &grid).unwrap();
        Drawn { layer, width: self.size[0] as usize, open: grid.planning.iter().map(|p| *p == 0).collect() }
    }
}

impl Drawn {
    /// The cell at a place in plan.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> usize {
        let [column, row] = [x, y].map(|c| (c / CELL_M).floor() as usize);
        row * self.width + column
    }

    /// The element that the cost of a cell comes from.
    pub(crate) fn cost_element(&self, cell: usize) -> Option<usize> {
        self.source(self.layer.cost_source[cell])
    }

    /// The element that limits the speed in a cell.
    pub(crate) fn speed_element(&self, cell: usize) -> Option<usize> {
        self.source(self.layer.speed_source[cell])
    }

    fn source(&self, source: u32) -> Option<usize> {
        (source != NO_SOURCE).then(|| self.layer.sources[source as usize].element as usize)
    }
}
