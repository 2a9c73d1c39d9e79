//! Every message type as rosbags reads it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{announce, root};
use ros::RosMessage;
use ros::msg::builtin_interfaces::{Duration, Time};
use ros::msg::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use ros::msg::foxglove_msgs::{Grid as FoxgloveGrid, PackedElementField, Vector2};
use ros::msg::geometry_msgs::{
    Point, Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, Transform, TransformStamped,
    Vector3,
};
use ros::msg::grid_map_msgs::{GridMap, GridMapInfo};
use ros::msg::nav_msgs::{Int8Array, MapMetaData, OccupancyGrid};
use ros::msg::nav2_msgs::CostmapFilterInfo;
use ros::msg::rosgraph_msgs::Clock;
use ros::msg::sensor_msgs::CompressedImage;
use ros::msg::std_msgs::{
    ColorRGBA, Float32MultiArray, Header, MultiArrayDimension, MultiArrayLayout, String as StringMessage,
};
use ros::msg::std_srvs::{TriggerRequest, TriggerResponse};
use ros::msg::tf2_msgs::TFMessage;
use ros::msg::visualization_msgs::{Marker, MarkerArray, MeshFile, UVCoordinate};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

/// Messages in a folder, and the list of them.
struct Samples<'a> {
    folder: &'a Path,
    list: Vec<Value>,
}

impl Samples<'_> {
    fn add<M: RosMessage>(&mut self, message: &M) {
        let file = format!("{}.cdr", self.list.len());
        std::fs::write(self.folder.join(&file), ros::cdr(message).unwrap()).unwrap();
        self.list.push(json!({
            "type": M::FULL_NAME, "definition": M::DEFINITION, "type_hash": M::TYPE_HASH, "file": file, "value": message,
        }));
    }
}

fn header() -> Header {
    Header { stamp: Time { sec: -3, nanosec: 999_999_999 }, frame_id: "site_map".to_owned() }
}

fn quaternion() -> Quaternion {
    Quaternion { x: 0.5, y: -0.5, z: 0.5, w: -0.5 }
}

fn pose() -> Pose {
    Pose { position: Point { x: 1.5, y: -2.25, z: 1e-7 }, orientation: quaternion() }
}

fn transform() -> TransformStamped {
    let transform = Transform { translation: Vector3 { x: -1.0, y: 0.0, z: 3.1 }, rotation: quaternion() };
    TransformStamped { header: header(), child_frame_id: "Küche".to_owned(), transform }
}

fn marker() -> Marker {
    let color = ColorRGBA { r: 0.25, g: 0.1, b: 1.0, a: 0.7 };
    let uv = UVCoordinate { u: 0.1, v: 0.9 };
    Marker {
        header: header(),
        ns: "rooms".to_owned(),
        id: -7,
        r#type: Marker::TRIANGLE_LIST,
        action: Marker::DELETEALL,
        pose: pose(),
        scale: Vector3 { x: 0.05, y: 1.0, z: 2.0 },
        color,
        lifetime: Duration { sec: 1, nanosec: 5 },
        frame_locked: true,
        points: vec![Point { x: 1.0, y: 2.0, z: 3.0 }, Point::default()],
        colors: vec![color],
        texture_resource: "package://a/b.png".to_owned(),
        texture: CompressedImage { header: header(), format: "png".to_owned(), data: vec![1, 2, 255] },
        uv_coordinates: vec![uv, uv, uv],
        text: "Büro 1.02".to_owned(),
        mesh_resource: "a".to_owned(),
        mesh_file: MeshFile { filename: "b.glb".to_owned(), data: vec![9; 5] },
        mesh_use_embedded_materials: true,
    }
}

fn status() -> DiagnosticStatus {
    let value = KeyValue { key: "epoch".to_owned(), value: "12".to_owned() };
    DiagnosticStatus {
        level: DiagnosticStatus::STALE,
        name: "rasterize".to_owned(),
        message: String::new(),
        hardware_id: "robot".to_owned(),
        values: vec![value.clone(), value],
    }
}

/// Texts of odd lengths and numbers of all sizes, so that what follows each has to be aligned.
fn grid_map() -> GridMap {
    let dim = |label: &str, size| MultiArrayDimension { label: label.to_owned(), size, stride: 3 * size };
    let layout = MultiArrayLayout { dim: vec![dim("column_index", 2), dim("row", 1)], data_offset: 1 };
    let layer = |data: &[f32]| Float32MultiArray { layout: layout.clone(), data: data.to_vec() };
    GridMap {
        header: header(),
        info: GridMapInfo { resolution: 0.05, length_x: 1.5, length_y: -2.0, pose: pose() },
        layers: vec!["elevation".to_owned(), "ü".to_owned()],
        basic_layers: vec!["elevation".to_owned()],
        data: vec![layer(&[0.25, -1.5, 3.0]), layer(&[]), layer(&[7.0])],
        outer_start_index: 3,
        inner_start_index: 65_535,
    }
}

fn foxglove_grid() -> FoxgloveGrid {
    let field =
        |name: &str, offset| PackedElementField { name: name.to_owned(), offset, r#type: PackedElementField::FLOAT32 };
    FoxgloveGrid {
        timestamp: header().stamp,
        frame_id: "site_map".to_owned(),
        pose: pose(),
        column_count: 3,
        cell_size: Vector2 { x: 0.05, y: 0.25 },
        row_stride: 36,
        cell_stride: 12,
        fields: vec![field("elevation", 0), field("slope", 4)],
        data: vec![1, 2, 255],
    }
}

fn samples(folder: &Path) -> Vec<Value> {
    let mut samples = Samples { folder, list: Vec::new() };
    let covariance = std::array::from_fn(|r| std::array::from_fn(|c| (6 * r + c) as f64 / 7.0));
    let (with_covariance, stamp) = (PoseWithCovariance { pose: pose(), covariance }, header().stamp);
    let info = MapMetaData { map_load_time: stamp, resolution: 0.05, width: 3, height: 1, origin: pose() };
    samples.add(&stamp);
    samples.add(&Duration { sec: i32::MAX, nanosec: u32::MAX });
    samples.add(&header());
    samples.add(&StringMessage { data: "ü".to_owned() });
    samples.add(&ColorRGBA { r: 0.1, g: 0.2, b: 0.3, a: 1.0 });
    samples.add(&pose().position);
    samples.add(&Vector3 { x: f64::MAX, y: f64::MIN_POSITIVE, z: -0.0 });
    samples.add(&quaternion());
    samples.add(&pose());
    samples.add(&PoseStamped { header: header(), pose: pose() });
    samples.add(&with_covariance);
    samples.add(&PoseWithCovarianceStamped { header: header(), pose: with_covariance });
    samples.add(&transform().transform);
    samples.add(&transform());
    samples.add(&TFMessage { transforms: vec![transform(), transform()] });
    samples.add(&info);
    samples.add(&OccupancyGrid { header: header(), info, data: Int8Array(vec![-1, 0, 100]) });
    samples.add(&CostmapFilterInfo {
        header: header(),
        r#type: 2,
        filter_mask_topic: "/mask".to_owned(),
        base: 0.5,
        multiplier: -1.5,
    });
    samples.add(&grid_map().data[0].layout.dim[0]);
    samples.add(&grid_map().data[0].layout);
    samples.add(&grid_map().data[0]);
    samples.add(&grid_map().info);
    samples.add(&grid_map());
    samples.add(&foxglove_grid().cell_size);
    samples.add(&foxglove_grid().fields[1]);
    samples.add(&foxglove_grid());
    samples.add(&marker().texture);
    samples.add(&marker().uv_coordinates[0]);
    samples.add(&marker().mesh_file);
    samples.add(&marker());
    samples.add(&MarkerArray { markers: vec![marker(), Marker::default(), marker()] });
    samples.add(&status().values[0]);
    samples.add(&status());
    samples.add(&DiagnosticArray { header: header(), status: vec![status(), DiagnosticStatus::default()] });
    samples.add(&Clock { clock: stamp });
    samples.add(&TriggerRequest::default());
    samples.add(&TriggerResponse { success: true, message: "done".to_owned() });
    samples.list
}

#[test]
fn messages_are_those_of_rosbags() {
    let made = Command::new(root().join("scripts/python-env")).args(["rosbags==0.11.9", "numpy"]).output().unwrap();
    if !made.status.success() {
        announce(&format!("SKIPPED: rosbags cannot be installed: {}", String::from_utf8_lossy(&made.stderr)));
        return;
    }
    let home = tempfile::tempdir().unwrap();
    let list = samples(home.path());
    std::fs::write(home.path().join("messages.json"), serde_json::to_vec(&list).unwrap()).unwrap();
    let mut check = Command::new(root().join("target/venv/bin/python"));
    let output = check.arg(root().join("scripts/check_ros_messages.py")).arg(home.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), format!("{} messages are those of rosbags", list.len()));
}

/// Names of the types of fields that are no numbers or texts, without the package where it is that of the type itself.
fn used_types(definition: &str) -> Vec<&str> {
    let names = definition.lines().filter(|line| !line.starts_with(['=']) && !line.starts_with("MSG: "));
    let names = names.map(|line| line.split([' ', '[']).next().unwrap());
    names.filter(|name| name.chars().any(char::is_uppercase)).collect()
}

#[test]
fn definitions_have_every_type_that_they_use_once() {
    let home = tempfile::tempdir().unwrap();
    for message in samples(home.path()) {
        let (name, definition) = (message["type"].as_str().unwrap(), message["definition"].as_str().unwrap());
        let mut defined: Vec<&str> = definition.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
        let all = |names: &[&str]| names.iter().map(|n| n.rsplit('/').next().unwrap().to_owned()).collect::<Vec<_>>();
        let (mut used, n_defined) = (all(&used_types(definition)), defined.len());
        let mut sorted = all(&defined);
        used.sort();
        used.dedup();
        sorted.sort();
        assert_eq!(used, sorted, "{name}");
        defined.sort_unstable();
        defined.dedup();
        assert_eq!(defined.len(), n_defined, "{name}");
    }
}
