//! Small archives that use every section, and functions that read every field of a view.
#![allow(dead_code, reason = "every test file uses a part of this")]

use bytemuck::Zeroable;
use messages::*;
use xxhash_rust::xxh3::xxh3_64;

/// A building of two elements, a space, a door, a task in another.
pub(crate) fn site() -> ArchiveBuffer {
    let mut b = SiteBuilder::default();
    let text = b.texts.add("Grüße");
    b.materials.push(text);
    b.attributes.push(AttributeRecord {
        set: text,
        name: text,
        text,
        kind: AttributeKind::Text.into(),
        ..Zeroable::zeroed()
    });
    b.vertices = vec![[0, 0, 0], [10_000, 0, 0], [0, 10_000, 0], [0, 0, 10_000]];
    b.triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    b.parts.push(PartRecord { n_vertices: 4, n_triangles: 4, closed: 1, ..Zeroable::zeroed() });
    b.map_storeys.push(MapStoreyRecord {
        name: text,
        global_id: text,
        floor_z_tenths: 0,
        floor: FloorKind::Built.into(),
        bounds_tenths: [0, 0, 10_000, 10_000],
    });
    b.storeys.push(StoreyRecord { name: text, map_storey: 0, ..Zeroable::zeroed() });
    let element = ElementRecord {
        global_id: text,
        supertypes: b.texts.add_list(["IfcWall", "IfcElement"]),
        n_parts: 1,
        n_attributes: 1,
        n_materials: 1,
        class: grid::Class::Wall.into(),
        max_tenths: [10_000; 3],
        whole: NONE,
        storey: 0,
        space: NONE,
        door: NONE,
        stair: NONE,
        ..Zeroable::zeroed()
    };
    let door = ElementRecord {
        class: grid::Class::Door.into(),
        door: 0,
        whole: 0,
        n_parts: 0,
        n_attributes: 0,
        n_materials: 0,
        ..element
    };
    b.elements = vec![element, door];
    b.points = vec![[0, 0], [10_000, 0], [0, 10_000]];
    b.rings.push(RingRecord { first_point: 0, n_points: 3 });
    b.spaces.push(SpaceRecord { name: text, n_rings: 1, area_m2: 0.5, ..Zeroable::zeroed() });
    let plan = BoxRecord { centre: [5_000.0, 0.0], axis: [1.0, 0.0], half: [4_000.0, 500.0] };
    b.openings.push(OpeningRecord { plan, filling: 1, top_z_tenths: 21_000, ..Zeroable::zeroed() });
    b.doors.push(DoorRecord {
        element: 1,
        spaces: [0, NONE],
        passage: plan,
        beside: [NONE, 0],
        clear_width_from: ClearWidth::Assumed.into(),
        map_storey: NONE,
        ..Zeroable::zeroed()
    });
    let diagnostic = diagnostic(&mut b.texts);
    b.diagnostics.push(diagnostic);
    b.boundaries.push(BoundaryRecord { space: 0, element: 1 });
    b.contacts = b.boundaries.clone();
    b.sources.push(SourceRecord { file: text, ..Zeroable::zeroed() });
    b.panels.push(DoorPanelRecord { operation: text, ..Zeroable::zeroed() });
    b.stairs.push(Zeroable::zeroed());
    b.vertices.extend([[0, 0, 0], [90_000, 0, 0], [0, 90_000, 500]]);
    b.triangles.push([0, 1, 2]);
    b.parts.push(PartRecord {
        first_vertex: 4,
        n_vertices: 3,
        first_triangle: 4,
        n_triangles: 1,
        ..Zeroable::zeroed()
    });
    b.terrains.push(TerrainRecord {
        global_id: text,
        first_part: 1,
        n_parts: 1,
        ground: GroundClass::Terrain.into(),
        ..Zeroable::zeroed()
    });
    b.schedule = work_schedule(text);
    b.finish()
}

/// Two tasks in another, with a record of each kind.
fn work_schedule(text: Text) -> WorkScheduleRecords {
    let mut schedule = WorkScheduleRecords::default();
    let task = TaskRecord { name: text.into(), parent: NONE, control: NONE, calendar: NONE, ..Zeroable::zeroed() };
    schedule.tasks = vec![task, TaskRecord { parent: 0, ..task }, TaskRecord { parent: 1, ..task }];
    let kind = SequenceKind::FinishStart.into();
    schedule.sequences.push(SequenceRecord {
        global_id: text.into(),
        successor: 1,
        kind,
        lag_calendar: NONE,
        ..Zeroable::zeroed()
    });
    schedule.task_links.push(TaskLinkRecord { task: 0, kind: LinkKind::Element.into(), target: 1, flags: 0 });
    let kind = TaskConstraintKind::StartNotEarlierThan.into();
    schedule.constraints.push(TaskConstraintRecord { task: 1, kind, ..Zeroable::zeroed() });
    let date = CivilDate { at_s: 1_709_539_200, offset_s: Some(3_600), is_day: false };
    schedule.dates.push(ScheduleDateRecord::new(date, ScheduleDateKind::ScheduleStart, 1));
    schedule.calendars.push(CalendarRecord::zeroed());
    schedule.assignments.push(TaskAssignmentRecord { duration_s: 3_600, task: 1, calendar: 0 });
    schedule.durations.push(TaskDurationRecord { duration_s: 3_600, task: 1, reserved: 0 });
    schedule.uncertainties.push(TaskUncertaintyRecord {
        duration_optimistic_s: 3_600,
        duration_likely_s: 7_200,
        duration_pessimistic_s: 14_400,
        task: 1,
        is_elapsed: 0,
    });
    schedule.work_times.push(WorkTimeRecord { kind: RecurrenceKind::Weekly.into(), ..Zeroable::zeroed() });
    schedule.periods_s.push([28_800, 57_600]);
    schedule.work_controls.push(WorkControlRecord { name: text.into(), ..Zeroable::zeroed() });
    schedule
}

/// The tasks of a file that work on the site.
pub(crate) fn tasks() -> ArchiveBuffer {
    let archive = site();
    let head = TasksHead::of_site(&Site::open(archive.bytes()).expect("it is whole"));
    let mut b = TasksBuilder { head, ..TasksBuilder::default() };
    let text = b.texts.add("Bewehrung");
    b.schedule = work_schedule(text);
    b.link_rules = vec![text.into(); b.schedule.task_links.len()];
    b.sources.push(ScheduleSourceRecord { file: text.into(), ..Zeroable::zeroed() });
    let diagnostic = diagnostic(&mut b.texts);
    b.diagnostics.push(diagnostic);
    b.finish()
}

fn diagnostic(texts: &mut TextPool) -> DiagnosticRecord {
    let (severity, code) = (Severity::Warning, DiagnosticCode::DuplicateId);
    let diagnostic = Diagnostic { severity, code, entity: None, source: None, message: "two of them".to_owned() };
    DiagnosticRecord::of(&diagnostic, texts)
}

pub(crate) fn schedule_state() -> ArchiveBuffer {
    let mut schedule_state = ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), 2, 1);
    schedule_state.schedule = vec![ElementScheduleRecord::NOTHING; 2];
    schedule_state.spaces[0].reasons = schedule_state.texts.add_list(["task:x", "private"]);
    let diagnostic = diagnostic(&mut schedule_state.texts);
    schedule_state.diagnostics.push(diagnostic);
    schedule_state.finish()
}

pub(crate) fn grid() -> ArchiveBuffer {
    let head = GridHead { cell_tenths: 500, width: 3, height: 2, ..GridHead::EMPTY };
    let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_with_heights(6));
    GridWriter::new(buffer.bytes_mut(), &head).seal();
    buffer
}

pub(crate) fn grids() -> ArchiveBuffer {
    let head = GridsHead {
        site_hash: ContentHash::from_bits(1),
        schedule_state_hash: ContentHash::from_bits(2),
        plan_time_s: 3,
        robot: RobotProfile::DEFAULT,
    };
    let slots = &[GridSlotRecord { map_storey: 0, cell_tenths: 500, content_hash: ContentHash::from_bits(9) }];
    let doors = &[DoorPassageRecord { width_in_map_m: 0.8, ..Zeroable::zeroed() }];
    let regions = &[RegionRecord { area_m2: 1.0, ..Zeroable::zeroed() }];
    let mut rules = SafetyRules::default();
    rules.add(SafetySubject::Material("marble"), Some(0.5), Some(0.3)).expect("a rule that can be");
    rules.add(SafetySubject::Glass, Some(1.0), None).expect("a rule that can be");
    GridsBuilder {
        head,
        slots,
        robot_name: "default",
        robot_footprint_m: &[[0.2, 0.1], [-0.2, 0.1], [0.0, -0.2]],
        doors,
        regions,
        safety_rules: rules.records(),
        safety_materials: rules.materials(),
    }
    .finish()
}

pub(crate) fn mission_plan() -> ArchiveBuffer {
    let head = MissionPlanHead {
        site_hash: ContentHash::from_bits(1),
        schedule_state_hash: ContentHash::from_bits(2),
        plan_time_s: 3,
        ..Zeroable::zeroed()
    };
    let mut b = MissionPlanBuilder::new(head, 1);
    b.spaces[0] = MissionPlanSpaceRecord {
        reason: b.texts.add("blocked"),
        centre: 0,
        why: NoWaypoint::Blocked.into(),
        ..Zeroable::zeroed()
    };
    b.waypoints.push(WaypointRecord {
        kind: WaypointKind::Centre.into(),
        up_in_map: [0.6, 0.0, 0.8],
        joins: NONE,
        ..Zeroable::zeroed()
    });
    b.tour_points = vec![[0.0, 0.0], [1.0, 0.0]];
    b.storeys.push(MissionPlanStoreyRecord { n_tour_points: 2, ..Zeroable::zeroed() });
    b.nodes = vec![RouteNodeRecord { of: NONE, ..Zeroable::zeroed() }; 2];
    b.floor_parts.push(FloorPartRecord { area_m2: 1.0, is_reached: 1, ..Zeroable::zeroed() });
    b.points = vec![[0.0; 3], [1.0, 0.0, 0.5]];
    let diagnostic = diagnostic(&mut b.texts);
    b.diagnostics.push(diagnostic);
    b.growth.push(Zeroable::zeroed());
    b.edges.push(RouteEdgeRecord { nodes: [0, 1], n_points: 2, ..Zeroable::zeroed() });
    let waypoint = FlightWaypointRecord { space: 0, element: 0, terrain: NONE, ..Zeroable::zeroed() };
    b.flight = Some(FlightRecords {
        head: FlightHead { clearance_m: 0.8, spacing_m: 4.0, step_m: 0.2, n_parts: 1, reserved: 0 },
        heights_m: vec![1.5],
        waypoints: vec![waypoint; 2],
        edges: vec![[0, 1]],
        spaces: vec![FlightSpaceRecord { n_waypoints: 2, ..Zeroable::zeroed() }],
    });
    b.finish()
}

/// Two surfaces of an element and a terrain, with a step between them.
pub(crate) fn ground() -> ArchiveBuffer {
    let head = GroundHead {
        site_hash: ContentHash::from_bits(1),
        schedule_state_hash: ContentHash::from_bits(2),
        plan_time_s: 3,
        max_slope_rad: 0.6,
    };
    let face = |first: u32, surface: u32, class: GroundClass| GroundFaceRecord {
        vertices: [first, first + 1, first + 2],
        body: surface,
        surface,
        class: class.into(),
        ..Zeroable::zeroed()
    };
    let surface = |first_face: u32, class: GroundClass| GroundSurfaceRecord {
        area_m2: 0.5,
        max_tenths: [20_000, 10_000, 1_000],
        first_face,
        n_faces: 1,
        class: class.into(),
        ..Zeroable::zeroed()
    };
    let body = |element: u32, terrain: u32, class: GroundClass| GroundBodyRecord {
        element,
        terrain,
        class: class.into(),
        reserved: [0; 3],
    };
    GroundWriter {
        head,
        bodies: vec![body(0, NONE, GroundClass::Floor), body(NONE, 0, GroundClass::Terrain)],
        vertices: vec![
            [0, 0, 0],
            [10_000, 0, 0],
            [10_000, 10_000, 0],
            [10_000, 0, 1_000],
            [20_000, 0, 1_000],
            [10_000, 10_000, 1_000],
        ],
        faces: vec![face(0, 0, GroundClass::Floor), face(3, 1, GroundClass::Terrain)],
        surfaces: vec![surface(0, GroundClass::Floor), surface(1, GroundClass::Terrain)],
        connections: vec![GroundConnectionRecord {
            surfaces: [0, 1],
            at_tenths: [10_000, 5_000, 0],
            step_tenths: 1_000,
            length_m: 1.0,
            kind: GroundConnection::Step.into(),
        }],
    }
    .finish()
}

pub(crate) fn slam_map() -> ArchiveBuffer {
    let head = SlamMapHead { resolution_m: 0.05, origin: [1.0, 2.0, 0.1], width: 3, height: 2 };
    SlamMap::write(&head, &[0, 100, -1, 50, 0, 0])
}

pub(crate) fn alignment() -> ArchiveBuffer {
    let head = AlignmentHead { scale: 1.0, state: PoseState::Tracked.into(), ..Zeroable::zeroed() };
    let mut builder = AlignmentBuilder::new(head, "two poses fit", vec![PoseRecord::NONE; 2]);
    let room_name = builder.texts.add("U.04");
    builder.head.decision = room_name;
    builder.placed = vec![PlacedRecord { room_name, ..Zeroable::zeroed() }; 2];
    builder.pose_pairs = vec![PosePairRecord { candidates: [0, 1] }; 2];
    builder.head.first_undecided = 1;
    builder.deciding_places = vec![DecidingPlaceRecord { n_placed: 2, n_pairs: 1, ..Zeroable::zeroed() }];
    builder.hints = vec![HintRecord { label: room_name, n_excluded: 1, reserved: 0 }];
    let head =
        LocalPosesHead { block_m: 0.5, n_columns: 2, has_robot: 1, max_deviation: [0.1, 0.02], ..Zeroable::zeroed() };
    builder.local_poses = Some(LocalPosesParts {
        head,
        parts: vec![LocalPoseRecord { is_borne_out: 1, ..Zeroable::zeroed() }],
        blocks: vec![0, NONE],
        rings: vec![OutlineRingRecord { first_corner: 0, n_corners: 4, is_hole: 0, reserved: 0 }],
        corners: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
    });
    builder.finish()
}

pub(crate) fn alignment_evidence() -> ArchiveBuffer {
    let head = AlignmentEvidenceHead { width: 5, height: 3, n_looks: 1, accepted: 1, ..Zeroable::zeroed() };
    let mut builder = AlignmentEvidenceBuilder::new(head, vec![Zeroable::zeroed(); 2]);
    (0..6).for_each(|index| builder.mark_known(2 * index));
    builder.finish()
}

pub(crate) fn deviations() -> ArchiveBuffer {
    let head = DeviationsHead {
        site_hash: ContentHash::from_bits(1),
        schedule_state_hash: ContentHash::from_bits(2),
        cell_tenths: 500,
        width: 3,
        height: 2,
        ..Zeroable::zeroed()
    };
    let mut b = DeviationsBuilder::new(head);
    b.seen = [SlamCell::Unknown, SlamCell::Free, SlamCell::Occupied].map(Tag::from).repeat(2);
    b.elements.push(ElementDeviationRecord {
        observation: Observation::Displaced.into(),
        verdict: DeviationVerdict::Displaced.into(),
        n_samples: 9,
        n_visible: 8,
        n_contradicted: 7,
        ..Zeroable::zeroed()
    });
    b.absent_parts.push(AbsentPartRecord {
        to_m: 1.5,
        ends_m: [[0.0, 1.0], [1.5, 1.0]],
        verdict: DeviationVerdict::Late.into(),
        ..Zeroable::zeroed()
    });
    b.points = vec![[0, 0], [10_000, 0], [0, 10_000]];
    b.rings.push(RingRecord { first_point: 0, n_points: 3 });
    b.obstacles.push(ObstacleRecord { area_m2: 0.5, n_rings: 1, space: NONE, ..Zeroable::zeroed() });
    b.residuals.push(Zeroable::zeroed());
    b.finish()
}

/// One whole archive of each kind.
pub(crate) fn every_archive() -> Vec<ArchiveBuffer> {
    ArchiveKind::ALL.iter().map(|&kind| whole(kind)).collect()
}

/// A whole archive of a kind that has records in every section.
pub(crate) fn whole(kind: ArchiveKind) -> ArchiveBuffer {
    match kind {
        ArchiveKind::Site => site(),
        ArchiveKind::ScheduleState => schedule_state(),
        ArchiveKind::Grid => grid(),
        ArchiveKind::Grids => grids(),
        ArchiveKind::MissionPlan => mission_plan(),
        ArchiveKind::SlamMap => slam_map(),
        ArchiveKind::Alignment => alignment(),
        ArchiveKind::Deviations => deviations(),
        ArchiveKind::AlignmentEvidence => alignment_evidence(),
        ArchiveKind::Tasks => tasks(),
        ArchiveKind::Ground => ground(),
    }
}

/// Makes the preamble fit the content again, so that what lies behind the hash is looked at.
pub(crate) fn reseal(bytes: &mut [u8]) {
    if bytes.len() >= 64 {
        let is_grid = bytes[8..12] == (ArchiveKind::Grid as u32).to_le_bytes();
        let of_blocks = || bytes[64..].chunks(HASHED_BLOCK).flat_map(|block| xxh3_64(block).to_le_bytes()).collect();
        let hashed: Vec<u8> = if is_grid { of_blocks() } else { bytes[64..].to_vec() };
        let (length, hash) = (bytes.len() as u64, xxh3_64(&hashed));
        bytes[16..24].copy_from_slice(&length.to_le_bytes());
        bytes[24..32].copy_from_slice(&hash.to_le_bytes());
    }
}

/// Opens bytes as every kind; a view that opens gives all it has.
pub(crate) fn walk(bytes: &[u8]) -> usize {
    ArchiveKind::ALL.iter().filter_map(|&kind| walk_as(kind, bytes).ok()).sum()
}

/// Opens bytes as this kind, and reads to the end.
fn walk_as(kind: ArchiveKind, bytes: &[u8]) -> Result<usize, ArchiveError> {
    Ok(match kind {
        ArchiveKind::Site => walk_site(&Site::open(bytes)?),
        ArchiveKind::ScheduleState => walk_schedule_state(&ScheduleState::open(bytes)?),
        ArchiveKind::Grid => walk_grid(&Grid::open(bytes)?),
        ArchiveKind::Grids => walk_grids(&Grids::open(bytes)?),
        ArchiveKind::MissionPlan => walk_mission_plan(&MissionPlan::open(bytes)?),
        ArchiveKind::SlamMap => {
            let map = SlamMap::open(bytes)?;
            map.occupancy.iter().filter(|&&o| o >= 0).count() + usize::from(map.head.resolution_m > 0.0)
        }
        ArchiveKind::Alignment => walk_alignment(&Alignment::open(bytes)?),
        ArchiveKind::Deviations => walk_deviations(&Deviations::open(bytes)?),
        ArchiveKind::AlignmentEvidence => {
            let evidence = AlignmentEvidence::open(bytes)?;
            let n_cells = evidence.head.width as usize * evidence.head.height as usize;
            let n_known = (0..n_cells).filter(|k| evidence.is_known(*k)).count();
            evidence.poses.len() + usize::from(evidence.accepted().is_some()) + n_known
        }
        ArchiveKind::Ground => {
            let ground = Ground::open(bytes)?;
            let faces = ground.surfaces.iter().flat_map(|s| ground.faces_of(s));
            let n_high = faces.filter(|f| ground.corners(f).iter().any(|c| c[2] > 0)).count();
            let classes = ground.bodies.iter().filter(|b| b.class.get() != GroundClass::None).count();
            let kinds = ground.connections.iter().filter(|c| c.kind.get() != GroundConnection::Step).count();
            ground.faces.len() + n_high + classes + kinds + usize::from(ground.head.max_slope_rad > 0.0)
        }
        ArchiveKind::Tasks => {
            let tasks = Tasks::open(bytes)?;
            let archive = site();
            let site = Site::open(archive.bytes()).expect("it is whole");
            walk_schedule(&tasks.schedule()) + site.with_tasks(&tasks).map_or(0, |site| walk_site(&site))
        }
    })
}

fn walk_schedule_state(schedule_state: &ScheduleState<'_>) -> usize {
    let elements = 0..schedule_state.n_elements();
    let mut n = elements.clone().filter(|&k| schedule_state.effective(k) == schedule_state.planned(k)).count();
    n += elements.filter(|&k| schedule_state.schedule_of(k).task == NONE).count();
    n += (0..schedule_state.spaces.len())
        .map(|k| schedule_state.why(k).count() + usize::from(schedule_state.is_blocked(k)))
        .sum::<usize>();
    n += schedule_state.diagnostics.iter().map(|d| schedule_state.text(d.message).len()).sum::<usize>();
    n + usize::from(schedule_state.head.plan_time().is_some())
}

fn walk_grid(grid: &Grid<'_>) -> usize {
    let spec = grid.spec();
    let n = (0..grid.class.len()).filter(|&k| spec.index(spec.cell_of(k)) == k).count();
    let n = n + grid.planning.len() + grid.keepout.len() + grid.localization.len() + grid.floor.len();
    let n = n + grid.space.len() + usize::from(spec.origin_m()[0].is_finite());
    let is_told = |cell: &usize| {
        let drives = grid.traversability(*cell, &RobotProfile::DEFAULT);
        grid.height_tenths(*cell).is_some() || grid.slope_rad(*cell).is_some() || drives.is_some()
    };
    n + (0..grid.class.len()).filter(is_told).count()
}

fn walk_grids(index: &Grids<'_>) -> usize {
    let n = index.robot_name.len() + index.robot_footprint_m.len() + index.slots.len();
    let n_closed = index.doors.iter().filter(|d| d.passage.get().is_closed()).count();
    let rules = SafetyRules::of(index);
    let materials = rules.records().iter().filter(|rule| matches!(rules.subject(rule), SafetySubject::Material(_)));
    n + index.doors.len() + index.regions.len() + n_closed + materials.count()
}

fn walk_mission_plan(mission_plan: &MissionPlan<'_>) -> usize {
    let mut n = mission_plan.waypoints.len();
    n += (0..mission_plan.spaces.len()).map(|k| mission_plan.reason(k).len()).sum::<usize>();
    n += mission_plan.storeys.iter().map(|s| mission_plan.tour_of(s).len()).sum::<usize>();
    let is_door = |node: u32| mission_plan.nodes[node as usize].kind == NodeKind::Door;
    let edges = mission_plan.edges.iter();
    n += edges.map(|e| mission_plan.points_of(e).len() + usize::from(is_door(e.nodes[0]))).sum::<usize>();
    n += mission_plan.flight.iter().map(|flight| walk_flight(flight, mission_plan.spaces.len())).sum::<usize>();
    n + mission_plan.diagnostics.iter().map(|d| mission_plan.text(d.message).len()).sum::<usize>()
}

fn walk_flight(flight: &Flight<'_>, n_spaces: usize) -> usize {
    let height = |k: u32| flight.heights_m[flight.waypoints[k as usize].height as usize];
    let n_level = flight.edges.iter().filter(|[a, b]| height(*a).to_bits() == height(*b).to_bits()).count();
    let spaces = (0..n_spaces).flat_map(|space| flight.of_space(space));
    n_level + spaces.filter(|space| space.why.get() != NoFlight::Has || space.n_waypoints > 0).count()
}

fn walk_alignment(alignment: &Alignment<'_>) -> usize {
    let mut n = alignment.reason().len() + alignment.candidates.len() + usize::from(alignment.pose().is_some());
    n += alignment.decision().map_or(0, str::len) + alignment.undecided().len();
    for place in alignment.deciding_places {
        let placed = alignment.placed(place).iter();
        n += alignment.decided(place).len() + placed.map(|p| alignment.text(p.room_name).len()).sum::<usize>();
    }
    n += alignment.hints.iter().map(|hint| alignment.text(hint.label).len()).sum::<usize>();
    let outline = alignment.local_poses.iter().flat_map(|local| local.outline_m());
    n += outline.map(|(_, loop_m)| loop_m.len()).sum::<usize>();
    n + [[0.2, 0.2], [1e300, -1e300]].into_iter().filter_map(|at| alignment.pose_at(at)).count()
}

fn walk_deviations(deviations: &Deviations<'_>) -> usize {
    let mut n = deviations.elements.iter().flat_map(|e| deviations.absent_parts_of(e)).count();
    let spec = deviations.head.spec();
    n += deviations.seen.iter().filter(|s| s.get() != SlamCell::Unknown).count() + deviations.residuals.len();
    n += usize::from(spec.n_cells() == 0 || spec.centre_of(spec.cell_of(spec.n_cells() - 1)).x_m().is_finite());
    n += deviations.elements.iter().filter(|e| e.n_visible <= e.n_samples).count();
    n + deviations.obstacles.iter().flat_map(|o| deviations.rings_of(o)).map(<[_]>::len).sum::<usize>()
}

fn walk_site(site: &Site<'_>) -> usize {
    let mut n = 0;
    for element in site.elements {
        n += site.text(element.global_id).len() + site.text(element.name).len() + element.class().name().len();
        n += site.element_meshes(element).map(|m| m.triangles.len() + m.vertices.len()).sum::<usize>();
        n += site.element_attributes(element).iter().map(|a| site.text(a.text).len()).sum::<usize>();
        n += site.supertypes(element).map(str::len).sum::<usize>();
        n += site.element_materials(element).map(str::len).sum::<usize>();
    }
    for space in site.spaces {
        n += site.text(space.name).len() + site.space_meshes(space).count() + site.space_attributes(space).len();
        n += site.floor_polygon(space).0.len();
    }
    for door in site.doors {
        n += usize::from(door.passage.to_box().at(1.0, 1.0)[0].is_finite());
    }
    n += walk_schedule(&site.schedule);
    n + usize::from(site.map_from_world().apply([0.0; 3])[0].is_finite())
}

fn walk_schedule(schedule: &WorkSchedule<'_>) -> usize {
    let (mut n, mut at) = (0, 0);
    while let Some(task) = schedule.tasks.get(at).filter(|t| t.parent != NONE) {
        at = task.parent as usize;
        n += 1;
    }
    n += schedule.tasks.iter().map(|task| schedule.text(task.name).len()).sum::<usize>();
    n += schedule.sources.iter().map(|source| schedule.text(source.file).len()).sum::<usize>();
    n += schedule.sequences.iter().filter_map(|sequence| schedule.lag(sequence)).count();
    n += schedule.link_rules.iter().map(|rule| schedule.text(*rule).len()).sum::<usize>();
    n + schedule.uncertainties.iter().filter(|u| schedule.tasks[u.task as usize].parent != NONE).count()
}
