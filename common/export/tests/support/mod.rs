//! A minimal building that exercises every output: a space, a wall, a door, a stair, a warning.

use bytemuck::Zeroable;
use export::ExportInput;
use frames::UPRIGHT;
use geometry::{Footprint, LazyFootprint, MultiPolygon, Polygon};
use grid::Class;
use messages::*;

/// Archives of the building; views are opened by who reads them.
pub(crate) struct House {
    pub(crate) site: ArchiveBuffer,
    pub(crate) schedule_state: ArchiveBuffer,
    pub(crate) grid: ArchiveBuffer,
    pub(crate) index: ArchiveBuffer,
    pub(crate) mission_plan: ArchiveBuffer,
    pub(crate) footprints: Vec<(u32, LazyFootprint)>,
}

impl House {
    /// Works on the house as an export takes it.
    pub(crate) fn with_input<T>(&self, work: impl FnOnce(&ExportInput<'_>) -> T) -> T {
        let site = Site::open(self.site.bytes()).unwrap();
        let schedule_state = ScheduleState::open(self.schedule_state.bytes()).unwrap();
        let index = Grids::open(self.index.bytes()).unwrap();
        let mission_plan = MissionPlan::open(self.mission_plan.bytes()).unwrap();
        work(&ExportInput {
            site: &site,
            schedule_state: &schedule_state,
            index: &index,
            grids: &[Grid::open(self.grid.bytes()).unwrap()].as_slice(),
            mission_plan: &mission_plan,
            footprints: &[&self.footprints],
            resolution_m: 0.5,
            with_geometry: true,
            exact_footprints: false,
            probability: None,
        })
    }
}

/// A room of 3 x 2 m behind a wall of 0.5 m, on a grid of 0.5 m; the door is too narrow.
pub(crate) fn house() -> House {
    let site = site();
    let view = Site::open(site.bytes()).unwrap();
    let schedule_state = ScheduleStateBuilder::everything_built(view.content_hash(), 3, 2).finish();
    let head = GridsHead {
        site_hash: ContentHash::from_bits(1),
        schedule_state_hash: ContentHash::from_bits(2),
        plan_time_s: ScheduleStateHead::NO_TIME,
        robot: RobotProfile::DEFAULT,
    };
    let slots = &[GridSlotRecord { map_storey: 0, cell_tenths: 5_000, content_hash: ContentHash::from_bits(3) }];
    let passage = DoorPassage::TooNarrow.into();
    // On the storey on which it stands, and on one whose slab it meets.
    let door = DoorPassageRecord {
        passage,
        sides_with_floor: 1,
        width_in_map_m: 0.5,
        clear_width_m: 0.5,
        reasons: DoorPassage::TooNarrow.bit(),
        obstacle: NONE,
        ..Zeroable::zeroed()
    };
    let no_floor = DoorPassage::NoFloor;
    let doors = &[
        door,
        DoorPassageRecord {
            map_storey: 1,
            passage: no_floor.into(),
            reasons: no_floor.bit(),
            sides_with_floor: 0,
            ..door
        },
    ];
    let region = RegionRecord { level_z_tenths: -2_500, area_m2: 1.5, element: 2, ..Zeroable::zeroed() };
    let index = GridsBuilder { doors, regions: &[region], ..GridsBuilder::of(head, slots, "default") }.finish();
    let footprint = |corners: [[i32; 2]; 4]| {
        let polygon = Polygon { exterior: corners.to_vec(), holes: Vec::new() };
        LazyFootprint::from(Footprint { area: MultiPolygon(vec![polygon]), lines: Vec::new() })
    };
    let wall = footprint([[0, 0], [30_000, 0], [30_000, 5_000], [0, 5_000]]);
    let door = footprint([[5_000, 0], [10_000, 0], [10_000, 500], [5_000, 500]]);
    House {
        schedule_state,
        grid: grid(),
        index,
        mission_plan: mission_plan(),
        footprints: vec![(0, wall), (1, door)],
        site,
    }
}

fn site() -> ArchiveBuffer {
    let head = SiteHead { frame_epoch: 1, has_schedule: 1, map_from_world_yaw_rad: -0.0, ..Zeroable::zeroed() };
    let mut b = SiteBuilder { head, ..Default::default() };
    let source = (b.texts.add("house.ifc"), b.texts.add("IFC4"));
    b.sources.push(SourceRecord { file: source.0, schema: source.1, sha256: [0xab; 32], length_unit_m: 1.0 });
    let storey = (b.texts.add("storey-0"), b.texts.add("Erdgeschoß"));
    b.map_storeys.push(MapStoreyRecord {
        global_id: storey.0,
        name: storey.1,
        floor_z_tenths: 1_000,
        floor: FloorKind::Built.into(),
        bounds_tenths: [0, 0, 30_000, 25_000],
    });
    let (roof, why) = (b.texts.add("Roof"), b.texts.add("nothing to walk on"));
    b.storeys.push(StoreyRecord {
        name: roof,
        why,
        map_storey: NONE,
        global_id: Text::default(),
        placement_z_tenths: 0,
        has_placement: 0,
        source: 0,
    });
    // A face of the wall in two triangles.
    b.vertices.extend([[0, 0, 0], [30_000, 0, 0], [30_000, 0, 25_000], [0, 0, 25_000]]);
    b.triangles.extend([[0, 1, 2], [0, 2, 3]]);
    b.parts.push(PartRecord { n_vertices: 4, n_triangles: 2, ..Zeroable::zeroed() });
    let concrete = b.texts.add("Concrete");
    b.materials.push(concrete);
    let property = ["Pset_WallCommon", "LoadBearing", "Width", "Finish"].map(|t| b.texts.add(t));
    let attribute = |name, text, number, kind: AttributeKind| AttributeRecord {
        set: property[0],
        name,
        text,
        number,
        kind: kind.into(),
        reserved: 0,
    };
    b.attributes.push(attribute(property[1], Text::default(), 1.0, AttributeKind::Boolean));
    b.attributes.push(attribute(property[2], Text::default(), f64::INFINITY, AttributeKind::Number));
    b.attributes.push(attribute(property[3], concrete, 0.0, AttributeKind::Text));
    let [set, name, first, second] = ["IfcGroup", "Name", "Lot 1", "Lot 2"].map(|t| b.texts.add(t));
    for lot in [first, second] {
        b.attributes.push(AttributeRecord { set, ..attribute(name, lot, 0.0, AttributeKind::Text) });
    }
    for (id, kind, class, door, stair) in [
        ("wall-0", "IfcWall", grid::Class::Wall, NONE, NONE),
        ("door-0", "IfcDoor", grid::Class::Door, 0, NONE),
        ("stair-0", "IfcStair", grid::Class::Stair, NONE, 0),
    ] {
        let [id, kind] = [id, kind].map(|t| b.texts.add(t));
        let is_wall = u32::from(class == grid::Class::Wall);
        b.elements.push(ElementRecord {
            global_id: id,
            ifc_type: kind,
            max_tenths: [30_000, 5_000, 25_000],
            n_parts: is_wall,
            n_attributes: 5 * is_wall,
            n_materials: is_wall,
            whole: NONE,
            storey: NONE,
            space: NONE,
            door,
            stair,
            class: class.into(),
            flags: if class == grid::Class::Stair { element_flags::FAILED } else { 0 },
            ..Zeroable::zeroed()
        });
    }
    let operation = b.texts.add("SINGLE_SWING_LEFT");
    b.doors.push(DoorRecord {
        element: 1,
        opening: NONE,
        spaces: [0, NONE],
        operation,
        opens: DoorCapability::Swing as u32,
        clear_width_from: ClearWidth::Assumed.into(),
        overall_width_m: 0.6,
        overall_height_m: 2.0,
        clear_width_m: 0.5,
        passage: BoxRecord::default(),
        hanging: DoorHanging::default(),
        beside: [NONE; 2],
        map_storey: 0,
        reserved: 0,
    });
    b.stairs.push(StairRecord { element: 2, n_risers: 12, n_treads: NONE, riser_height_m: 0.18, ..Zeroable::zeroed() });
    b.points.extend([[0, 5_000], [30_000, 5_000], [30_000, 25_000], [0, 25_000]]);
    b.rings.push(RingRecord { first_point: 0, n_points: 4 });
    for (id, name, n_rings, flags) in
        [("space-0", "Küche, \"0.1\"", 1, 0), ("space-1", "Gross", 0, space_flags::METADATA_ONLY)]
    {
        let [id, name] = [id, name].map(|t| b.texts.add(t));
        b.spaces.push(SpaceRecord {
            global_id: id,
            name,
            area_m2: 6.0 * f64::from(n_rings),
            centroid_m: [1.5, 1.5],
            n_rings,
            floor_z_tenths: 1_000,
            height_tenths: 25_000,
            map_storey: if n_rings == 1 { 0 } else { NONE },
            storey: NONE,
            flags,
            ..Zeroable::zeroed()
        });
    }
    let diagnostic = DiagnosticRecord {
        code: DiagnosticCode::DoorOperationUnknown.into(),
        severity: Severity::Warning.into(),
        message: b.texts.add("the file does not say how it opens"),
        step_id: 42,
        ..Zeroable::zeroed()
    };
    b.diagnostics.push(diagnostic);
    b.finish()
}

/// Wall in the lowest row, the door in its second cell, free room above, nothing in the last column.
fn grid() -> ArchiveBuffer {
    let floor = FloorKind::Built.into();
    let head = GridHead { cell_tenths: 5_000, width: 7, height: 5, floor_z_tenths: 1_000, floor, ..GridHead::EMPTY };
    let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(35));
    let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
    let layers = writer.layers();
    for index in 0..35 {
        let cell = head.spec().cell_of(index);
        let (planning, class) = match (cell.row, cell.column) {
            (_, 6) => (-1, grid::Class::None),
            (0, 1) => (100, grid::Class::Door),
            (0, _) => (100, grid::Class::Wall),
            _ => (0, grid::Class::None),
        };
        layers.planning[index] = planning;
        layers.localization[index] = if class == grid::Class::Door { -1 } else { planning };
        layers.keepout[index] = if planning == -1 { 100 } else { -1 };
        layers.class[index] = class.id();
        layers.floor[index] = u8::from(planning != -1);
        layers.space[index] = u16::from(planning == 0);
    }
    writer.seal();
    buffer
}

/// A centre, a scan outside of the room, the way through the door, a stair that this robot does not climb.
fn mission_plan() -> ArchiveBuffer {
    let head = MissionPlanHead {
        site_hash: ContentHash::from_bits(1),
        schedule_state_hash: ContentHash::from_bits(2),
        plan_time_s: ScheduleStateHead::NO_TIME,
        sensor: ScanSensor::DEFAULT,
        coverage_goal: 0.99,
        min_gain_m: 0.5,
        overlap_goal: 0.2,
        separation_m: 0.5,
        minutes_max: 45.0,
        drive: DriveModel::DEFAULT,
        mission_s: [3.0, 60.0],
        mission_j: 0.0,
        changed_since_s: ScheduleStateHead::NO_TIME,
        closed_tours: 0,
        scans_max: NONE,
        classes: 1 << Class::Wall.id(),
        reserved: 0,
    };
    let mut b = MissionPlanBuilder::new(head, 2);
    let reason = b.texts.add("it is a gross area, or made of other spaces");
    b.spaces[0] = MissionPlanSpaceRecord {
        n_faces: 8,
        n_seen: 7,
        why: NoWaypoint::Has.into(),
        access: SpaceAccess::Reached.into(),
        centre: 0,
        ..b.spaces[0]
    };
    b.spaces[1] = MissionPlanSpaceRecord { reason, why: NoWaypoint::MetadataOnly.into(), ..b.spaces[1] };
    let centre = WaypointRecord {
        position_in_map_m: [1.75, 1.75, 0.1],
        sensor_in_map_m: [1.75, 1.75, 1.3],
        up_in_map: UPRIGHT,
        centroid_in_map_m: [1.5, 1.5, 0.1],
        clearance_m: 1.25,
        kind: WaypointKind::Centre.into(),
        joins: NONE,
        registration_order: NONE,
        ..Zeroable::zeroed()
    };
    let scan = WaypointRecord {
        kind: WaypointKind::Scan.into(),
        id: 1,
        order: 1,
        space: NONE,
        leg_m: 0.5,
        registration_order: 0,
        ..centre
    };
    b.growth.extend([7, 1].map(|n_new| GrownScanRecord { map_storey: 0, n_new }));
    b.waypoints.extend([centre, scan]);
    b.storeys.push(MissionPlanStoreyRecord {
        tour_m: 0.5,
        tour_bound_m: 0.5,
        n_faces: 8,
        n_seen: 7,
        n_scans: 1,
        n_parts: 1,
        reached_m2: 3.0,
        unreached_m2: 1.5,
        n_tour_points: 2,
        entry: StoreyEntry::OuterDoor.into(),
        ..Zeroable::zeroed()
    });
    let part = FloorPartRecord { area_m2: 3.0, room_m2: 3.0, at_m: [1.75, 1.75], is_reached: 1, ..Zeroable::zeroed() };
    b.floor_parts.extend([part, FloorPartRecord { area_m2: 1.5, is_reached: 0, has_way_in: 1, ..part }]);
    b.tour_points.extend([[1.75, 1.75], [1.75, 1.25]]);
    let node = |kind: NodeKind, of: u32, x_m: f64| RouteNodeRecord {
        position_in_map_m: [x_m, 1.75, 0.1],
        clearance_m: 1.25,
        kind: kind.into(),
        map_storey: 0,
        of,
        space: 0,
    };
    b.nodes.extend([node(NodeKind::Space, 0, 1.75), node(NodeKind::Door, 0, 1.25), node(NodeKind::Staging, 2, 2.25)]);
    b.nodes.push(RouteNodeRecord { map_storey: 1, ..node(NodeKind::Staging, 2, 2.75) });
    let edge = |nodes: [u32; 2], kind: EdgeKind, of: u32, usable: u32| RouteEdgeRecord {
        length_m: 0.5,
        clearance_m: 0.25,
        slope_rad: 0.0,
        duration_s: [1.0; 2],
        energy_j: [0.0; 2],
        clear_width_m: if kind == EdgeKind::Stair { 1.1 } else { 0.0 },
        nodes,
        kind: kind.into(),
        of,
        first_point: 0,
        n_points: 0,
        usable,
        n_risers: if kind == EdgeKind::Stair { 12 } else { NONE },
    };
    b.edges.extend([edge([0, 1], EdgeKind::Door, 0, 1), edge([2, 3], EdgeKind::Stair, 2, 0)]);
    b.points.extend([[1.75, 1.75, 0.1], [1.25, 1.75, 0.1], [2.25, 1.75, 0.1], [2.5, 1.5, 0.28], [2.75, 1.75, 0.46]]);
    b.edges[0].n_points = 2;
    (b.edges[1].first_point, b.edges[1].n_points) = (2, 3);
    b.finish()
}
