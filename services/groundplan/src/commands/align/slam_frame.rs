//! Resamples a storey's maps, route graph and waypoints into the SLAM frame.

use crate::failure::Failure;
use crate::input_document::read_document;
use export::{ExportFile, nav2_poses, rounded, with_manifest};
use frames::{Attitude, Map, Rigid2, Slam, UPRIGHT, wrapped};
use grid::{FREE, MapMode, MapYaml, MovedGrid, OCCUPIED, UNKNOWN, encode_pgm, pixel_of};
use messages::SlamFrame;
use occupancy::OccupancyMap;
use serde_json::{Value, json};
use std::path::Path;

/// Files that `convert` wrote of a storey, moved into the robot's frame: maps, masks, route graph and waypoints.
///
/// A cell is occupied if the cell of the model's map is that lies under any part of it, so that walls stay whole; a passage may
/// become narrower by a cell. Where the robot's map bends they bend with it; where it is not known how it lies nothing is free.
///
/// # Errors
/// Files that cannot be read, a robot's map that folds.
pub(super) fn files(reference: &Path, map: &Path, frame: &SlamFrame) -> Result<Vec<ExportFile>, Failure> {
    let storey = map.parent().unwrap_or(reference);
    let moved = Moved { frame };
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
    let here = |w: &Value| w["storey"] == frame.map_storey();
    if let Some(all) = waypoints["waypoints"].as_array_mut() {
        all.retain(here);
        all.sort_by_key(|w| w["order"].as_u64());
        all.iter_mut().try_for_each(|w| moved.waypoint(w))?;
        let pose = |w: &Value| {
            let [x, y, yaw_rad] = ["x_m", "y_m", "yaw_rad"].map(|key| w[key].as_f64().unwrap_or_default());
            ([x, y], Attitude { yaw_rad, up: direction(&w["up"]).unwrap_or(UPRIGHT) })
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
        moved.geometry(&mut feature["geometry"])?;
    }
    add("route.geojson", format!("{route:#}\n").into_bytes());
    let [x_m, y_m, yaw_rad] = frame.map_from_slam().inverse().x_y_yaw();
    let manifest = json!({
        "frame": "slam",
        "storey": frame.map_storey(),
        // Of the whole map: places in the files lie where the bend around them puts them.
        "bends_m": rounded(frame.largest_bend_m()),
        "slam_from_map": {"x_m": x_m, "y_m": y_m, "yaw_rad": yaw_rad},
    });
    Ok(with_manifest(manifest, files))
}

fn read(path: &Path) -> Result<Value, Failure> {
    let bytes = read_document(path).map_err(|error| Failure::work(format!("{}: {error}", path.display())))?;
    serde_json::from_slice(&bytes).map_err(|error| Failure::work(format!("{}: {error}", path.display())))
}

/// Three numbers; `None` for anything else.
fn direction(value: &Value) -> Option<[f64; 3]> {
    let [x, y, z] = value.as_array()?.as_slice() else { return None };
    Some([x.as_f64()?, y.as_f64()?, z.as_f64()?])
}

struct Moved<'a> {
    frame: &'a SlamFrame,
}

impl Moved<'_> {
    /// Image and description of a map; `stem` is its path without extension. Outside of the model's map all is unknown.
    fn map(&self, stem: &Path, first_wins: &[u8]) -> Result<[Vec<u8>; 2], Failure> {
        let name = stem.file_name().unwrap_or_default().to_string_lossy();
        let OccupancyMap { width, cells, resolution_m: side_m, origin: [x0, y0, _] } =
            OccupancyMap::read(&stem.with_extension("yaml")).map_err(Failure::work)?;
        let height = cells.len().checked_div(width).unwrap_or(0);
        let size_m = [width, height].map(|n| n as f64 * side_m);
        let is_known = |place| self.frame.is_known_at(place);
        let grid = MovedGrid::around([x0, y0], size_m, side_m, &self.frame.motion, is_known).map_err(Failure::work)?;
        let turned = grid.resampled(first_wins, FREE, UNKNOWN, |[x, y]| {
            let [column, row] = [(x - x0) / side_m, (y - y0) / side_m];
            let inside = column >= 0.0 && row >= 0.0 && column < width as f64 && row < height as f64;
            if inside { pixel_of(cells[row as usize * width + column as usize].occupancy()) } else { UNKNOWN }
        });
        let (spec, wide) = (grid.spec, grid.spec.width as usize);
        let yaml = MapYaml { image: &format!("{name}.pgm"), spec: &spec, mode: MapMode::Trinary }.to_string();
        Ok([encode_pgm(wide, &turned), yaml.into_bytes()])
    }

    fn waypoint(&self, waypoint: &mut Value) -> Result<(), Failure> {
        let number = |key: &str| waypoint[key].as_f64().unwrap_or_default();
        let in_map = [number("x_m"), number("y_m")];
        let [x, y] = self.point(in_map)?;
        let turn_rad = self.frame.motion.around([x, y]).yaw_rad();
        let yaw = number("yaw_rad") - turn_rad;
        (waypoint["x_m"], waypoint["y_m"]) = (rounded(x).into(), rounded(y).into());
        waypoint["yaw_rad"] = rounded(wrapped(yaw)).into();
        if let Some([x, y, ..]) = waypoint["centroid_m"].as_array_mut().map(Vec::as_mut_slice) {
            let moved = self.point([&*x, &*y].map(|c| c.as_f64().unwrap_or_default()))?;
            (*x, *y) = (rounded(moved[0]).into(), rounded(moved[1]).into());
        }
        // The sensor is off the waypoint as the ground is tilted.
        if let [Some(up), Some([sensor_x, sensor_y, sensor_z])] =
            ["up", "sensor_m"].map(|key| direction(&waypoint[key]))
        {
            let turned = Rigid2::<Slam, Map>::new([0.0; 2], -turn_rad);
            let off = turned.rotate([sensor_x - in_map[0], sensor_y - in_map[1]]);
            let [up_x, up_y] = turned.rotate([up[0], up[1]]);
            waypoint["sensor_m"] = json!([rounded(x + off[0]), rounded(y + off[1]), sensor_z]);
            waypoint["up"] = json!([up_x, up_y, up[2]]);
        }
        Ok(())
    }

    fn point(&self, in_map_m: [f64; 2]) -> Result<[f64; 2], Failure> {
        let [x, y] = in_map_m;
        let folded =
            || format!("the robot's map bends so much that it folds: ({x}, {y}) of the model lies nowhere in it");
        self.frame.motion.apply_inverse(in_map_m).ok_or_else(|| Failure::work(folded()))
    }

    /// Moves a geometry, or a collection of geometries.
    fn geometry(&self, value: &mut Value) -> Result<(), Failure> {
        for geometry in value.get_mut("geometries").and_then(Value::as_array_mut).into_iter().flatten() {
            self.geometry(geometry)?;
        }
        value.get_mut("coordinates").map_or(Ok(()), |coordinates| self.coordinates(coordinates))
    }

    /// Moves a point, or lists of points.
    fn coordinates(&self, value: &mut Value) -> Result<(), Failure> {
        let Some(list) = value.as_array_mut() else { return Ok(()) };
        if let [Value::Number(x), Value::Number(y), ..] = list.as_slice() {
            let p = self.point([x, y].map(|c| c.as_f64().unwrap_or_default()))?;
            (list[0], list[1]) = (rounded(p[0]).into(), rounded(p[1]).into());
            return Ok(());
        }
        list.iter_mut().try_for_each(|inner| self.coordinates(inner))
    }
}
