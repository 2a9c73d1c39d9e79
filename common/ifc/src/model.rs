//! The model of one file: elements, spaces, storeys, doors, stairs, properties; SI units, IFC world coordinates.

use crate::schedule::Schedule;
use diagnostics::Named;
use frames::EarthFromWorld;
use serde::{Deserialize, Serialize};

/// One file, read.
#[derive(Debug)]
pub struct Model {
    /// Source file.
    pub source: Source,
    /// Georeference of the file; never applied to coordinates.
    pub georeference: Georeference,
    /// GlobalId and name of what contains the storeys: building, else site, else project.
    pub container: Named,
    /// All IfcBuildingStorey, by GlobalId.
    pub storeys: Vec<Storey>,
    /// All IfcElement that can be an obstacle or carry floor, by GlobalId.
    pub elements: Vec<Element>,
    /// All IfcSpace, by GlobalId.
    pub spaces: Vec<Space>,
    /// All IfcOpeningElement that void an element, by GlobalId.
    pub openings: Vec<Opening>,
    /// Shapes of IfcSite, IfcRoad and IfcRoadPart themselves, each by GlobalId.
    pub terrains: Vec<Terrain>,
    /// IfcRelSpaceBoundary: which elements bound which spaces; indices into `spaces` and `elements`, sorted, unique.
    pub boundaries: Vec<SpaceBoundary>,
    /// Tasks, calendars, and what the tasks work on.
    pub schedule: Schedule,
}

/// Facts of the file itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// FILE_SCHEMA as written, e.g. `IFC4X3_ADD2`.
    pub schema: String,
    /// Metres per length unit of the file; 0 if it is unknown and the file has no geometry.
    pub length_unit_m: f64,
}

/// IfcMapConversion, IfcProjectedCRS and true north.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Georeference {
    /// The map conversion, if the file has one.
    pub map_conversion: Option<MapConversion>,
    /// Direction of true north in the world's plane, if the file gives one.
    pub true_north: Option<[f64; 2]>,
}

/// Where the world lies in a projected system, in metres: `p_map = origin + R(x_axis) (scale * p_world)`.
#[derive(Debug, Clone, PartialEq)]
pub struct MapConversion {
    /// Name of the projected system, e.g. `EPSG:25832`; empty if absent.
    pub crs: String,
    /// Name of the unit in which the file writes eastings, northings and height, e.g. `MILLIMETRE`.
    pub map_unit: String,
    /// Metres per that unit.
    pub map_unit_m: f64,
    /// Eastings, northings, orthogonal height of the world's origin, in metres.
    pub origin_m: [f64; 3],
    /// The world's x axis in eastings and northings, of length 1.
    pub x_axis: [f64; 2],
    /// Metres on the map per metre of the world, along the world's three axes.
    pub scale: [f64; 3],
}

impl MapConversion {
    /// The map from the world to the projected system.
    pub fn earth_from_world(&self) -> EarthFromWorld {
        EarthFromWorld::new(self.origin_m, self.x_axis, self.scale)
    }
}

/// One IfcBuildingStorey.
#[derive(Debug, Clone)]
pub struct Storey {
    /// Identity.
    pub id: Named,
    /// Height of its placement in the world, in metres; `None` without a usable placement.
    pub placement_z_m: Option<f64>,
    /// Elevation in metres, as written; often wrong.
    pub elevation_m: Option<f64>,
}

/// An element that can be an obstacle, a door, or floor.
#[derive(Debug)]
pub struct Element {
    /// Identity.
    pub id: Named,
    /// Entity name as the schema spells it, e.g. `IfcWallStandardCase`.
    pub ifc_type: &'static str,
    /// Supertypes of `ifc_type`, itself first: `IfcWallStandardCase`, `IfcWall`, `IfcBuildingElement` ..
    pub supertypes: Vec<&'static str>,
    /// PredefinedType of the occurrence, else of its type; ObjectType where that says USERDEFINED; empty if absent.
    pub predefined_type: String,
    /// ObjectType, else the name of its type; empty if absent.
    pub object_type: String,
    /// Index of the storey that contains it, through aggregates, nests, and hosts of openings it fills.
    pub storey: Option<usize>,
    /// Index of the space that contains it directly.
    pub space: Option<usize>,
    /// Index of the element it is a part of (IfcRelAggregates, IfcRelNests), nearest first.
    pub whole: Option<usize>,
    /// Index of the opening it fills.
    pub fills: Option<usize>,
    /// Object placement in the world.
    pub placement: Option<Placement>,
    /// Its body.
    pub geometry: Geometry,
    /// IfcDoor only.
    pub door: Option<Door>,
    /// IfcStairFlight only (or an IfcStair that carries the figures).
    pub stair: Option<Stair>,
    /// Property sets of the occurrence, then those of its type that the occurrence does not override, then what it belongs
    /// to (`MEMBERSHIP_SETS`).
    pub properties: Vec<Property>,
    /// Names of its materials: of the occurrence, else of its type; through layers, profiles, constituents and lists.
    pub materials: Vec<String>,
}

/// Right-handed or mirrored frame of an IfcLocalPlacement in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Origin in metres.
    pub origin_m: [f64; 3],
    /// Unit x, y, z axes.
    pub axes: [[f64; 3]; 3],
}

/// Body of a product.
#[derive(Debug, Default)]
pub struct Geometry {
    /// One part per representation item.
    pub parts: Vec<MeshPart>,
    /// Status of the parts.
    pub status: GeometryStatus,
    /// How its openings were cut.
    pub cut: CutPath,
}

/// How the openings of an element were cut.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum CutPath {
    /// It has none, or no body.
    #[default]
    None,
    /// As polygon differences in the planes of its faces.
    Polygons,
    /// By the kernel.
    Kernel,
    /// Some were left out, because that would take too long.
    LeftOut,
}

/// Status of a body.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum GeometryStatus {
    /// No body representation: the product is no obstacle.
    #[default]
    None,
    /// Meshed as modelled.
    Meshed,
    /// The body failed, a box that encloses it stands in.
    BoundingBox {
        /// Why, in words.
        why: String,
    },
    /// The body failed and nothing is known of its extent.
    Failed {
        /// Why, in words.
        why: String,
    },
}

/// Triangles in the world: `origin_m + position`, outward faces counter-clockwise.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct MeshPart {
    /// Origin in metres; positions are small against it.
    pub origin_m: [f64; 3],
    /// Vertex positions relative to the origin, in metres.
    pub positions_m: Vec<[f32; 3]>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
    /// Red, green, blue and opacity of the style that the file gives the item or its material; `None` if it gives none.
    pub colour: Option<[u8; 4]>,
}

impl MeshPart {
    /// The vertices in the world, in metres.
    pub fn points_m(&self) -> impl Iterator<Item = [f64; 3]> {
        self.positions_m.iter().map(|p| [0, 1, 2].map(|k| self.origin_m[k] + f64::from(p[k])))
    }
}

impl Geometry {
    /// The vertices of all parts in the world, in metres.
    pub fn points_m(&self) -> impl Iterator<Item = [f64; 3]> {
        self.parts.iter().flat_map(MeshPart::points_m)
    }
}

/// A door's attributes; lengths in metres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Door {
    /// OperationType as the schema spells it, occurrence over type, USERDEFINED resolved to its text; empty if absent.
    /// Mirrored placements have left and right swapped already.
    pub operation_type: String,
    /// OverallWidth.
    pub overall_width_m: Option<f64>,
    /// OverallHeight.
    pub overall_height_m: Option<f64>,
    /// LiningThickness of IfcDoorLiningProperties (of the occurrence or its type).
    pub lining_thickness_m: Option<f64>,
    /// PanelDepth of the first IfcDoorPanelProperties: the leaf's thickness.
    pub panel_depth_m: Option<f64>,
    /// Its panels by IfcDoorPanelProperties; mirrored placements have left and right swapped already.
    pub panels: Vec<DoorPanel>,
    /// Right-handed frame in which the operation type is meant: origin at a jamb, x along the width, swinging leaves
    /// open towards +y. The placement, unless the operation type is of a style that the occurrence turns or mirrors.
    pub frame: Option<Placement>,
}

/// IfcDoorPanelProperties.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DoorPanel {
    /// PanelOperation, e.g. `SWINGING`; empty if absent.
    pub operation: String,
    /// PanelPosition: `LEFT`, `MIDDLE` or `RIGHT`; empty if absent.
    pub position: String,
    /// PanelWidth: its share of the door's width.
    pub share: Option<f64>,
}

/// A stair flight's attributes; lengths in metres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stair {
    /// NumberOfRisers (NumberOfRiser in IFC2X3).
    pub n_risers: Option<u32>,
    /// NumberOfTreads.
    pub n_treads: Option<u32>,
    /// RiserHeight.
    pub riser_height_m: Option<f64>,
    /// TreadLength.
    pub tread_length_m: Option<f64>,
}

/// One property of one set.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Name of the IfcPropertySet, or one of `MEMBERSHIP_SETS`.
    pub set: String,
    /// Name of the property.
    pub name: String,
    /// Its value.
    pub value: PropertyValue,
}

/// A single, enumerated, list or bounded value; lists are joined with `, `.
#[derive(Debug, Clone, PartialEq)]
pub enum PropertyValue {
    /// Any text, enumeration values included.
    Text(String),
    /// A number in the file's units, as written.
    Number(f64),
    /// True or false.
    Boolean(bool),
}

/// One IfcSpace.
#[derive(Debug)]
pub struct Space {
    /// Identity; `name` is often a number.
    pub id: Named,
    /// LongName: what people call it; empty if absent.
    pub long_name: String,
    /// PredefinedType (or InteriorOrExteriorSpace in IFC2X3), e.g. `INTERNAL`, `EXTERNAL`, `GFA`; empty if absent.
    pub predefined_type: String,
    /// ObjectType, else the name of its type; empty if absent.
    pub object_type: String,
    /// True if it is decomposed into other spaces.
    pub has_parts: bool,
    /// Index of its storey.
    pub storey: Option<usize>,
    /// True if any IfcRelSpaceBoundary names it.
    pub has_boundaries: bool,
    /// Its body.
    pub geometry: Geometry,
    /// Property sets, and what it belongs to, as those of elements.
    pub properties: Vec<Property>,
}

/// One IfcOpeningElement that voids an element.
#[derive(Debug)]
pub struct Opening {
    /// Identity.
    pub id: Named,
    /// Index of the element that it voids; `None` if that is not in `elements`.
    pub host: Option<usize>,
    /// Index of the element that fills it.
    pub filling: Option<usize>,
    /// Its body.
    pub geometry: Geometry,
}

/// The shape of an IfcSite, IfcRoad or IfcRoadPart: ground that is no element.
#[derive(Debug)]
pub struct Terrain {
    /// Identity.
    pub id: Named,
    /// Entity name as the schema spells it, e.g. `IfcSite`.
    pub ifc_type: &'static str,
    /// PredefinedType; empty if absent.
    pub predefined_type: String,
    /// Its body.
    pub geometry: Geometry,
}

/// An element bounds a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SpaceBoundary {
    /// Index into [`Model::spaces`].
    pub space: usize,
    /// Index into [`Model::elements`].
    pub element: usize,
}
