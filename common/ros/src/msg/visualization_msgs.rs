//! Markers of viewers.

use crate::interface::ros_message;
use crate::msg::builtin_interfaces::Duration;
use crate::msg::geometry_msgs::{Point, Pose, Vector3};
use crate::msg::sensor_msgs::CompressedImage;
use crate::msg::std_msgs::{ColorRGBA, Header};
use serde::{Deserialize, Serialize};

/// A place on a texture, from 0 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are coordinates")]
pub struct UVCoordinate {
    pub u: f32,
    pub v: f32,
}
ros_message!(
    UVCoordinate,
    visualization_msgs / msg / UVCoordinate,
    "f27f7ed21fe360c6066944f856b801a0c0d1e94e815b6886444b42d90b196a26"
);

/// A mesh that is sent along.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name; the extension says the format.
    pub filename: String,
    /// The file.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}
ros_message!(
    MeshFile,
    visualization_msgs / msg / MeshFile,
    "7710ece15a148fb7c9b546364cfb215bb06098087bd6394fe5b73a493508f8c4"
);

/// A shape, a line or a text in a viewer, named by `ns` and `id`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// When and in which frame.
    pub header: Header,
    /// Namespace of the id.
    pub ns: String,
    /// Number in the namespace.
    pub id: i32,
    /// What it is: [`Self::ARROW`] and others.
    pub r#type: i32,
    /// What becomes of it: [`Self::ADD`], [`Self::DELETE`] or [`Self::DELETEALL`].
    pub action: i32,
    /// Where it is; of lists of points, where their origin is.
    pub pose: Pose,
    /// Size in metres; of lines the width, of texts the height of a letter in z.
    pub scale: Vector3,
    /// Colour of all of it, where `colors` gives none.
    pub color: ColorRGBA,
    /// How long it is shown; zero is for ever.
    pub lifetime: Duration,
    /// True if it moves with its frame.
    pub frame_locked: bool,
    /// Points of lines and lists.
    pub points: Vec<Point>,
    /// Colours of the points.
    pub colors: Vec<ColorRGBA>,
    /// URL of a texture.
    pub texture_resource: String,
    /// A texture that is sent along.
    pub texture: CompressedImage,
    /// Place of each point on the texture.
    pub uv_coordinates: Vec<UVCoordinate>,
    /// The text.
    pub text: String,
    /// URL of a mesh.
    pub mesh_resource: String,
    /// A mesh that is sent along.
    pub mesh_file: MeshFile,
    /// True if the mesh has its own colours.
    pub mesh_use_embedded_materials: bool,
}
ros_message!(
    Marker,
    visualization_msgs / msg / Marker,
    "45b13ccf791f225962bf74e746f9644518855d783a6f42ba0cc14fde2b4f3ce0",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
    geometry_msgs / msg / Vector3,
    std_msgs / msg / ColorRGBA,
    builtin_interfaces / msg / Duration,
    sensor_msgs / msg / CompressedImage,
    visualization_msgs / msg / UVCoordinate,
    visualization_msgs / msg / MeshFile,
);

#[expect(missing_docs, reason = "the constants are those of the interface definition")]
impl Marker {
    pub const ARROW: i32 = 0;
    pub const CUBE: i32 = 1;
    pub const SPHERE: i32 = 2;
    pub const CYLINDER: i32 = 3;
    pub const LINE_STRIP: i32 = 4;
    pub const LINE_LIST: i32 = 5;
    pub const CUBE_LIST: i32 = 6;
    pub const SPHERE_LIST: i32 = 7;
    pub const POINTS: i32 = 8;
    pub const TEXT_VIEW_FACING: i32 = 9;
    pub const MESH_RESOURCE: i32 = 10;
    pub const TRIANGLE_LIST: i32 = 11;
    pub const ARROW_STRIP: i32 = 12;
    pub const ADD: i32 = 0;
    pub const DELETE: i32 = 2;
    pub const DELETEALL: i32 = 3;
}

/// Several markers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// The markers, in the order in which they take effect.
    pub markers: Vec<Marker>,
}
ros_message!(
    MarkerArray,
    visualization_msgs / msg / MarkerArray,
    "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
    visualization_msgs / msg / Marker,
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
    geometry_msgs / msg / Vector3,
    std_msgs / msg / ColorRGBA,
    builtin_interfaces / msg / Duration,
    sensor_msgs / msg / CompressedImage,
    visualization_msgs / msg / UVCoordinate,
    visualization_msgs / msg / MeshFile,
);
