//! The `site` archive: its sections, its view.

use crate::archive::{ArchiveError, Text};
use crate::declaration::declare_archive;
use crate::diagnostic_record::{DiagnosticRecord, check_diagnostics};
use crate::robot::{DoorCapability, RobotProfile};
use crate::site_records::*;
use crate::spans::{fits, optional, span};
use crate::tag::check_tags;
use crate::work_schedule::{LinkTargets, WorkSchedule, WorkScheduleRecords};
use frames::{EarthFromWorld, Map, TENTHS_PER_M, UprightRigid3, World};
use geometry::{MeshView, MultiPolygon, OrientedBox, Polygon, ring_area_doubled};

declare_archive! {
    /// Geometry and facts of a site, read in place.
    ///
    /// All indices inside were checked when it was opened, so slicing by them does not panic.
    view Site;
    /// Records of a `site` archive to be.
    owned SiteBuilder;
    sections {
        /// Data of the whole site.
        pub head: one(1, SiteHead),
        /// Files.
        pub sources: many(3, SourceRecord),
        /// IfcBuildingStorey, in file order.
        pub storeys: many(4, StoreyRecord),
        /// Storeys that have a map, from low to high.
        pub map_storeys: many(5, MapStoreyRecord),
        /// Elements, in file order.
        pub elements: many(6, ElementRecord),
        /// Mesh parts of elements, spaces and terrains.
        pub parts: many(7, PartRecord),
        /// Vertices in `map`, tenths of a millimetre.
        pub vertices: many(8, [i32; 3]),
        /// Triangles.
        pub triangles: many(9, [u32; 3]),
        /// Spaces, in file order.
        pub spaces: many(10, SpaceRecord),
        /// Rings of the spaces' floor polygons.
        pub rings: many(11, RingRecord),
        /// Points of the rings in `map`, tenths of a millimetre.
        pub points: many(12, [i32; 2]),
        /// Openings.
        pub openings: many(13, OpeningRecord),
        /// Doors.
        pub doors: many(14, DoorRecord),
        /// Panels of doors.
        pub panels: many(21, DoorPanelRecord),
        /// Stairs and flights.
        pub stairs: many(15, StairRecord),
        /// Which elements bound which spaces by IfcRelSpaceBoundary, sorted.
        pub boundaries: many(16, BoundaryRecord),
        /// Properties of elements and spaces.
        pub attributes: many(17, AttributeRecord),
        /// Names of materials.
        pub materials: many(18, Text),
        /// Diagnostics.
        pub diagnostics: many(19, DiagnosticRecord),
        /// Which elements touch which spaces by geometry, sorted: for spaces without boundaries.
        pub contacts: many(20, BoundaryRecord),
        /// Shapes of sites and roads themselves, in file order.
        pub terrains: if_any(23, TerrainRecord),
        /// The tasks: those of the models, unless others stand in for them.
        pub schedule: group(WorkSchedule, WorkScheduleRecords),
        /// All texts.
        texts: texts(2, listed 22),
    }
}

impl<'a> Site<'a> {
    fn check(&self) -> Result<(), ArchiveError> {
        self.check_tags()?;
        self.check_spans()?;
        self.check_meshes()?;
        self.check_numbers()?;
        self.check_indices()?;
        self.schedule.check(self.link_targets())?;
        self.check_texts()
    }

    /// The same site with another work schedule, whose links have their targets here.
    pub(crate) fn with_schedule(&self, schedule: WorkSchedule<'a>) -> Self {
        Self { schedule, ..*self }
    }

    /// True if there is a work schedule, or anything else that has dates.
    pub fn has_schedule(&self) -> bool {
        self.head.has_schedule == 1 || !self.schedule.tasks_hash.is_none()
    }

    /// Base name of the file with this number, as diagnostics of the schedule have it: files of the models, then schedule files.
    pub fn source_file(&self, source: u32) -> Option<&'a str> {
        let (k, n_models) = (source as usize, self.sources.len());
        match self.sources.get(k) {
            Some(model) => Some(self.text(model.file)),
            None => self.schedule.sources.get(k.checked_sub(n_models)?).map(|file| self.schedule.text(file.file)),
        }
    }

    /// The text.
    pub fn text(&self, text: Text) -> &'a str {
        self.texts.get(text)
    }

    /// The entity of an element and its supertypes.
    pub fn supertypes(&self, element: &ElementRecord) -> impl Iterator<Item = &'a str> + Clone + use<'a> {
        self.texts.list(element.supertypes)
    }

    /// True if an element is of this entity, or of a subtype of it.
    pub fn is_a(&self, element: &ElementRecord, entity: &str) -> bool {
        self.supertypes(element).any(|supertype| supertype == entity)
    }

    /// The motion from the IFC world to the map.
    pub fn map_from_world(&self) -> UprightRigid3<Map, World> {
        UprightRigid3::new(self.head.map_from_world_m, self.head.map_from_world_yaw_rad)
    }

    /// The map from the IFC world to the projected system; `None` if no file gives one.
    pub fn earth_from_world(&self) -> Option<EarthFromWorld> {
        let head = self.head;
        (head.has_earth == 1).then(|| EarthFromWorld::new(head.earth_m, head.earth_x_axis, head.earth_scale))
    }

    /// The meshes of an element.
    pub fn element_meshes(&self, element: &ElementRecord) -> impl Iterator<Item = MeshView<'a>> + Clone + use<'a> {
        self.meshes(element.first_part, element.n_parts)
    }

    /// The meshes of a terrain.
    pub fn terrain_meshes(&self, terrain: &TerrainRecord) -> impl Iterator<Item = MeshView<'a>> + Clone + use<'a> {
        self.meshes(terrain.first_part, terrain.n_parts)
    }

    /// The meshes of a space.
    pub fn space_meshes(&self, space: &SpaceRecord) -> impl Iterator<Item = MeshView<'a>> + Clone + use<'a> {
        self.meshes(space.first_part, space.n_parts)
    }

    /// The map storeys that are levels of a building, with their indices: all but that of the ground outdoors, which has no height.
    pub fn levels(&self) -> impl DoubleEndedIterator<Item = (usize, &'a MapStoreyRecord)> + Clone + use<'a> {
        self.map_storeys.iter().enumerate().filter(|(_, storey)| storey.floor != FloorKind::Ground)
    }

    /// The map storey of the ground outdoors, with its index, if there is one.
    pub fn outdoors(&self) -> Option<(usize, &'a MapStoreyRecord)> {
        self.map_storeys.iter().enumerate().find(|(_, storey)| storey.floor == FloorKind::Ground)
    }

    /// True if a door begins at a height of the ground, in tenths of a millimetre: its opening, or else the door itself, within a step of the
    /// robot or the height of a sill.
    pub fn is_door_at(&self, door: &DoorRecord, robot: &RobotProfile, ground_z: f64) -> bool {
        let opening = self.openings.get(door.opening as usize);
        let bottom = opening.map_or(self.elements[door.element as usize].min_tenths[2], |o| o.bottom_z_tenths);
        let most = f64::from(MAX_SILL_TENTHS).max(robot.step_height_m * f64::from(TENTHS_PER_M));
        (f64::from(bottom) - ground_z).abs() <= most
    }

    /// Height of the next floor at least `min_rise` above a floor, or of the top of the highest element, at least as high.
    pub fn next_floor_z_tenths(&self, floor_z: i32, min_rise: i32) -> i32 {
        let above = self.levels().map(|(_, s)| s.floor_z_tenths).filter(|z| *z >= floor_z + min_rise);
        let top = self.elements.iter().filter(|e| e.n_parts > 0).map(|e| e.max_tenths[2]).max();
        above.min().or(top).unwrap_or(floor_z).max(floor_z + min_rise)
    }

    /// The floor polygon of a space.
    pub fn floor_polygon(&self, space: &SpaceRecord) -> MultiPolygon {
        let mut polygons: Vec<Polygon> = Vec::new();
        for ring in &self.rings[span(space.first_ring, space.n_rings)] {
            let points = self.points[span(ring.first_point, ring.n_points)].to_vec();
            match polygons.last_mut() {
                Some(polygon) if ring_area_doubled(&points) < 0 => polygon.holes.push(points),
                _ => polygons.push(Polygon { exterior: points, holes: Vec::new() }),
            }
        }
        MultiPolygon(polygons)
    }

    /// The attributes of an element.
    pub fn element_attributes(&self, element: &ElementRecord) -> &'a [AttributeRecord] {
        &self.attributes[span(element.first_attribute, element.n_attributes)]
    }

    /// The attributes of a space.
    pub fn space_attributes(&self, space: &SpaceRecord) -> &'a [AttributeRecord] {
        &self.attributes[span(space.first_attribute, space.n_attributes)]
    }

    /// The names of an element's materials.
    pub fn element_materials(&self, element: &ElementRecord) -> impl Iterator<Item = &'a str> {
        self.materials[span(element.first_material, element.n_materials)].iter().map(|&t| self.text(t))
    }

    /// The panels of a door.
    pub fn door_panels(&self, door: &DoorRecord) -> &'a [DoorPanelRecord] {
        &self.panels[span(door.hanging.first_panel, door.hanging.n_panels)]
    }

    /// The parts of an element.
    pub fn element_parts(&self, element: &ElementRecord) -> &'a [PartRecord] {
        &self.parts[span(element.first_part, element.n_parts)]
    }

    /// The mesh parts of a terrain.
    pub fn terrain_parts(&self, terrain: &TerrainRecord) -> &'a [PartRecord] {
        &self.parts[span(terrain.first_part, terrain.n_parts)]
    }

    fn meshes(&self, first: u32, n: u32) -> impl Iterator<Item = MeshView<'a>> + Clone + use<'a> {
        let (vertices, triangles) = (self.vertices, self.triangles);
        self.parts[span(first, n)].iter().map(move |part| MeshView {
            vertices: &vertices[span(part.first_vertex, part.n_vertices)],
            triangles: &triangles[span(part.first_triangle, part.n_triangles)],
            closed: part.closed == 1,
        })
    }

    fn check_tags(&self) -> Result<(), ArchiveError> {
        check_tags(self.map_storeys.iter().map(|s| s.floor), "kind of floor")?;
        check_tags(self.elements.iter().map(|e| e.class), "class")?;
        check_tags(self.elements.iter().map(|e| e.ground), "ground class")?;
        check_tags(self.terrains.iter().map(|t| t.ground), "ground class")?;
        check_tags(self.doors.iter().map(|d| d.clear_width_from), "source of a clear width")?;
        check_tags(self.attributes.iter().map(|a| a.kind), "kind of attribute")?;
        check_diagnostics(self.diagnostics)?;
        let is_door_operation =
            |d: &DoorRecord| d.opens == 0 || DoorCapability::ALL.iter().any(|o| *o as u32 == d.opens);
        if self.doors.iter().all(is_door_operation) {
            Ok(())
        } else {
            Err(ArchiveError::Unknown { what: "way of opening a door" })
        }
    }

    /// Records that share what they point at would be walked again and again: all spans of a kind together are no longer than
    /// their section, so that every walk is linear in the archive.
    fn check_spans(&self) -> Result<(), ArchiveError> {
        let check = |lengths: &mut dyn Iterator<Item = u32>, section: usize, what| {
            let all: u64 = lengths.map(u64::from).sum();
            if all <= section as u64 { Ok(()) } else { Err(ArchiveError::Index { what }) }
        };
        let (elements, spaces) = (self.elements, self.spaces);
        let parts = || {
            let terrains = self.terrains.iter().map(|t| t.n_parts);
            elements.iter().map(|e| e.n_parts).chain(spaces.iter().map(|s| s.n_parts)).chain(terrains)
        };
        let attributes = || elements.iter().map(|e| e.n_attributes).chain(spaces.iter().map(|s| s.n_attributes));
        check(&mut parts(), self.parts.len(), "a mesh part")?;
        check(&mut self.parts.iter().map(|p| p.n_vertices), self.vertices.len(), "a vertex")?;
        check(&mut self.parts.iter().map(|p| p.n_triangles), self.triangles.len(), "a triangle")?;
        check(&mut spaces.iter().map(|s| s.n_rings), self.rings.len(), "a ring")?;
        check(&mut self.rings.iter().map(|r| r.n_points), self.points.len(), "a point")?;
        check(&mut attributes(), self.attributes.len(), "an attribute")?;
        check(&mut self.doors.iter().map(|d| d.hanging.n_panels), self.panels.len(), "a panel")?;
        check(&mut elements.iter().map(|e| e.n_materials), self.materials.len(), "a material")
    }

    fn check_meshes(&self) -> Result<(), ArchiveError> {
        let wrong = ArchiveError::Index { what: "a mesh" };
        for part in self.parts {
            let vertices = part.n_vertices;
            let inside = fits(part.first_vertex, vertices, self.vertices.len())
                && fits(part.first_triangle, part.n_triangles, self.triangles.len());
            if !inside
                || !self.triangles[span(part.first_triangle, part.n_triangles)].iter().flatten().all(|&i| i < vertices)
            {
                return Err(wrong);
            }
        }
        Ok(())
    }

    /// Coordinates whose differences do not overflow, bounds that are rectangles, boxes that are finite.
    fn check_numbers(&self) -> Result<(), ArchiveError> {
        let is_near = |c: &i32| c.unsigned_abs() <= MAX_COORDINATE_TENTHS;
        let is_box = |b: &BoxRecord| {
            let is_near = |c: &f64| c.abs() <= f64::from(MAX_COORDINATE_TENTHS);
            b.centre.iter().chain(&b.half).all(is_near) && b.axis.iter().all(|a| a.abs() <= 1.001)
        };
        let elements = self.elements.iter().flat_map(|e| e.min_tenths.iter().chain(&e.max_tenths));
        let storeys = self.map_storeys.iter().flat_map(|s| s.bounds_tenths.iter().chain([&s.floor_z_tenths]));
        let spaces = self.spaces.iter().flat_map(|s| [&s.floor_z_tenths, &s.height_tenths]);
        let openings = self.openings.iter().flat_map(|o| [&o.bottom_z_tenths, &o.top_z_tenths]);
        let terrains = self.terrains.iter().flat_map(|t| t.min_tenths.iter().chain(&t.max_tenths));
        let mut records = elements.chain(terrains).chain(storeys).chain(spaces).chain(openings);
        let axes = |d: &DoorRecord| d.hanging.along.iter().chain(&d.hanging.towards).all(|a| a.abs() <= 1.001);
        let boxes = self.openings.iter().map(|o| &o.plan).chain(self.doors.iter().map(|d| &d.passage));
        // Grids are laid around them.
        let is_rectangle = |[x0, y0, x1, y1]: [i32; 4]| x0 <= x1 && y0 <= y1;
        let whole = self.map_storeys.iter().all(|s| is_rectangle(s.bounds_tenths))
            && self.vertices.as_flattened().iter().all(is_near)
            && self.points.as_flattened().iter().all(is_near)
            && records.all(is_near)
            && boxes.into_iter().all(is_box)
            && self.doors.iter().all(axes);
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "a coordinate" }) }
    }

    fn check_indices(&self) -> Result<(), ArchiveError> {
        let (elements, spaces) = (self.elements.len(), self.spaces.len());
        // A site that was made without files counts as one of one file.
        let files = self.sources.len().max(1);
        let check = |ok: bool, what| if ok { Ok(()) } else { Err(ArchiveError::Index { what }) };
        check(
            self.elements.iter().all(|e| {
                fits(e.first_part, e.n_parts, self.parts.len())
                    && fits(e.first_attribute, e.n_attributes, self.attributes.len())
                    && fits(e.first_material, e.n_materials, self.materials.len())
                    && self.texts.has_list(e.supertypes)
                    && e.supertypes.count <= ElementRecord::MAX_SUPERTYPES
                    && optional(e.whole, elements)
                    && optional(e.storey, self.storeys.len())
                    && optional(e.space, spaces)
                    && optional(e.door, self.doors.len())
                    && optional(e.stair, self.stairs.len())
                    && (e.source as usize) < files
            }),
            "an element",
        )?;
        check(
            self.spaces.iter().all(|s| {
                fits(s.first_part, s.n_parts, self.parts.len())
                    && fits(s.first_attribute, s.n_attributes, self.attributes.len())
                    && fits(s.first_ring, s.n_rings, self.rings.len())
                    && optional(s.map_storey, self.map_storeys.len())
                    && optional(s.storey, self.storeys.len())
                    && (s.source as usize) < files
            }),
            "a space",
        )?;
        check(
            self.terrains
                .iter()
                .all(|t| fits(t.first_part, t.n_parts, self.parts.len()) && (t.source as usize) < files),
            "a terrain",
        )?;
        check(self.rings.iter().all(|r| fits(r.first_point, r.n_points, self.points.len())), "a ring")?;
        check(self.openings.iter().all(|o| optional(o.host, elements) && optional(o.filling, elements)), "an opening")?;
        check(
            self.doors.iter().all(|d| {
                (d.element as usize) < elements
                    && optional(d.opening, self.openings.len())
                    && d.spaces.iter().all(|&s| optional(s, spaces))
                    && d.beside.iter().all(|&beside| optional(beside, self.doors.len()))
                    && optional(d.map_storey, self.map_storeys.len())
                    && fits(d.hanging.first_panel, d.hanging.n_panels, self.panels.len())
            }),
            "a door",
        )?;
        check(self.stairs.iter().all(|s| (s.element as usize) < elements), "a stair")?;
        check(
            self.boundaries
                .iter()
                .chain(self.contacts)
                .all(|b| (b.space as usize) < spaces && (b.element as usize) < elements),
            "a space boundary",
        )?;
        check(self.storeys.iter().all(|s| optional(s.map_storey, self.map_storeys.len())), "a storey")
    }

    /// Numbers of what tasks may work on.
    pub(crate) fn link_targets(&self) -> LinkTargets {
        LinkTargets { elements: self.elements.len(), spaces: self.spaces.len(), storeys: self.storeys.len() }
    }

    fn check_texts(&self) -> Result<(), ArchiveError> {
        let storeys = self.storeys.iter().flat_map(|s| [s.global_id, s.name, s.why]);
        let map_storeys = self.map_storeys.iter().flat_map(|s| [s.global_id, s.name]);
        let elements = self.elements.iter().flat_map(|e| [e.global_id, e.name, e.ifc_type, e.predefined_type]);
        let spaces = self.spaces.iter().flat_map(|s| [s.global_id, s.name, s.long_name, s.predefined_type]);
        let attributes = self.attributes.iter().flat_map(|a| [a.set, a.name, a.text]);
        let diagnostics = self.diagnostics.iter().flat_map(DiagnosticRecord::texts);
        let others =
            self.sources.iter().flat_map(|s| [s.file, s.schema]).chain([self.head.earth_crs, self.head.earth_unit]);
        let others = others
            .chain(self.texts.listed().iter().copied())
            .chain(self.doors.iter().map(|d| d.operation))
            .chain(self.panels.iter().flat_map(|p| [p.operation, p.position]))
            .chain(self.openings.iter().map(|o| o.global_id))
            .chain(self.terrains.iter().flat_map(|t| [t.global_id, t.name, t.ifc_type]));
        let mut all = storeys.chain(map_storeys).chain(elements).chain(spaces).chain(attributes).chain(diagnostics);
        let whole = |text: Text| self.texts.has(text);
        if all.all(whole) && others.chain(self.materials.iter().copied()).all(whole) {
            Ok(())
        } else {
            Err(ArchiveError::Index { what: "a text" })
        }
    }
}

/// The farthest that a coordinate may be from the origin of the map, in tenths of a millimetre: 100 km, and differences of two
/// do not overflow.
/// Maximum height of the sill of a passage over the floor, such as a door's threshold, in tenths of a millimetre.
pub const MAX_SILL_TENTHS: i32 = TENTHS_PER_M / 10;

pub(crate) const MAX_COORDINATE_TENTHS: u32 = 1_000_000_000;

impl BoxRecord {
    /// The rectangle.
    pub fn to_box(self) -> OrientedBox {
        OrientedBox { centre: self.centre, axis: self.axis, half: self.half }
    }
}

impl From<OrientedBox> for BoxRecord {
    fn from(b: OrientedBox) -> Self {
        Self { centre: b.centre, axis: b.axis, half: b.half }
    }
}

impl ElementRecord {
    /// Supertypes of an element: more than any schema has.
    pub const MAX_SUPERTYPES: u32 = 32;

    /// Its class.
    pub fn class(&self) -> grid::Class {
        self.class.get()
    }

    /// True if all of these bits of [`element_flags`] are set.
    pub fn has(&self, flags: u32) -> bool {
        self.flags & flags == flags
    }
}

impl SpaceRecord {
    /// True if all of these bits of [`space_flags`] are set.
    pub fn has(&self, flags: u32) -> bool {
        self.flags & flags == flags
    }
}
