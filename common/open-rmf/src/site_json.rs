//! `NAME.site.json`: the format of the site editor, version 0.1.

use crate::building::{Building, Level, Vertex};
use crate::doors::{Door, DoorKind, Swing};
use crate::lifts::{Lift, LiftDoor, Side};
use export::{json_text, rounded};
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Thickness of the walls and doors of cabins where a site does not say it, in metres. Anchors of a cabin lie on the inner face of its
/// front, and the format measures the gap from the outer one.
const WALL_M: f64 = 0.1;
const DOOR_M: f64 = 0.05;

/// Things by their number, which no two things of a site share.
type Numbered = BTreeMap<u32, Value>;

#[derive(Serialize)]
struct SiteFile {
    format_version: &'static str,
    /// Those of lifts alone; all others are on their level.
    anchors: Numbered,
    properties: Value,
    levels: Numbered,
    lifts: Numbered,
    navigation: Value,
}

/// The file.
pub(crate) fn bytes(building: &Building) -> Vec<u8> {
    let mut site = SiteBuilder::default();
    let graph = site.number();
    let cabins: Vec<u32> = building.lifts.iter().map(|_| site.number()).collect();
    let mut levels = Numbered::new();
    let level_numbers: Vec<u32> = building.levels.iter().map(|_| site.number()).collect();
    for (level, number) in building.levels.iter().zip(&level_numbers) {
        levels.insert(*number, site.level(level, graph, &cabins));
    }
    let mut lifts = Numbered::new();
    for (lift, cabin) in building.lifts.iter().zip(&cabins) {
        let number = site.number();
        lifts.insert(number, site.lift(lift, *cabin, &level_numbers));
    }
    json_text(&SiteFile {
        format_version: "0.1",
        anchors: site.anchors,
        properties: json!({"name": building.name}),
        levels,
        lifts,
        navigation: json!({"guided": {
            "graphs": {graph.to_string(): {"name": "0", "color": [1.0, 0.5, 0.3]}},
            "ranking": [graph],
            "lanes": site.lanes,
            "locations": site.locations,
        }}),
    })
}

#[derive(Default)]
struct SiteBuilder {
    next: u32,
    anchors: Numbered,
    lanes: Numbered,
    locations: Numbered,
}

fn anchor([x, y]: [f64; 2]) -> Value {
    json!({"Translate2D": [rounded(x), rounded(y)]})
}

impl SiteBuilder {
    fn number(&mut self) -> u32 {
        self.next += 1;
        self.next
    }

    fn level(&mut self, level: &Level, graph: u32, cabins: &[u32]) -> Value {
        let mut anchors = Numbered::new();
        let mut anchor_of = |site: &mut Self, vertex: &Vertex| match vertex.lift {
            // One anchor for all levels: it moves with the cabin.
            Some(lift) => cabins[lift],
            None => {
                let number = site.number();
                anchors.insert(number, anchor(vertex.at_m));
                number
            }
        };
        let numbers: Vec<u32> = level.vertices.iter().map(|vertex| anchor_of(self, vertex)).collect();
        for (vertex, of) in level.vertices.iter().zip(&numbers).filter(|(vertex, _)| !vertex.name.is_empty()) {
            let number = self.number();
            let location = json!({"anchor": of, "tags": [], "name": vertex.name, "graphs": "All"});
            self.locations.insert(number, location);
        }
        for lane in &level.lanes {
            let number = self.number();
            let ends = lane.ends.map(|end| numbers[end]);
            self.lanes.insert(number, json!({"anchors": ends, "graphs": {"Only": [graph]}}));
        }
        let mut edge = |site: &mut Self, ends_m: [[f64; 2]; 2]| {
            ends_m.map(|at_m| {
                let number = site.number();
                anchors.insert(number, anchor(at_m));
                number
            })
        };
        let mut doors = Numbered::new();
        for door in &level.doors {
            let ends = edge(self, door.ends_m);
            doors.insert(self.number(), json!({"anchors": ends, "name": door.name, "kind": kind_of(door)}));
        }
        let mut walls = Numbered::new();
        for ends_m in &level.walls {
            let ends = edge(self, *ends_m);
            walls.insert(self.number(), json!({"anchors": ends}));
        }
        let properties = json!({"name": level.name, "elevation": level.elevation_m});
        json!({"properties": properties, "anchors": anchors, "doors": doors, "walls": walls})
    }

    fn lift(&mut self, lift: &Lift, cabin: u32, level_numbers: &[u32]) -> Value {
        let [half_x, half_y] = lift.half_m;
        let (sin, cos) = (libm::sin(lift.yaw_rad), libm::cos(lift.yaw_rad));
        let in_map = |[x, y]: [f64; 2]| [lift.centre_m[0] + cos * x - sin * y, lift.centre_m[1] + sin * x + cos * y];
        let reference = [[half_x, half_y], [half_x, -half_y]].map(|corner| {
            let number = self.number();
            self.anchors.insert(number, anchor(in_map(corner)));
            number
        });
        let mut cabin_anchors = Numbered::from([(cabin, anchor([0.0, 0.0]))]);
        let mut cabin_doors = Numbered::new();
        let mut shape = json!({"width": 2.0 * half_y, "depth": 2.0 * half_x, "gap": -(WALL_M + DOOR_M / 2.0)});
        for door in &lift.doors {
            let number = self.number();
            let ends = landing_ends(lift, door).map(|end| {
                let number = self.number();
                cabin_anchors.insert(number, anchor(end));
                number
            });
            let visits: Vec<u32> = door.levels.iter().map(|level| level_numbers[*level]).collect();
            let kind = json!({"DoubleSliding": {"left_right_ratio": 1.0}});
            cabin_doors.insert(number, json!({"kind": kind, "reference_anchors": ends, "visits": visits}));
            shape[side_key(door.side)] =
                json!({"door": number, "width": door.width_m, "shifted": door.along_m, "custom_gap": 0.0});
        }
        json!({
            "cabin_doors": cabin_doors,
            "properties": {
                "name": lift.name,
                "reference_anchors": reference,
                "cabin": {"Rect": shape},
                "is_static": false,
                "initial_level": level_numbers[lift.levels[0]],
            },
            "cabin_anchors": cabin_anchors,
        })
    }
}

fn side_key(side: Side) -> &'static str {
    match side {
        Side::Front => "front_door",
        Side::Left => "left_door",
        Side::Back => "back_door",
        Side::Right => "right_door",
    }
}

/// Ends of a landing door in the frame of the cabin, the left one first of who looks out: before the wall of the cabin and its door.
fn landing_ends(lift: &Lift, door: &LiftDoor) -> [[f64; 2]; 2] {
    let [out, along] = door.side.axes();
    let at = |k: usize, s: f64| out[k] * (lift.half_m[k] + WALL_M + DOOR_M / 2.0) + along[k] * (door.along_m + s);
    [door.width_m / 2.0, -door.width_m / 2.0].map(|s| [at(0, s), at(1, s)])
}

/// The kind of a door; `Left` is its first end.
fn kind_of(door: &Door) -> Value {
    let swing = |swing: Swing| match swing {
        Swing::Forward => json!({"Forward": {"deg": 90.0}}),
        Swing::Backward => json!({"Backward": {"deg": 90.0}}),
        Swing::Both => json!({"Both": {"forward": {"deg": 90.0}, "backward": {"deg": 90.0}}}),
    };
    match door.kind {
        DoorKind::Hinged(side) => json!({"SingleSwing": {"pivot_on": "Left", "swing": swing(side)}}),
        DoorKind::DoubleHinged(side, ratio) => {
            json!({"DoubleSwing": {"swing": swing(side), "left_right_ratio": ratio}})
        }
        DoorKind::Sliding => json!({"SingleSliding": {"towards": "Left"}}),
        DoorKind::DoubleSliding(ratio) => json!({"DoubleSliding": {"left_right_ratio": ratio}}),
    }
}
