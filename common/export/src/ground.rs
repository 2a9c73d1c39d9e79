//! `ground.ply` and `ground.json`: the walkable surface as a mesh with its classes and slopes, and what its numbers mean.
//!
//! The mesh is binary PLY in `map`, metres, z up; coordinates are doubles, because single ones lose millimetres far from the origin.
//! Each face has `class` (the number of its ground class), `slope` (radians), `element` (index into `elements` of `ground.json`) and
//! `surface` (index into `surfaces` there).

use crate::input::ExportFile;
use crate::json;
use crate::text::rounded;
use frames::metres;
use messages::{Ground, GroundBodyRecord, GroundClass, NONE, Site};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// What the numbers in `ground.ply` mean, and where one gets from a surface to another.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct GroundDocument {
    /// Version of this document.
    version: u32,
    /// Name of the frame of all coordinates.
    frame: &'static str,
    /// Counts changes of the frame, from 1.
    frame_epoch: u32,
    /// The plan time; null if everything is built.
    plan_time: Option<String>,
    /// Steeper faces are not in the surface.
    max_slope_rad: f64,
    /// The numbers of classes.
    classes: Vec<GroundClassEntry>,
    /// What carries the surface, by the number that faces have.
    elements: Vec<GroundElement>,
    /// Connected surfaces of one class, from the largest to the smallest.
    surfaces: Vec<GroundSurface>,
    /// Where two surfaces meet.
    connections: Vec<GroundLink>,
}

/// A ground class.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct GroundClassEntry {
    /// Its number.
    id: u8,
    /// Its name.
    name: &'static str,
}

/// An element that carries ground, or the shape of a site or road.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct GroundElement {
    /// GlobalId.
    global_id: String,
    /// Entity, such as `IfcSlab` or `IfcSite`.
    ifc_type: String,
    /// Name.
    name: String,
    /// Its ground class.
    class: &'static str,
}

/// A connected surface.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct GroundSurface {
    /// Class of its faces.
    class: &'static str,
    /// Its area in plan.
    area_m2: f64,
    /// Number of its faces.
    n_faces: u32,
    /// Its lower corner in `map`.
    min_m: [f64; 3],
    /// Its upper corner in `map`.
    max_m: [f64; 3],
}

/// A place where two surfaces meet.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct GroundLink {
    /// The two surfaces.
    surfaces: [u32; 2],
    /// How one gets over it: `shared_edge`, `step`, `stair`, `ramp`.
    kind: &'static str,
    /// How much higher the second surface lies; negative if it is lower.
    step_m: f64,
    /// Length of the common border.
    length_m: f64,
    /// A place on it in `map`.
    at_m: [f64; 3],
}

/// Both files of the ground of a site, whose bodies are those of the site.
pub fn ground_files(site: &Site<'_>, ground: &Ground<'_>) -> Vec<ExportFile> {
    let document = GroundDocument::of(site, ground);
    vec![ExportFile::new("ground.ply", ply(ground)), ExportFile::new("ground.json", json::text(&document))]
}

impl GroundDocument {
    fn of(site: &Site<'_>, ground: &Ground<'_>) -> Self {
        let point = |p: [i32; 3]| p.map(|c| rounded(metres(c)));
        let surfaces = ground.surfaces.iter().map(|s| GroundSurface {
            class: s.class.get().name(),
            area_m2: rounded(s.area_m2),
            n_faces: s.n_faces,
            min_m: point(s.min_tenths),
            max_m: point(s.max_tenths),
        });
        let connections = ground.connections.iter().map(|c| GroundLink {
            surfaces: c.surfaces,
            kind: c.kind.get().name(),
            step_m: rounded(metres(c.step_tenths)),
            length_m: rounded(f64::from(c.length_m)),
            at_m: point(c.at_tenths),
        });
        let class = |class: GroundClass| GroundClassEntry { id: class as u8, name: class.name() };
        Self {
            version: 1,
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            plan_time: messages::plan_time(ground.head.plan_time_s).map(|t| t.to_string()),
            max_slope_rad: ground.head.max_slope_rad,
            classes: GroundClass::ALL.into_iter().map(class).collect(),
            elements: ground.bodies.iter().map(|body| GroundElement::of(site, body)).collect(),
            surfaces: surfaces.collect(),
            connections: connections.collect(),
        }
    }
}

impl GroundElement {
    fn of(site: &Site<'_>, body: &GroundBodyRecord) -> Self {
        let [global_id, ifc_type, name] = if body.element == NONE {
            let terrain = &site.terrains[body.terrain as usize];
            [terrain.global_id, terrain.ifc_type, terrain.name]
        } else {
            let element = &site.elements[body.element as usize];
            [element.global_id, element.ifc_type, element.name]
        };
        let text = |text| site.text(text).to_owned();
        Self { global_id: text(global_id), ifc_type: text(ifc_type), name: text(name), class: body.class.get().name() }
    }
}

/// The mesh as binary PLY.
fn ply(ground: &Ground<'_>) -> Vec<u8> {
    let mut head = String::from("ply\nformat binary_little_endian 1.0\n");
    head.push_str("comment metres in the frame map, z up; ground.json has the classes, elements and surfaces\n");
    let (n_vertices, n_faces) = (ground.vertices.len(), ground.faces.len());
    let _ = write!(head, "element vertex {n_vertices}\nproperty double x\nproperty double y\nproperty double z\n");
    let _ = write!(head, "element face {n_faces}\nproperty list uchar int vertex_indices\n");
    head.push_str(
        "property uchar class\nproperty float slope\nproperty int element\nproperty int surface\nend_header\n",
    );
    let mut bytes = head.into_bytes();
    bytes.reserve(24 * n_vertices + 26 * n_faces);
    for vertex in ground.vertices {
        vertex.iter().for_each(|c| bytes.extend(metres(*c).to_le_bytes()));
    }
    for face in ground.faces {
        bytes.push(3);
        face.vertices.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes.push(face.class.get() as u8);
        bytes.extend(face.slope_rad.to_le_bytes());
        bytes.extend(face.body.to_le_bytes());
        bytes.extend(face.surface.to_le_bytes());
    }
    bytes
}
