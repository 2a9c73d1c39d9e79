//! The archives of a drawn building.

#[path = "../../../../messages/tests/support/box_part.rs"]
mod box_part;

use super::{CHARACTER, Drawing, House, STOREY, bounds, letter_of};
use box_part::{add_box_part, box_element};
use bytemuck::Zeroable;
use geometry::{FillRule, MultiPolygon, union};
use grid::Class;
use messages::*;

/// What a planner reads.
pub(crate) struct Archives {
    pub(crate) site: ArchiveBuffer,
    pub(crate) schedule_state: ArchiveBuffer,
    pub(crate) index: ArchiveBuffer,
    pub(crate) grids: Vec<ArchiveBuffer>,
    pub(crate) names: Vec<char>,
}

/// A time at which schedule states are.
pub(crate) const NOW_S: i64 = 1_000_000;

impl Archives {
    pub(crate) fn of(house: &House) -> Self {
        let names = house.space_names();
        let mut builder = Builder { house, names: &names, site: SiteBuilder::default(), walls: Vec::new() };
        builder.add_storeys();
        let site = builder.site.finish();
        let view = Site::open(site.bytes()).unwrap();
        let schedule_state = schedule_state(house, &names, &view, &builder.walls);
        let grids: Vec<ArchiveBuffer> = (0..house.storeys.len()).map(|storey| grid(house, &names, storey)).collect();
        let slots: Vec<GridSlotRecord> = grids
            .iter()
            .zip(0..)
            .map(|(grid, map_storey)| {
                let content_hash = Grid::open(grid.bytes()).unwrap().content_hash();
                GridSlotRecord { map_storey, cell_tenths: house.cell_tenths, content_hash }
            })
            .collect();
        let head = GridsHead {
            site_hash: view.content_hash(),
            schedule_state_hash: ScheduleState::open(schedule_state.bytes()).unwrap().content_hash(),
            plan_time_s: NOW_S,
            robot: house.robot,
        };
        let doors: Vec<DoorPassageRecord> = (0..view.doors.len()).map(|door| passage(house, &view, door)).collect();
        let index = GridsBuilder {
            head,
            slots: &slots,
            robot_name: "drawn",
            robot_footprint_m: &[],
            doors: &doors,
            regions: &[],
            safety_rules: house.safety.records(),
            safety_materials: house.safety.materials(),
        }
        .finish();
        Self { site, schedule_state, index, grids, names }
    }
}

struct Builder<'a> {
    house: &'a House,
    names: &'a [char],
    site: SiteBuilder,
    /// Elements of the walls that are digits, and of the ways up.
    walls: Vec<(char, usize)>,
}

impl Builder<'_> {
    fn add_storeys(&mut self) {
        for (drawing, storey) in self.house.storeys.iter().zip(0..) {
            let name = self.site.texts.add(&format!("Storey {storey}"));
            let [x, y] = [drawing.width - 2, drawing.rows.len() - 2].map(|n| n as i32 * CHARACTER);
            self.site.map_storeys.push(MapStoreyRecord {
                global_id: name,
                name,
                floor_z_tenths: storey * STOREY,
                floor: FloorKind::Built.into(),
                bounds_tenths: [0, 0, x, y],
            });
            self.add_elements(drawing, storey);
        }
        for (character, kind, predefined) in [
            ('S', "IfcStair", ""),
            ('R', "IfcRamp", ""),
            ('L', "IfcTransportElement", "ELEVATOR"),
            ('E', "IfcTransportElement", "ESCALATOR"),
        ] {
            self.add_way_up(character, kind, predefined);
        }
        for &name in self.names {
            self.add_space(name);
        }
    }

    fn add_elements(&mut self, drawing: &Drawing, storey: i32) {
        let floor = storey * STOREY;
        for character in ['#', '0', '1', '2', '3', '4', '5', '6', '7', '8', '9', 'F'] {
            let squares = drawing.squares(|c| c == character);
            if !squares.is_empty() {
                let (class, height) = if character == 'F' { (Class::Furniture, 8_000) } else { (Class::Wall, 25_000) };
                let element = self.add_element(&format!("{character}-{storey}"), class);
                squares.into_iter().for_each(|s| self.add_box(bounds(&[s]), [floor, floor + height]));
                if character.is_ascii_digit() {
                    self.walls.push((character, element));
                }
            }
        }
        for character in ['D', 'X'] {
            for group in drawing.groups(character) {
                self.add_door(drawing, &group, character, floor);
            }
        }
    }

    fn add_element(&mut self, global_id: &str, class: Class) -> usize {
        let b = &mut self.site;
        let global_id = b.texts.add(global_id);
        b.elements.push(ElementRecord {
            global_id,
            name: global_id,
            n_parts: 0,
            ..box_element(class, b.parts.len() as u32, [[i32::MAX; 3], [i32::MIN; 3]])
        });
        b.elements.len() - 1
    }

    /// A box of the element that was added last.
    fn add_box(&mut self, [low, high]: [[i32; 2]; 2], [bottom, top]: [i32; 2]) {
        let b = &mut self.site;
        let (min, max) = ([low[0], low[1], bottom], [high[0], high[1], top]);
        add_box_part(b, min, max);
        let element = b.elements.last_mut().unwrap();
        element.n_parts += 1;
        for k in 0..3 {
            element.min_tenths[k] = element.min_tenths[k].min(min[k]);
            element.max_tenths[k] = element.max_tenths[k].max(max[k]);
        }
    }

    fn add_door(&mut self, drawing: &Drawing, group: &[[usize; 2]], character: char, floor: i32) {
        let number = self.site.doors.len();
        let element = self.add_element(&format!("door-{number}"), Class::Door);
        let [low, high] = bounds(group);
        self.add_box([low, high], [floor, floor + 21_000]);
        let [x, y] = group[0];
        let is_along_x = drawing.at([x - 1, y]) == '#';
        let half = [0, 1].map(|k| f64::from(high[k] - low[k]) / 2.0);
        let sides = if is_along_x { [[x, y - 1], [x, y + 1]] } else { [[x - 1, y], [x + 1, y]] };
        let spaces = drawing.space_of_squares();
        let place = |[x, y]: [usize; 2]| spaces[y][x].map_or(NONE, |name| self.place(name) as u32);
        let spaces = sides.map(place);
        let width_m = 2.0 * half[usize::from(!is_along_x)] / f64::from(frames::TENTHS_PER_M);
        let operation = self.site.texts.add(if character == 'X' { "REVOLVING" } else { "SINGLE_SWING_LEFT" });
        self.site.elements[element].door = number as u32;
        self.site.doors.push(DoorRecord {
            element: element as u32,
            opening: NONE,
            spaces,
            operation,
            opens: if character == 'X' { DoorCapability::Revolving } else { DoorCapability::Swing } as u32,
            clear_width_from: ClearWidth::Assumed.into(),
            overall_width_m: width_m,
            overall_height_m: 2.1,
            clear_width_m: width_m - 0.1,
            passage: BoxRecord {
                centre: [0, 1].map(|k| f64::from(low[k] + high[k]) / 2.0),
                axis: if is_along_x { [1.0, 0.0] } else { [0.0, 1.0] },
                half: if is_along_x { half } else { [half[1], half[0]] },
            },
            hanging: DoorHanging::default(),
            beside: [NONE; 2],
            map_storey: (floor / STOREY) as u32,
            reserved: 0,
        });
    }

    /// A box on each storey that shows it; a lift is one from the lowest to the highest.
    fn add_way_up(&mut self, character: char, kind: &str, predefined: &str) {
        let drawings = self.house.storeys.iter().zip(0..);
        let shown = drawings.map(|(drawing, storey)| (drawing.squares(|c| c == character), storey));
        let shown: Vec<(Vec<[usize; 2]>, i32)> = shown.filter(|(squares, _)| !squares.is_empty()).collect();
        let (Some((_, lowest)), Some((_, highest))) = (shown.first().cloned(), shown.last().cloned()) else { return };
        let class = if character == 'S' { Class::Stair } else { Class::Other };
        let element = self.add_element(&format!("{kind}-{character}"), class);
        self.walls.push((character, element));
        let supertypes = self.site.texts.add_list([kind]);
        let [kind, predefined] = [kind, predefined].map(|text| self.site.texts.add(text));
        let record = &mut self.site.elements[element];
        (record.ifc_type, record.supertypes, record.predefined_type) = (kind, supertypes, predefined);
        record.flags = element_flags::VERTICAL;
        for (squares, storey) in shown {
            let floor = storey * STOREY;
            let z = if character == 'L' {
                [lowest * STOREY, highest * STOREY + 25_000]
            } else {
                [floor - 1_000, floor + 1_000]
            };
            self.add_box(bounds(&squares), z);
        }
    }

    fn place(&self, name: char) -> usize {
        self.names.iter().position(|n| *n == name).unwrap()
    }

    fn add_space(&mut self, name: char) {
        let drawings = self.house.storeys.iter().zip(0u32..);
        let drawn = self.house.overlaid.get(&name).copied().unwrap_or(name);
        let plans = drawings.map(|(drawing, storey)| (plan_of(drawing, drawn), storey));
        let (plan, map_storey) = plans.into_iter().find(|(plan, _)| !plan.is_empty()).unwrap_or_default();
        let b = &mut self.site;
        let [global_id, name_text] = [format!("space-{name}"), name.to_string()].map(|t| b.texts.add(&t));
        let first_ring = b.rings.len() as u32;
        for ring in plan.rings() {
            b.rings.push(RingRecord { first_point: b.points.len() as u32, n_points: ring.len() as u32 });
            b.points.extend(ring);
        }
        let centroid_m = plan.centroid().map_or([0.0; 2], |c| c.map(|c| c / f64::from(frames::TENTHS_PER_M)));
        let mut record = SpaceRecord {
            global_id,
            name: name_text,
            area_m2: plan.area_m2(),
            centroid_m,
            first_ring,
            n_rings: b.rings.len() as u32 - first_ring,
            floor_z_tenths: map_storey as i32 * STOREY,
            height_tenths: 25_000,
            map_storey,
            storey: NONE,
            ..Zeroable::zeroed()
        };
        if let Some(change) = self.house.spaces.get(&name) {
            change(&mut record);
        }
        b.spaces.push(record);
    }
}

/// The squares of a space, joined.
fn plan_of(drawing: &Drawing, name: char) -> MultiPolygon {
    let spaces = drawing.space_of_squares();
    let mut rings = Vec::new();
    for (row, y) in spaces.iter().zip(0..) {
        for (space, x) in row.iter().zip(0..) {
            if *space == Some(name) {
                let [[x0, y0], [x1, y1]] = bounds(&[[x, y]]);
                rings.push(vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]);
            }
        }
    }
    union(&rings, FillRule::NonZero)
}

fn schedule_state(house: &House, names: &[char], site: &Site<'_>, walls: &[(char, usize)]) -> ArchiveBuffer {
    let mut schedule_state =
        ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len());
    schedule_state.head.plan_time_s = NOW_S;
    schedule_state.schedule = vec![ElementScheduleRecord::NOTHING; site.elements.len()];
    for (digit, element) in walls {
        if house.absent.contains(digit) {
            schedule_state.set_element(*element, ElementState::NotStarted, ElementState::NotStarted);
        }
        if let Some(&finish_s) = house.finished.get(digit) {
            schedule_state.schedule[*element].finish_s = finish_s;
        }
    }
    for (place, name) in names.iter().enumerate() {
        if let Some(why) = house.blocked.get(name) {
            schedule_state.block_space(place, &[why]);
        }
        if let Some(&at_s) = house.closing.get(name) {
            schedule_state.spaces[place].closes_at_s = at_s;
        }
    }
    schedule_state.finish()
}

/// What the robot finds at a door of this width and operation.
fn passage(house: &House, site: &Site<'_>, door: usize) -> DoorPassageRecord {
    let record = &site.doors[door];
    let passage = if house.robot.opens & record.opens == 0 {
        DoorPassage::CannotOpen
    } else if record.clear_width_m + 1e-6 < 2.0 * house.robot.radius_m + house.robot.door_margin_m {
        DoorPassage::TooNarrow
    } else {
        DoorPassage::Passable
    };
    let map_storey = (site.elements[record.element as usize].min_tenths[2] / STOREY) as u32;
    let (door, width_in_map_m) = (door as u32, record.overall_width_m);
    DoorPassageRecord {
        door,
        map_storey,
        passage: passage.into(),
        sides_with_floor: 2,
        width_in_map_m,
        clear_width_m: record.clear_width_m,
        way: record.passage,
        reasons: if passage.is_closed() { passage.bit() } else { 0 },
        obstacle: NONE,
        ..bytemuck::Zeroable::zeroed()
    }
}

fn grid(house: &House, names: &[char], storey: usize) -> ArchiveBuffer {
    let drawing = &house.storeys[storey];
    let (cell, floor_z_tenths) = (house.cell_tenths, storey as i32 * STOREY);
    let cells = (CHARACTER / cell) as usize;
    let head = GridHead {
        cell_tenths: cell,
        first_cell: [-(cells as i32); 2],
        width: (drawing.width * cells) as u32,
        height: (drawing.rows.len() * cells) as u32,
        map_storey: storey as u32,
        floor_z_tenths,
        slab_tenths: [floor_z_tenths + 500, floor_z_tenths + 12_500],
        floor: FloorKind::Built.into(),
        ..GridHead::EMPTY
    };
    let spaces = drawing.space_of_squares();
    let closed = closed_doors(house, drawing);
    let n_cells = head.spec().n_cells();
    let length =
        if house.relief.is_some() { GridWriter::len_with_heights(n_cells) } else { GridWriter::len_of(n_cells) };
    let mut buffer = ArchiveBuffer::zeroed(length);
    let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
    let layers = writer.layers();
    layers.localization.fill(-1);
    if let Some(relief) = house.relief {
        for index in 0..n_cells {
            let middle_m = head.spec().centre_of(head.spec().cell_of(index)).coordinates_m();
            let rise = |k: usize| {
                let beside = |by: f64| [0, 1].map(|j| middle_m[j] + if j == k { by } else { 0.0 });
                (relief(beside(0.01)) - relief(beside(-0.01))) / 0.02
            };
            layers.elevation[index] = floor_z_tenths + (relief(middle_m) * 10_000.0).round() as i32;
            layers.slope[index] = (libm::atan(libm::hypot(rise(0), rise(1))) * 1_000.0).round() as u16;
        }
    }
    for index in 0..head.spec().n_cells() {
        let at = head.spec().cell_of(index);
        let [x, y] = [at.column, at.row].map(|c| c as usize / cells);
        let character = drawing.at([x, y]);
        let space = spaces[y][x];
        let is_blocked = space.is_some_and(|name| house.blocked.contains_key(&name));
        let (class, planning) = match character {
            '#' => (Class::Wall, 100),
            '0'..='9' if house.absent.contains(&character) => (Class::None, 0),
            '0'..='9' => (Class::Wall, 100),
            'F' => (Class::Furniture, 100),
            'D' | 'X' => (Class::Door, if closed.contains(&[x, y]) { 100 } else { 0 }),
            'S' => (Class::Stair, 100),
            'R' => (Class::Ramp, 100),
            'L' | 'E' => (Class::Other, 100),
            ' ' | 'A'..='Z' => (Class::None, -1),
            _ => (Class::None, 0),
        };
        let is_void = letter_of(character).is_some() && character.is_ascii_uppercase();
        layers.class[index] = class.id();
        layers.planning[index] = if is_blocked && planning == 0 { 100 } else { planning };
        layers.keepout[index] = if is_blocked || is_void || character == '~' { 100 } else { -1 };
        layers.floor[index] = u8::from(planning != -1);
        layers.space[index] = space.map_or(0, |name| names.iter().position(|n| *n == name).unwrap() as u16 + 1);
    }
    writer.seal();
    buffer
}

/// Squares of doors that this robot cannot pass.
fn closed_doors(house: &House, drawing: &Drawing) -> Vec<[usize; 2]> {
    let opens = |operation: DoorCapability| house.robot.opens & operation as u32 != 0;
    let mut closed = if opens(DoorCapability::Revolving) { Vec::new() } else { drawing.squares(|c| c == 'X') };
    let needed_m = 2.0 * house.robot.radius_m + house.robot.door_margin_m;
    for group in drawing.groups('D') {
        let [low, high] = bounds(&group);
        let width_m = frames::metres((high[0] - low[0]).max(high[1] - low[1]));
        if !opens(DoorCapability::Swing) || width_m - 0.1 + 1e-6 < needed_m {
            closed.extend(group);
        }
    }
    closed
}
