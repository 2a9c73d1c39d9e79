//! Records of the `site` archive.

use crate::ground_records::GroundClass;
use crate::tag::Tag;
use crate::{Text, TextList};
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use grid::Class;

/// Data of the whole site: one record.
#[derive(Debug, Clone, Copy, Default, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct SiteHead {
    /// Translation of `map_from_world` in metres.
    pub map_from_world_m: [f64; 3],
    /// Turn of `map_from_world` about Z.
    pub map_from_world_yaw_rad: f64,
    /// Eastings, northings, orthogonal height of the origin of `world` in the projected system, in metres.
    pub earth_m: [f64; 3],
    /// The x axis of `world` in eastings and northings, of length 1.
    pub earth_x_axis: [f64; 2],
    /// Metres in the projected system per metre of `world`, along the axes of `world`.
    pub earth_scale: [f64; 3],
    /// Metres per unit in which the file writes eastings, northings and height.
    pub earth_unit_m: f64,
    /// Direction of true north in `world`.
    pub true_north: [f64; 2],
    /// Name of the projected system.
    pub earth_crs: Text,
    /// Name of the unit in which the file writes eastings, northings and height.
    pub earth_unit: Text,
    /// 1 if the file has a map conversion.
    pub has_earth: u32,
    /// 1 if the file says where true north is.
    pub has_true_north: u32,
    /// Counts changes of the map frame of this site; from 1.
    pub frame_epoch: u32,
    /// 1 if the files hold tasks or a work schedule.
    pub has_schedule: u32,
}
const _: () = assert!(size_of::<SiteHead>() == 152);

/// A file of the site.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct SourceRecord {
    /// Base name.
    pub file: Text,
    /// FILE_SCHEMA as written.
    pub schema: Text,
    /// sha256 of the file's bytes.
    pub sha256: [u8; 32],
    /// Metres per length unit of the file.
    pub length_unit_m: f64,
}
const _: () = assert!(size_of::<SourceRecord>() == 56);

/// An IfcBuildingStorey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct StoreyRecord {
    /// GlobalId.
    pub global_id: Text,
    /// Name.
    pub name: Text,
    /// Why it is not mapped, or joined with another; empty if it gave its name to a map storey.
    pub why: Text,
    /// Height of its placement in `map`, if it has one.
    pub placement_z_tenths: i32,
    /// 1 if it has a placement.
    pub has_placement: u32,
    /// The map storey it belongs to, or `NONE`.
    pub map_storey: u32,
    /// Index of its file.
    pub source: u32,
}
const _: () = assert!(size_of::<StoreyRecord>() == 40);

/// A storey that has a map: those of the files from low to high, then their levels at other heights from low to high.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct MapStoreyRecord {
    /// GlobalId of the storey it is named after, or is a level of; of the building where the file has no storeys.
    pub global_id: Text,
    /// Name; of a level with how much higher it lies than the storey's map: `EG -0.45 m`.
    pub name: Text,
    /// Height of the finished floor in `map`.
    pub floor_z_tenths: i32,
    /// Where the floor comes from.
    pub floor: Tag<FloorKind>,
    /// Plan bounds of what its grid holds: x min, y min, x max, y max.
    pub bounds_tenths: [i32; 4],
}
const _: () = assert!(size_of::<MapStoreyRecord>() == 40);

/// Where a storey's floor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum FloorKind {
    /// Upward faces of slabs, coverings, landings, ramps, foundations.
    Built = 1,
    /// The spaces' floors: the model has no faces under them.
    AssumedFromSpaces = 2,
    /// What obstacles enclose: the model has walls, and neither floor faces nor spaces.
    AssumedFromEnclosure = 3,
    /// Nowhere: the model has neither floor faces nor spaces nor walls.
    Missing = 4,
    /// The ground outdoors at whatever height: terrain, roads, and floor that one gets to from there.
    Ground = 5,
}

impl FloorKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Built => "built",
            Self::AssumedFromSpaces | Self::AssumedFromEnclosure => "assumed",
            Self::Missing => "none",
            Self::Ground => "ground",
        }
    }
}

/// An element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct ElementRecord {
    /// STEP id in its file.
    pub step_id: u64,
    /// GlobalId.
    pub global_id: Text,
    /// Name.
    pub name: Text,
    /// Entity name, e.g. `IfcWallStandardCase`.
    pub ifc_type: Text,
    /// The entity and its supertypes, `IfcWallStandardCase`, `IfcWall`, `IfcBuildingElement` .., at most
    /// [`ElementRecord::MAX_SUPERTYPES`]; elements of an entity share them.
    pub supertypes: TextList,
    /// PredefinedType.
    pub predefined_type: Text,
    /// Lower corner of its body; meaningless without parts.
    pub min_tenths: [i32; 3],
    /// Upper corner of its body.
    pub max_tenths: [i32; 3],
    /// First of its mesh parts.
    pub first_part: u32,
    /// Number of its mesh parts.
    pub n_parts: u32,
    /// First of its attributes.
    pub first_attribute: u32,
    /// Number of its attributes.
    pub n_attributes: u32,
    /// First of its materials.
    pub first_material: u32,
    /// Number of its materials.
    pub n_materials: u32,
    /// Element it is a part of, or `NONE`.
    pub whole: u32,
    /// Storey that contains it, or `NONE`.
    pub storey: u32,
    /// Space that contains it directly, or `NONE`.
    pub space: u32,
    /// Door record, or `NONE`.
    pub door: u32,
    /// Stair record, or `NONE`.
    pub stair: u32,
    /// Index of its file.
    pub source: u32,
    /// Bits of [`element_flags`].
    pub flags: u32,
    /// Its class.
    pub class: Tag<Class>,
    /// What its upward faces are to whoever walks or drives on them.
    pub ground: Tag<GroundClass>,
    /// Zero.
    pub reserved: [u8; 2],
}
const _: () = assert!(size_of::<ElementRecord>() == 128);

/// Ground that is no element: the shape of an IfcSite, an IfcRoad or a part of one. It is there at every plan time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TerrainRecord {
    /// STEP id in its file.
    pub step_id: u64,
    /// GlobalId.
    pub global_id: Text,
    /// Name.
    pub name: Text,
    /// Entity name, e.g. `IfcSite`.
    pub ifc_type: Text,
    /// Lower corner of its body.
    pub min_tenths: [i32; 3],
    /// Upper corner of its body.
    pub max_tenths: [i32; 3],
    /// First of its mesh parts.
    pub first_part: u32,
    /// Number of its mesh parts.
    pub n_parts: u32,
    /// Index of its file.
    pub source: u32,
    /// What its faces are.
    pub ground: Tag<GroundClass>,
    /// Zero.
    pub reserved: [u8; 3],
}
const _: () = assert!(size_of::<TerrainRecord>() == 72);

/// Bits of [`ElementRecord::flags`].
pub mod element_flags {
    /// Maps take its upward faces for floor: [`crate::GroundClass::is_floor_of_maps`] of its class.
    pub const FLOOR: u32 = 1;
    /// It lets light through: a lidar does not see it.
    pub const GLASS: u32 = 2;
    /// Its body failed, or is a door's that has none: a box stands in.
    pub const BOUNDING_BOX: u32 = 4;
    /// It has a body that could not be made, and nothing stands in.
    pub const FAILED: u32 = 8;
    /// A way to other storeys whose plan is never assumed to be floor: stair, ramp, escalator, lift.
    pub const VERTICAL: u32 = 16;
    /// Its openings were cut as polygon differences in the planes of its faces.
    pub const CUT_AS_POLYGONS: u32 = 32;
    /// Its openings were cut by the kernel that meshes.
    pub const CUT_BY_KERNEL: u32 = 64;
    /// Some of its openings were not cut, because that would have taken too long.
    pub const PARTLY_CUT: u32 = 128;
}

/// A mesh part: one representation item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct PartRecord {
    /// First of its vertices.
    pub first_vertex: u32,
    /// Number of its vertices.
    pub n_vertices: u32,
    /// First of its triangles, whose indices count from `first_vertex`.
    pub first_triangle: u32,
    /// Number of its triangles.
    pub n_triangles: u32,
    /// 1 if every edge is passed as often in either direction.
    pub closed: u32,
    /// Red, green, blue and opacity that the model gives it, a byte each from the highest; 0 if it gives none.
    pub colour: u32,
}
const _: () = assert!(size_of::<PartRecord>() == 24);

/// A space.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct SpaceRecord {
    /// GlobalId.
    pub global_id: Text,
    /// Name, often a number.
    pub name: Text,
    /// LongName.
    pub long_name: Text,
    /// PredefinedType.
    pub predefined_type: Text,
    /// Area of its floor polygon in square metres.
    pub area_m2: f64,
    /// Area centroid of its floor polygon in `map`, in metres.
    pub centroid_m: [f64; 2],
    /// First ring of its floor polygon.
    pub first_ring: u32,
    /// Number of rings: exteriors counter-clockwise, holes clockwise.
    pub n_rings: u32,
    /// First of its mesh parts.
    pub first_part: u32,
    /// Number of its mesh parts.
    pub n_parts: u32,
    /// First of its attributes.
    pub first_attribute: u32,
    /// Number of its attributes.
    pub n_attributes: u32,
    /// Height of its floor in `map`.
    pub floor_z_tenths: i32,
    /// Its height.
    pub height_tenths: i32,
    /// Map storey it belongs to, or `NONE`.
    pub map_storey: u32,
    /// Storey that contains it, or `NONE`.
    pub storey: u32,
    /// Index of its file.
    pub source: u32,
    /// Bits of [`space_flags`].
    pub flags: u32,
}
const _: () = assert!(size_of::<SpaceRecord>() == 104);

/// Bits of [`SpaceRecord::flags`].
pub mod space_flags {
    /// A gross area, or made of other spaces: for the record only.
    pub const METADATA_ONLY: u32 = 1;
    /// Outdoors: it gets no waypoint.
    pub const EXTERNAL: u32 = 2;
    /// A lift shaft, a riser or a pit: it is on no map storey, and nobody walks in it.
    pub const SHAFT: u32 = 4;
    /// It has no slab, and its floor is assumed.
    pub const ASSUMED_FLOOR: u32 = 8;
}

/// A ring of a polygon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct RingRecord {
    /// First of its points.
    pub first_point: u32,
    /// Number of its points.
    pub n_points: u32,
}
const _: () = assert!(size_of::<RingRecord>() == 8);

/// A rectangle at an angle in `map`, tenths of a millimetre: `geometry::OrientedBox`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct BoxRecord {
    /// Middle.
    pub centre: [f64; 2],
    /// Unit direction of the first side: along the wall.
    pub axis: [f64; 2],
    /// Half lengths: along the wall, through it.
    pub half: [f64; 2],
}
const _: () = assert!(size_of::<BoxRecord>() == 48);

/// An opening that voids an element.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct OpeningRecord {
    /// GlobalId.
    pub global_id: Text,
    /// Element that it voids, or `NONE`.
    pub host: u32,
    /// Element that fills it, or `NONE`.
    pub filling: u32,
    /// Lowest point.
    pub bottom_z_tenths: i32,
    /// Highest point.
    pub top_z_tenths: i32,
    /// Its plan inside the wall; half lengths 0 if it has no body, or is no opening of a wall.
    pub plan: BoxRecord,
}
const _: () = assert!(size_of::<OpeningRecord>() == 72);

impl OpeningRecord {
    /// Half the depth in its wall of an opening that is more than contact, in tenths of a millimetre: 0.5 mm.
    pub const MIN_HALF_DEPTH: f64 = 5.0;

    /// True if it lies in its wall, not only against it.
    pub fn is_in_wall(&self) -> bool {
        self.plan.half[0] > 0.0 && self.plan.half[1] >= Self::MIN_HALF_DEPTH
    }
}

/// A door.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct DoorRecord {
    /// Its element.
    pub element: u32,
    /// Opening it fills, or `NONE`.
    pub opening: u32,
    /// Spaces it joins, or `NONE`.
    pub spaces: [u32; 2],
    /// Operation type as the schema spells it; empty if unknown.
    pub operation: Text,
    /// [`crate::DoorCapability`] as a number; 0 if it does not open.
    pub opens: u32,
    /// Where the clear width comes from.
    pub clear_width_from: Tag<ClearWidth>,
    /// OverallWidth, else the width of its opening or body, in metres.
    pub overall_width_m: f64,
    /// OverallHeight, else the height of its body, in metres.
    pub overall_height_m: f64,
    /// Width between what remains when it is open, in metres.
    pub clear_width_m: f64,
    /// Its passage: the opening's width, or its part of an opening of several doors, or the part of its moving leaves beside a
    /// fixed one, and the wall's thickness.
    pub passage: BoxRecord,
    /// How it hangs.
    pub hanging: DoorHanging,
    /// The doors that follow it against and along the direction of its passage without a mullion or anything else between
    /// them, or `NONE`: leaves of one opening, whose clear widths count together.
    pub beside: [u32; 2],
    /// Map storey on which it stands, by the height of its threshold, or `NONE` in a site without any.
    pub map_storey: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<DoorRecord>() == 176);

/// How a door hangs: what its operation type is said of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct DoorHanging {
    /// Unit direction in plan of the door's x axis, along its width: left is where it begins. Zero if the door has no frame.
    pub along: [f64; 2],
    /// Unit direction in plan of the door's y axis, to which it swings.
    pub towards: [f64; 2],
    /// Width of the lining at each side and above, 0 if unknown.
    pub lining_m: f64,
    /// Thickness of the leaf, 0 if unknown.
    pub leaf_m: f64,
    /// First of its panels.
    pub first_panel: u32,
    /// Number of its panels.
    pub n_panels: u32,
}
const _: () = assert!(size_of::<DoorHanging>() == 56);

/// A panel of a door by IfcDoorPanelProperties.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct DoorPanelRecord {
    /// PanelOperation.
    pub operation: Text,
    /// PanelPosition.
    pub position: Text,
    /// PanelWidth: its share of the door's width; 0 if unknown.
    pub share: f64,
}
const _: () = assert!(size_of::<DoorPanelRecord>() == 24);

/// Where a door's clear width comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum ClearWidth {
    /// Overall width less lining and leaf.
    LiningAndPanel = 1,
    /// Overall width less 0.10 m: the model says no more.
    Assumed = 2,
}

/// A stair or a flight of it.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct StairRecord {
    /// Its element.
    pub element: u32,
    /// Risers, or `NONE`.
    pub n_risers: u32,
    /// Treads, or `NONE`.
    pub n_treads: u32,
    /// Bits of [`stair_flags`].
    pub flags: u32,
    /// Riser height in metres, 0 if unknown.
    pub riser_height_m: f64,
    /// Tread length in metres, 0 if unknown.
    pub tread_length_m: f64,
}
const _: () = assert!(size_of::<StairRecord>() == 32);

/// Bits of [`StairRecord::flags`]: what is measured on its body, because the file has no figure or one that cannot be.
pub mod stair_flags {
    /// The number of risers.
    pub const RISERS_MEASURED: u32 = 1;
    /// The riser height.
    pub const RISER_HEIGHT_MEASURED: u32 = 2;
    /// The tread length.
    pub const TREAD_LENGTH_MEASURED: u32 = 4;
}

/// An element bounds or touches a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct BoundaryRecord {
    /// The space.
    pub space: u32,
    /// The element.
    pub element: u32,
}
const _: () = assert!(size_of::<BoundaryRecord>() == 8);

/// Sets of attributes that say what an element or a space belongs to: groups by the entity of IFC, with Name and LongName;
/// classifications by the name of their system. An element of several groups has several attributes of one name.
pub const MEMBERSHIP_SETS: [&str; 5] = ["IfcZone", "IfcSystem", "IfcGroup", "IfcSpatialZone", "IfcClassification"];

/// A property of an element or a space.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct AttributeRecord {
    /// Property set, or one of [`MEMBERSHIP_SETS`].
    pub set: Text,
    /// Property.
    pub name: Text,
    /// Its value as text; empty if it is a number or boolean.
    pub text: Text,
    /// Its value as a number, in the file's units; 1 for true.
    pub number: f64,
    /// What the value is.
    pub kind: Tag<AttributeKind>,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<AttributeRecord>() == 40);

/// What an attribute's value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum AttributeKind {
    /// Text.
    Text = 1,
    /// A number.
    Number = 2,
    /// True or false.
    Boolean = 3,
}
