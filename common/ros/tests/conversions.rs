//! Maps and markers of a small building.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../export/tests/support/mod.rs"]
mod support;

use export::ExportInput;
use ros::markers;
use ros::msg::builtin_interfaces::Time;
use ros::msg::nav_msgs::OccupancyGrid;
use ros::msg::visualization_msgs::{Marker, MarkerArray};
use ros::relief::{foxglove_grid, grid_map};
use ros::{Layers, Relief, maps};
use support::house;

const STAMP: Time = Time { sec: 1_714_204_800, nanosec: 0 };

/// The value of a key in the YAML beside an image.
fn value<'a>(yaml: &'a str, key: &str) -> &'a str {
    yaml.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(": ")).unwrap()
}

/// What Nav2's map_server of Jazzy makes of an image in trinary mode: the image is read from the top, the grid begins at the
/// bottom, and both thresholds are themselves inside.
fn map_server(pgm: &[u8], yaml: &str) -> (Vec<i8>, [f64; 3]) {
    let number = |key: &str| value(yaml, key).parse::<f64>().unwrap();
    assert_eq!((value(yaml, "mode"), value(yaml, "negate")), ("trinary", "0"));
    let text = pgm.split(|b| *b == b'\n').take(3).map(|line| std::str::from_utf8(line).unwrap());
    let [magic, size, depth] = text.collect::<Vec<_>>().try_into().unwrap();
    assert_eq!((magic, depth), ("P5", "255"));
    let (width, height) = size.split_once(' ').unwrap();
    let (width, height): (usize, usize) = (width.parse().unwrap(), height.parse().unwrap());
    let pixels = &pgm[pgm.len() - width * height..];
    let cell = |row: usize, column: usize| {
        let occupied = (255.0 - f64::from(pixels[(height - 1 - row) * width + column])) / 255.0;
        match occupied {
            o if o >= number("occupied_thresh") => 100,
            o if o <= number("free_thresh") => 0,
            _ => -1,
        }
    };
    let cells = (0..height).flat_map(|row| (0..width).map(move |column| cell(row, column)));
    let origin = value(yaml, "origin").trim_matches(['[', ']']).split(", ").map(|n| n.parse().unwrap());
    (cells.collect(), origin.collect::<Vec<f64>>().try_into().unwrap())
}

#[test]
fn grids_hold_what_map_server_reads_from_the_files() {
    house().with_input(|input: &ExportInput<'_>| {
        let files = export::files(input, Vec::new());
        let bytes = |name: &str| &files.iter().find(|f| f.path.ends_with(name)).unwrap().bytes;
        let layers = input.grids.with(0, Layers::of);
        let check = |name: &str, message: OccupancyGrid| {
            let yaml = std::str::from_utf8(bytes(&format!("{name}.yaml"))).unwrap();
            let (cells, [x, y, yaw]) = map_server(bytes(&format!("{name}.pgm")), yaml);
            assert_eq!(message.data.0, cells, "{name}");
            let (info, origin) = (message.info, message.info.origin.position);
            assert_eq!((origin.x, origin.y, yaw, info.origin.orientation.w), (x, y, 0.0, 1.0));
            assert_eq!(info.resolution.to_string(), value(yaml, "resolution"));
            assert_eq!((info.width * info.height) as usize, cells.len());
            assert_eq!((message.header.frame_id.as_str(), message.header.stamp), ("map", STAMP));
        };
        check("planning", maps::planning(&layers, "map", STAMP));
        check("localization", maps::localization(&layers, "map", STAMP));
        check("keepout", maps::keepout_mask(&layers, "map", STAMP));
        let mask = maps::keepout_mask(&layers, "map", STAMP).data.0;
        assert!(mask.contains(&100) && !mask.contains(&0), "Nav2's filter would free unknown cells: {mask:?}");
    });
}

#[test]
fn a_map_of_several_layers_holds_the_grid_where_grid_map_looks_for_it() {
    house().with_input(|input: &ExportInput<'_>| {
        let robot = &input.index.head.robot;
        input.grids.with(0, |grid| {
            let relief = Relief::of(grid, robot);
            let map = grid_map(&relief, "map", STAMP);
            let (info, middle) = (map.info, map.info.pose.position);
            let rows = (info.length_x / info.resolution).round() as usize;
            // As grid_map finds the cell of a position, and its value in a matrix in column-major order.
            let index = |position: f64, middle: f64, length: f64| {
                ((middle + length / 2.0 - position) / info.resolution).floor() as usize
            };
            let side_m = grid.spec().resolution_m();
            for cell in 0..grid.spec().n_cells() {
                let [column, row] = [cell % 7, cell / 7].map(|n| (n as f64 + 0.5) * side_m);
                let [x, y] = grid.spec().origin_m();
                let row_index = index(x + column, middle.x, info.length_x);
                let column_index = index(y + row, middle.y, info.length_y);
                let found = [0, 1, 2].map(|layer| map.data[layer].data[column_index * rows + row_index]);
                // The floor of a level storey lies in the plane of its maps.
                let expected = match (grid.planning[cell], grid.keepout[cell]) {
                    (0, -1) => [0.0, 0.0, 1.0],
                    (100, _) => [0.0; 3],
                    _ => [f32::NAN, f32::NAN, 0.0],
                };
                assert_eq!(found.map(f32::to_bits), expected.map(f32::to_bits), "{cell}");
            }
            assert_eq!(
                (map.layers, map.basic_layers),
                (Relief::LAYERS.map(str::to_owned).into(), vec!["elevation".to_owned()])
            );
            assert_eq!((map.header.frame_id.as_str(), map.header.stamp), ("map", STAMP));
            let elevation = foxglove_grid(&relief, "map", STAMP);
            assert_eq!(
                (elevation.frame_id.as_str(), elevation.timestamp, elevation.data.len()),
                ("map", STAMP, 35 * 12)
            );
        });
    });
}

#[test]
fn names_of_storeys_are_names_of_topics() {
    house().with_input(|input| {
        let name = ros::topics::storey_name(input.site, 0);
        let topics = ros::topics::StoreyTopics::below(&format!("{}/{name}", ros::topics::NAMESPACE));
        assert_eq!(topics.keepout_mask, "/groundplan/storey_00_erdgeschoss/keepout_mask");
    });
}

/// The markers of an array by namespace and id, with their kind and text.
fn listed(array: &MarkerArray) -> Vec<(&str, i32, i32, &str)> {
    let (first, others) = array.markers.split_first().unwrap();
    assert_eq!(first.action, Marker::DELETEALL);
    let mut listed: Vec<_> = others.iter().map(|m| (m.ns.as_str(), m.id, m.r#type, m.text.as_str())).collect();
    listed.sort_unstable();
    assert!(others.iter().all(|m| m.action == Marker::ADD && m.header.frame_id == "map" && m.header.stamp == STAMP));
    listed
}

#[test]
fn rooms_doors_waypoints_and_routes_are_drawn() {
    house().with_input(|input| {
        let (site, plan) = (input.site, input.mission_plan);
        let rooms = markers::rooms(site, input.schedule_state, 0, "map", STAMP);
        let name = ("room_names", 0, Marker::TEXT_VIEW_FACING, "Küche, \"0.1\"");
        assert_eq!(listed(&rooms), [name, ("rooms", 0, Marker::LINE_STRIP, "")]);
        assert_eq!(rooms.markers[1].points.len(), 5, "an outline is closed");
        let each: Vec<_> = markers::each_room(site, input.schedule_state, 0).collect();
        assert_eq!((each.len(), each[0].state.name(), each[0].global_id), (1, "open", "space-0"), "{each:?}");
        // The door of this building has no passage to draw.
        let doors = markers::doors(site, input.index, 0, "map", STAMP);
        let reason = "clear width 0.50 m, this robot needs 0.70 m";
        assert_eq!(listed(&doors), [("door_reasons", 0, Marker::TEXT_VIEW_FACING, reason)]);
        let waypoints = markers::waypoints(site, plan, 0, "map", STAMP);
        let text = Marker::TEXT_VIEW_FACING;
        let expected = [
            ("tour", 0, Marker::LINE_STRIP, ""),
            ("waypoint_order", 0, text, "0"),
            ("waypoint_order", 1, text, "1"),
            ("waypoints", 0, Marker::ARROW, ""),
            ("waypoints", 1, Marker::ARROW, ""),
        ];
        assert_eq!(listed(&waypoints), expected);
        let route = markers::route(site, plan, 0, "map", STAMP);
        let expected = [
            ("portal_names", 1, text, "stair to "),
            ("portals", 1, Marker::LINE_STRIP, ""),
            ("route", 0, Marker::LINE_LIST, ""),
            ("route_nodes", 0, Marker::SPHERE_LIST, ""),
        ];
        assert_eq!(listed(&route), expected);
        let elsewhere = markers::route(site, plan, 7, "map", STAMP);
        assert!(listed(&elsewhere).is_empty());
    });
}

#[test]
fn drop_offs_are_the_borders_of_the_floor() {
    house().with_input(|input| {
        let array = input.grids.with(0, |grid| markers::drop_offs(grid, "map", STAMP));
        assert_eq!(listed(&array), [("drop_offs", 0, Marker::LINE_LIST, "")]);
        // The last column of the grid has no floor; beside the wall in the lowest row nothing drops.
        let line: Vec<[f64; 2]> = array.markers[1].points.iter().map(|p| [p.x, p.y]).collect();
        assert_eq!(line, [[3.0, 0.5], [3.0, 2.5]]);
    });
}
