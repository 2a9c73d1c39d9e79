//! A small house, and how it is drawn.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]
#![allow(dead_code, reason = "every test file uses a part of this")]

#[path = "../../../../messages/tests/support/box_part.rs"]
pub(crate) mod box_part;

use box_part::{add_box_part, add_part, box_element};
use frames::{Map, Point2};
use grid::Class;
use messages::*;
use raster::Rasterizer;

/// Metres to tenths of a millimetre.
pub(crate) fn t(m: f64) -> i32 {
    frames::tenths(m).unwrap()
}

/// A building to be, and how it is drawn.
pub(crate) struct House {
    pub(crate) builder: SiteBuilder,
    pub(crate) floor: FloorKind,
    pub(crate) resolution_m: f64,
    /// Lower left and upper right corner of the storey.
    pub(crate) bounds_m: [f64; 4],
}

impl House {
    pub(crate) fn empty() -> Self {
        let bounds_m = [-1.0, -2.0, 5.0, 4.0];
        Self { builder: SiteBuilder::default(), floor: FloorKind::Built, resolution_m: 0.1, bounds_m }
    }

    pub(crate) fn new() -> Self {
        let mut house = Self::empty();
        house.add(Class::Wall, [-0.2, -0.2, 0.0], [1.5, 0.0, 2.5]);
        house.add(Class::Wall, [2.4, -0.2, 0.0], [4.2, 0.0, 2.5]);
        house.add(Class::Wall, [-0.2, 0.0, 0.0], [0.0, 3.2, 2.5]);
        house.add(Class::Wall, [0.0, 3.0, 0.0], [4.2, 3.2, 2.5]);
        house.slab([-0.2, -0.2], [4.2, 3.2], 0.0);
        house.add(Class::Wall, [4.0, 0.0, 0.0], [4.2, 3.0, 2.5]);
        house
    }

    pub(crate) fn add(&mut self, class: Class, min: [f64; 3], max: [f64; 3]) -> usize {
        let (min, max) = (min.map(t), max.map(t));
        let b = &mut self.builder;
        let first_part = add_box_part(b, min, max);
        b.elements.push(box_element(class, first_part, [min, max]));
        b.elements.len() - 1
    }

    pub(crate) fn slab(&mut self, min: [f64; 2], max: [f64; 2], top: f64) -> usize {
        let index = self.add(Class::Slab, [min[0], min[1], top - 0.2], [max[0], max[1], top]);
        let element = &mut self.builder.elements[index];
        (element.flags, element.ground) = (element_flags::FLOOR, GroundClass::Floor.into());
        index
    }

    /// Terrain of the site itself: a sheet over a rectangle that rises along x from one height to another.
    pub(crate) fn terrain(&mut self, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], [from, to]: [f64; 2]) {
        let b = &mut self.builder;
        let corners = [[x0, y0, from], [x1, y0, to], [x1, y1, to], [x0, y1, from]];
        let first_part = add_part(b, &corners.map(|c| c.map(t)), &[[0, 1, 2], [0, 2, 3]], false);
        b.terrains.push(TerrainRecord {
            first_part,
            n_parts: 1,
            ground: GroundClass::Terrain.into(),
            min_tenths: [x0, y0, from.min(to)].map(t),
            max_tenths: [x1, y1, from.max(to)].map(t),
            ..bytemuck::Zeroable::zeroed()
        });
    }

    /// A slab 0.2 m thick that rises along x from one height to another.
    pub(crate) fn ramp(&mut self, min: [f64; 2], max: [f64; 2], [from, to]: [f64; 2]) -> usize {
        let (low, high) = (from.min(to), from.max(to));
        let index = self.add(Class::Ramp, [min[0], min[1], low - 0.2], [max[0], max[1], high]);
        let element = &mut self.builder.elements[index];
        (element.flags, element.ground) = (element_flags::FLOOR, GroundClass::Ramp.into());
        let n = self.builder.vertices.len();
        for vertex in &mut self.builder.vertices[n - 8..] {
            let top = if vertex[0] == t(min[0]) { from } else { to };
            vertex[2] = t(if vertex[2] == t(high) { top } else { top - 0.2 });
        }
        index
    }

    /// A step of a stair: a block whose top is a tread.
    pub(crate) fn tread(&mut self, min: [f64; 3], max: [f64; 3]) -> usize {
        let index = self.add(Class::Stair, min, max);
        self.builder.elements[index].ground = GroundClass::StairTread.into();
        index
    }

    pub(crate) fn door(&mut self, clear_width_m: f64, opens: DoorCapability) -> usize {
        self.leaf([1.5, 2.4], clear_width_m, opens)
    }

    /// Two leaves that share the opening in the south wall, each too narrow for the robot.
    pub(crate) fn leaves(&mut self, opens: [DoorCapability; 2]) -> [usize; 2] {
        let leaves = [self.leaf([1.5, 1.95], 0.35, opens[0]), self.leaf([1.95, 2.4], 0.35, opens[1])];
        self.builder.doors[0].beside = [NONE, 1];
        self.builder.doors[1].beside = [0, NONE];
        leaves
    }

    fn leaf(&mut self, [from, to]: [f64; 2], clear_width_m: f64, opens: DoorCapability) -> usize {
        let element = self.add(Class::Door, [from, -0.15, 0.0], [to, -0.05, 2.1]);
        let (middle, half) = ((from + to) / 2.0, (to - from) / 2.0);
        let passage = BoxRecord { centre: [middle * 1e4, -1_000.0], axis: [1.0, 0.0], half: [half * 1e4, 1_000.0] };
        self.builder.elements[element].door = self.builder.doors.len() as u32;
        self.builder.doors.push(DoorRecord {
            clear_width_from: ClearWidth::Assumed.into(),
            element: element as u32,
            opening: NONE,
            spaces: [NONE; 2],
            beside: [NONE; 2],
            opens: opens as u32,
            overall_width_m: to - from,
            clear_width_m,
            passage,
            ..bytemuck::Zeroable::zeroed()
        });
        element
    }

    pub(crate) fn opening(&mut self, host: usize) {
        self.builder.openings.push(OpeningRecord {
            global_id: Text::default(),
            host: host as u32,
            filling: NONE,
            bottom_z_tenths: 0,
            top_z_tenths: t(2.1),
            plan: BoxRecord { centre: [19_500.0, -1_000.0], axis: [1.0, 0.0], half: [4_500.0, 1_000.0] },
        });
    }

    pub(crate) fn space(&mut self, min: [f64; 2], max: [f64; 2]) {
        let b = &mut self.builder;
        let [x0, y0] = min.map(t);
        let [x1, y1] = max.map(t);
        b.rings.push(RingRecord { first_point: b.points.len() as u32, n_points: 4 });
        b.points.extend([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]);
        b.spaces.push(SpaceRecord {
            first_ring: b.rings.len() as u32 - 1,
            n_rings: 1,
            area_m2: (max[0] - min[0]) * (max[1] - min[1]),
            height_tenths: t(2.5),
            storey: NONE,
            ..bytemuck::Zeroable::zeroed()
        });
    }

    pub(crate) fn map(self) -> Drawn {
        self.map_at(|_| {}, &RobotProfile::DEFAULT)
    }

    /// The site with one map storey.
    pub(crate) fn site(mut self) -> ArchiveBuffer {
        if self.floor == FloorKind::AssumedFromSpaces {
            self.builder.spaces.iter_mut().for_each(|space| space.flags |= space_flags::ASSUMED_FLOOR);
        }
        let name = self.builder.texts.add("Ground");
        self.builder.map_storeys.push(MapStoreyRecord {
            global_id: Text::default(),
            name,
            floor_z_tenths: 0,
            floor: self.floor.into(),
            bounds_tenths: self.bounds_m.map(t),
        });
        self.builder.finish()
    }

    pub(crate) fn map_at(self, change: impl Fn(&mut ScheduleStateBuilder), robot: &RobotProfile) -> Drawn {
        let resolution_m = self.resolution_m;
        let site = self.site();
        let site = Site::open(site.bytes()).unwrap();
        let mut schedule_state =
            ScheduleStateBuilder::everything_built(ContentHash::NONE, site.elements.len(), site.spaces.len());
        change(&mut schedule_state);
        let schedule_state = schedule_state.finish();
        let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
        let mut rasterizer = Rasterizer::new(&site, robot, resolution_m).unwrap();
        rasterizer.draw(&site, &schedule_state);
        let grid = ArchiveBuffer::copy_of(rasterizer.drawn().next().unwrap().archive);
        let index = rasterizer.index(&site, &schedule_state, "test", &[], &SafetyRules::default()).finish();
        Drawn { grid: Checked::new(grid).unwrap(), index }
    }
}

/// The cost of a costmap's cell after Nav2's KeepoutFilter: the cost of the planning map's value in a static layer, then the
/// filter's rule. A mask value of -1 is skipped; any other is written where it is higher, or nothing is known.
pub(crate) fn cost_after_keepout_filter(planning: i8, mask: i8) -> u8 {
    const NO_INFORMATION: u8 = 255;
    let cost = |value: i8| u8::try_from(value).map_or(NO_INFORMATION, |v| (f64::from(v) * 2.54).round() as u8);
    let (old_data, data) = (cost(planning), cost(mask));
    if data != NO_INFORMATION && (data > old_data || old_data == NO_INFORMATION) { data } else { old_data }
}

/// Asserts that Nav2's filter makes no unknown cell free, and forbids what the mask forbids.
pub(crate) fn assert_filter_frees_nothing(grid: &Grid<'_>) {
    for (cell, (&planning, &mask)) in grid.planning.iter().zip(grid.keepout).enumerate() {
        let cost = cost_after_keepout_filter(planning, mask);
        let at = grid.spec().cell_of(cell);
        assert!(planning != -1 || cost >= 254, "unknown cell {at:?} has the cost {cost}");
        assert_eq!(cost == 254, planning == 100 || mask == 100, "cell {at:?} has the cost {cost}");
    }
}

/// A drawn storey.
pub(crate) struct Drawn {
    pub(crate) grid: Checked<payload::Grid>,
    pub(crate) index: ArchiveBuffer,
}

impl Drawn {
    pub(crate) fn grid(&self) -> Grid<'_> {
        self.grid.view()
    }

    pub(crate) fn at(&self, x: f64, y: f64) -> usize {
        let spec = self.grid().spec();
        spec.index(spec.cell_at(Point2::<Map>::new(x, y)).unwrap())
    }

    pub(crate) fn planning(&self, x: f64, y: f64) -> i8 {
        self.grid().planning[self.at(x, y)]
    }

    pub(crate) fn keepout(&self, x: f64, y: f64) -> i8 {
        self.grid().keepout[self.at(x, y)]
    }

    pub(crate) fn localization(&self, x: f64, y: f64) -> i8 {
        self.grid().localization[self.at(x, y)]
    }

    pub(crate) fn passage(&self) -> DoorPassage {
        self.passages()[0]
    }

    pub(crate) fn passages(&self) -> Vec<DoorPassage> {
        self.doors().iter().map(|d| d.passage.get()).collect()
    }

    pub(crate) fn doors(&self) -> &[DoorPassageRecord] {
        Grids::open(self.index.bytes()).unwrap().doors
    }
}
