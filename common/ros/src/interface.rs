//! Names, definitions and hashes of message types, from one text for each type.

use serde::Serialize;

/// A message type: its name, its definition, its hash.
pub trait RosMessage: Serialize {
    /// Interface package, e.g. `nav_msgs`.
    const PACKAGE: &'static str;
    /// Name in the package, e.g. `OccupancyGrid` or `Trigger_Request`.
    const NAME: &'static str;
    /// Name in full, e.g. `nav_msgs/msg/OccupancyGrid` or `std_srvs/srv/Trigger_Request`.
    const FULL_NAME: &'static str;
    /// Definition with those of all types that it uses, as MCAP's schema encoding `ros2msg` wants it: each other type behind a
    /// line of 80 `=` and a line `MSG: std_msgs/Header`.
    const DEFINITION: &'static str;
    /// Hash of the type: `RIHS01_` and 64 hexadecimal digits.
    ///
    /// # Source
    /// REP 2011, "Evolving Message Types".
    const TYPE_HASH: &'static str;
}

/// The definition of a type without comments and without the types that it uses, as a literal.
macro_rules! text {
    (builtin_interfaces/msg/Time) => {
        "int32 sec\nuint32 nanosec\n"
    };
    (builtin_interfaces/msg/Duration) => {
        "int32 sec\nuint32 nanosec\n"
    };
    (std_msgs/msg/Header) => {
        "builtin_interfaces/Time stamp\nstring frame_id\n"
    };
    (std_msgs/msg/String) => {
        "string data\n"
    };
    (std_msgs/msg/ColorRGBA) => {
        "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"
    };
    (std_msgs/msg/MultiArrayDimension) => {
        "string label\nuint32 size\nuint32 stride\n"
    };
    (std_msgs/msg/MultiArrayLayout) => {
        "MultiArrayDimension[] dim\nuint32 data_offset\n"
    };
    (std_msgs/msg/Float32MultiArray) => {
        "MultiArrayLayout layout\nfloat32[] data\n"
    };
    (geometry_msgs/msg/Point) => {
        "float64 x\nfloat64 y\nfloat64 z\n"
    };
    (geometry_msgs/msg/Vector3) => {
        "float64 x\nfloat64 y\nfloat64 z\n"
    };
    (geometry_msgs/msg/Quaternion) => {
        "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"
    };
    (geometry_msgs/msg/Pose) => {
        "Point position\nQuaternion orientation\n"
    };
    (geometry_msgs/msg/PoseStamped) => {
        "std_msgs/Header header\nPose pose\n"
    };
    (geometry_msgs/msg/PoseWithCovariance) => {
        "Pose pose\nfloat64[36] covariance\n"
    };
    (geometry_msgs/msg/PoseWithCovarianceStamped) => {
        "std_msgs/Header header\nPoseWithCovariance pose\n"
    };
    (geometry_msgs/msg/Transform) => {
        "Vector3 translation\nQuaternion rotation\n"
    };
    (geometry_msgs/msg/TransformStamped) => {
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"
    };
    (nav_msgs/msg/MapMetaData) => {
        "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\ngeometry_msgs/Pose origin\n"
    };
    (nav_msgs/msg/OccupancyGrid) => {
        "std_msgs/Header header\nMapMetaData info\nint8[] data\n"
    };
    (grid_map_msgs/msg/GridMapInfo) => {
        "float64 resolution\nfloat64 length_x\nfloat64 length_y\ngeometry_msgs/Pose pose\n"
    };
    (grid_map_msgs/msg/GridMap) => {
        "std_msgs/Header header\nGridMapInfo info\nstring[] layers\nstring[] basic_layers\nstd_msgs/Float32MultiArray[] data\n\
         uint16 outer_start_index\nuint16 inner_start_index\n"
    };
    (foxglove_msgs/msg/Vector2) => {
        "float64 x\nfloat64 y\n"
    };
    (foxglove_msgs/msg/PackedElementField) => {
        "string name\nuint32 offset\nuint8 UNKNOWN=0\nuint8 UINT8=1\nuint8 INT8=2\nuint8 UINT16=3\nuint8 INT16=4\n\
         uint8 UINT32=5\nuint8 INT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nuint8 type\n"
    };
    (foxglove_msgs/msg/Grid) => {
        "builtin_interfaces/Time timestamp\nstring frame_id\ngeometry_msgs/Pose pose\nuint32 column_count\n\
         foxglove_msgs/Vector2 cell_size\nuint32 row_stride\nuint32 cell_stride\n\
         foxglove_msgs/PackedElementField[] fields\nuint8[] data\n"
    };
    (nav2_msgs/msg/CostmapFilterInfo) => {
        "std_msgs/Header header\nuint8 type\nstring filter_mask_topic\nfloat32 base\nfloat32 multiplier\n"
    };
    (sensor_msgs/msg/CompressedImage) => {
        "std_msgs/Header header\nstring format\nuint8[] data\n"
    };
    (visualization_msgs/msg/UVCoordinate) => {
        "float32 u\nfloat32 v\n"
    };
    (visualization_msgs/msg/MeshFile) => {
        "string filename\nuint8[] data\n"
    };
    (visualization_msgs/msg/Marker) => {
        "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\n\
         int32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n\
         int32 TRIANGLE_LIST=11\nint32 ARROW_STRIP=12\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n\
         std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n\
         geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\nbool frame_locked\n\
         geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n\
         sensor_msgs/CompressedImage texture\nUVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\n\
         MeshFile mesh_file\nbool mesh_use_embedded_materials\n"
    };
    (visualization_msgs/msg/MarkerArray) => {
        "Marker[] markers\n"
    };
    (diagnostic_msgs/msg/KeyValue) => {
        "string key\nstring value\n"
    };
    (diagnostic_msgs/msg/DiagnosticStatus) => {
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\nstring hardware_id\n\
         KeyValue[] values\n"
    };
    (diagnostic_msgs/msg/DiagnosticArray) => {
        "std_msgs/Header header\nDiagnosticStatus[] status\n"
    };
    (tf2_msgs/msg/TFMessage) => {
        "geometry_msgs/TransformStamped[] transforms\n"
    };
    (rosgraph_msgs/msg/Clock) => {
        "builtin_interfaces/Time clock\n"
    };
    (std_srvs/srv/Trigger_Request) => {
        ""
    };
    (std_srvs/srv/Trigger_Response) => {
        "bool success\nstring message\n"
    };
}

/// Makes a struct a message type: its name, its hash, and all types that it uses, directly or not.
macro_rules! ros_message {
    (
        $struct:ty, $package:ident/$folder:ident/$name:ident, $hash:literal
        $(, $used_package:ident/$used_folder:ident/$used:ident)* $(,)?
    ) => {
        impl $crate::interface::RosMessage for $struct {
            const PACKAGE: &'static str = stringify!($package);
            const NAME: &'static str = stringify!($name);
            const FULL_NAME: &'static str =
                concat!(stringify!($package), "/", stringify!($folder), "/", stringify!($name));
            const DEFINITION: &'static str = concat!(
                $crate::interface::text!($package/$folder/$name),
                $(
                    "================================================================================\nMSG: ",
                    stringify!($used_package), "/", stringify!($used), "\n",
                    $crate::interface::text!($used_package/$used_folder/$used),
                )*
            );
            const TYPE_HASH: &'static str = concat!("RIHS01_", $hash);
        }
    };
}

pub(crate) use {ros_message, text};
