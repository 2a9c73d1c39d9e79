//! Resamples a storey's maps, route graph and waypoints into the SLAM frame.

use crate::failure::Failure;
use crate::input_document::read_document;
use export::{ExportFile, nav2_poses, rounded, with_manifest};
use frames::{Map, Rigid2, Slam, wrapped};
use grid::{MapMode, MapYaml, OCCUPIED, UNKNOWN, encode_pgm, pixel_of, resampled, spec_around_moved};
use messages::PoseRecord;
use occupancy::OccupancyMap;
use serde_json::{Value, json};
use std::path::Path;

/// Files that `convert` wrote of a storey, moved into the robot's frame: maps, masks, route graph and waypoints.
///
/// A cell is occupied if the cell of the model's map is that lies under any part of it, so that walls stay whole; a passage may
/// become narrower by a cell.
///
/// # Errors
/// Files that cannot be read.
pub(super) fn files(reference: &Path, map: &Path, pose: &PoseRecord) -> Result<Vec<ExportFile>, Failure> {
    let storey = map.parent().unwrap_or(reference);
    let map_from_slam = pose.map_from_slam();
    let moved = Moved { map_from_slam, slam_from_map: map_from_slam.inverse() };
    let mut files = Vec::new();
    let mut add = |path: &str, bytes: Vec<u8>| files.push(ExportFile { path: path.to_owned(), bytes });
    for (name, first_wins) in
        [("planning", &[OCCUPIED, UNKNOWN][..]), ("localization", &[OCCUPIED]), ("keepout", &[OCCUPIED])]
    {
        let [pgm, yaml] = moved.map(&storey.join(name), first_wins)?;
        add(&format!("{name}.pgm"), pgm);
        add(&format!("{name}.yaml"), yaml);
    }
    let mut waypoints = read(&reference.join("waypoints.json"))?;
    let here = |w: &Value| w["storey"] == pose.map_storey;
    if let Some(all) = waypoints["waypoints"].as_array_mut() {
        all.retain(here);
        all.sort_by_key(|w| w["order"].as_u64());
        all.iter_mut().for_each(|w| moved.waypoint(w));
        let pose = |w: &Value| {
            let [x, y, yaw_rad] = ["x_m", "y_m", "yaw_rad"].map(|key| w[key].as_f64().unwrap_or_default());
            ([x, y], yaw_rad)
        };
        add("waypoints.yaml", nav2_poses(all.iter().map(pose)).into_bytes());
    }
    waypoints["frame"] = "slam".into();
    for key in ["spaces", "storeys", "tours"] {
        // Their content is in the model's frame.
        if let Some(object) = waypoints.as_object_mut() {
            object.remove(key);
        }
    }
    add("waypoints.json", format!("{waypoints:#}\n").into_bytes());
    let mut route = read(&storey.join("route.geojson"))?;
    for feature in route["features"].as_array_mut().into_iter().flatten() {
        moved.geometry(&mut feature["geometry"]);
    }
    add("route.geojson", format!("{route:#}\n").into_bytes());
    let [x_m, y_m, yaw_rad] = moved.slam_from_map.x_y_yaw();
    let manifest = json!({
        "frame": "slam",
        "storey": pose.map_storey,
        "slam_from_map": {"x_m": x_m, "y_m": y_m, "yaw_rad": yaw_rad},
    });
    Ok(with_manifest(manifest, files))
}

fn read(path: &Path) -> Result<Value, Failure> {
    let bytes = read_document(path).map_err(|error| Failure::work(format!("{}: {error}", path.display())))?;
    serde_json::from_slice(&bytes).map_err(|error| Failure::work(format!("{}: {error}", path.display())))
}

struct Moved {
    map_from_slam: Rigid2<Map, Slam>,
    slam_from_map: Rigid2<Slam, Map>,
}

impl Moved {
    /// Image and description of a map; `stem` is its path without extension. Outside of the model's map all is unknown.
    fn map(&self, stem: &Path, first_wins: &[u8]) -> Result<[Vec<u8>; 2], Failure> {
        let name = stem.file_name().unwrap_or_default().to_string_lossy();
        let OccupancyMap { width, cells, resolution_m: side_m, origin: [x0, y0, _] } =
            OccupancyMap::read(&stem.with_extension("yaml")).map_err(Failure::work)?;
        let height = cells.len().checked_div(width).unwrap_or(0);
        let size_m = [width, height].map(|n| n as f64 * side_m);
        let moved = |point| self.slam_from_map.apply(point);
        let spec = spec_around_moved([x0, y0], size_m, side_m, moved).map_err(Failure::work)?;
        let [x1, y1] = spec.origin_m();
        let look = |[column, row]: [f64; 2]| {
            let p = self.map_from_slam.apply([x1 + column * side_m, y1 + row * side_m]);
            let [column, row] = [(p[0] - x0) / side_m, (p[1] - y0) / side_m];
            let inside = column >= 0.0 && row >= 0.0 && column < width as f64 && row < height as f64;
            if inside { pixel_of(cells[row as usize * width + column as usize].occupancy()) } else { UNKNOWN }
        };
        let (wide, high) = (spec.width as usize, spec.height as usize);
        let turned = resampled(wide, high, first_wins, look);
        let yaml = MapYaml { image: &format!("{name}.pgm"), spec: &spec, mode: MapMode::Trinary }.to_string();
        Ok([encode_pgm(wide, &turned), yaml.into_bytes()])
    }

    fn waypoint(&self, waypoint: &mut Value) {
        let number = |key: &str| waypoint[key].as_f64().unwrap_or_default();
        let [x, y] = self.slam_from_map.apply([number("x_m"), number("y_m")]);
        let yaw = number("yaw_rad") + self.slam_from_map.yaw_rad();
        (waypoint["x_m"], waypoint["y_m"]) = (rounded(x).into(), rounded(y).into());
        waypoint["yaw_rad"] = rounded(wrapped(yaw)).into();
        if let Some([x, y, ..]) = waypoint["centroid_m"].as_array_mut().map(Vec::as_mut_slice) {
            let moved = self.slam_from_map.apply([&*x, &*y].map(|c| c.as_f64().unwrap_or_default()));
            (*x, *y) = (rounded(moved[0]).into(), rounded(moved[1]).into());
        }
    }

    /// A geometry, or a collection of geometries.
    fn geometry(&self, value: &mut Value) {
        if let Some(inner) = value.get_mut("geometries").and_then(Value::as_array_mut) {
            inner.iter_mut().for_each(|geometry| self.geometry(geometry));
        }
        if let Some(coordinates) = value.get_mut("coordinates") {
            self.coordinates(coordinates);
        }
    }

    /// A point, or lists of points.
    fn coordinates(&self, value: &mut Value) {
        let Some(list) = value.as_array_mut() else { return };
        if let [Value::Number(x), Value::Number(y), ..] = list.as_slice() {
            let p = self.slam_from_map.apply([x, y].map(|c| c.as_f64().unwrap_or_default()));
            (list[0], list[1]) = (rounded(p[0]).into(), rounded(p[1]).into());
        } else {
            list.iter_mut().for_each(|inner| self.coordinates(inner));
        }
    }
}
