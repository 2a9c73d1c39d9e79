//! The building as Open-RMF sees it: levels with vertices, lanes and doors, and lifts that join levels.

use crate::doors::{self, Door};
use crate::lifts::{self, LevelFloor, Lift};
use crate::names::{UsedNames, unique};
use crate::walls;
use export::{ExportInput, rounded, space_name};
use frames::metres;
use messages::{EdgeKind, NodeKind, RouteEdgeRecord, RouteNodeRecord};
use std::collections::{BTreeMap, BTreeSet};

/// A building.
#[derive(Debug)]
pub(crate) struct Building {
    /// Base name of the model's file.
    pub(crate) name: String,
    /// In the order of the map storeys.
    pub(crate) levels: Vec<Level>,
    pub(crate) lifts: Vec<Lift>,
    /// How many ways of each class join levels otherwise than by a lift.
    pub(crate) left_out: BTreeMap<&'static str, usize>,
    /// How many pieces of walls are not straight.
    pub(crate) n_walls_left_out: usize,
}

/// A map storey.
#[derive(Debug)]
pub(crate) struct Level {
    pub(crate) map_storey: u32,
    pub(crate) name: String,
    pub(crate) elevation_m: f64,
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) lanes: Vec<Lane>,
    pub(crate) doors: Vec<Door>,
    /// Both ends of each wall.
    pub(crate) walls: Vec<[[f64; 2]; 2]>,
}

/// A place on a level.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Vertex {
    pub(crate) at_m: [f64; 2],
    /// Empty but for rooms and cabins.
    pub(crate) name: String,
    /// Of the room or lift.
    pub(crate) global_id: Option<String>,
    /// Place in the building's lifts of the one in whose cabin it lies.
    pub(crate) lift: Option<usize>,
}

/// A straight way between two vertices of a level, in both directions.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lane {
    pub(crate) ends: [usize; 2],
    /// Name of the door that it passes.
    pub(crate) door: Option<String>,
}

impl Building {
    /// Of the inputs of an export: what is there at the plan time, as far as the map storeys that are written.
    pub(crate) fn of(input: &ExportInput<'_>) -> Self {
        let level_names = level_names(input);
        let written = (0..).zip(input.site.map_storeys).filter(|(index, _)| input.writes(*index));
        let mut levels: Vec<Level> = written
            .map(|(map_storey, record)| Level {
                map_storey,
                name: level_names[map_storey as usize].clone(),
                elevation_m: metres(record.floor_z_tenths),
                vertices: Vec::new(),
                lanes: Vec::new(),
                doors: Vec::new(),
                walls: Vec::new(),
            })
            .collect();
        let floor = |level: &Level| LevelFloor { map_storey: level.map_storey, elevation_m: level.elevation_m };
        let lifts = lifts::lifts(input, &levels.iter().map(floor).collect::<Vec<_>>());
        let landing_doors = lifts.iter().flat_map(|lift| &lift.landing_doors).copied().collect();
        let doors = doors::doors(input, &landing_doors);
        let mut n_walls_left_out = 0;
        for level in &mut levels {
            level.doors = doors.iter().filter(|door| door.map_storey == level.map_storey).cloned().collect();
            let (lines, n_left_out) = walls::walls(input, level.map_storey);
            level.walls = lines;
            n_walls_left_out += n_left_out;
        }
        let mut graph = GraphBuilder { input, doors: &doors, levels, vertex_of: BTreeMap::new() };
        graph.add_nodes();
        graph.add_lanes();
        graph.add_cabins(&lifts);
        let left_out = graph.left_out();
        Self { name: building_name(input), levels: graph.levels, lifts, left_out, n_walls_left_out }
    }
}

/// Names of all map storeys, written or not, so that a choice of storeys changes none.
fn level_names(input: &ExportInput<'_>) -> Vec<String> {
    let indices: Vec<String> = (0..input.site.map_storeys.len()).map(|index| format!("({index})")).collect();
    let storeys = input.site.map_storeys.iter().zip(&indices);
    unique(storeys.map(|(storey, index)| (input.site.text(storey.name).to_owned(), index.as_str())))
}

fn building_name(input: &ExportInput<'_>) -> String {
    let file = input.site.source_file(0).unwrap_or_default();
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    unique(std::iter::once((stem.to_owned(), "building"))).remove(0)
}

struct GraphBuilder<'a> {
    input: &'a ExportInput<'a>,
    doors: &'a [Door],
    levels: Vec<Level>,
    /// Level and vertex of each node of the route graph.
    vertex_of: BTreeMap<u32, (usize, usize)>,
}

impl GraphBuilder<'_> {
    fn add_nodes(&mut self) {
        let site = self.input.site;
        let spaces = (0..).zip(site.spaces);
        let names = unique(
            spaces.map(|(index, space)| (space_name(site, index).unwrap_or_default(), site.text(space.global_id))),
        );
        let mut used = UsedNames::default();
        for (id, node) in (0..).zip(self.input.mission_plan.nodes) {
            let Some(level) = self.levels.iter().position(|level| level.map_storey == node.map_storey) else {
                continue;
            };
            let room = site.spaces.get(node.of as usize).filter(|_| node.kind.get() == NodeKind::Space);
            let vertex = Vertex {
                at_m: place(node),
                name: room.map(|_| used.take(names[node.of as usize].clone())).unwrap_or_default(),
                global_id: room.map(|room| site.text(room.global_id).to_owned()),
                lift: None,
            };
            self.vertex_of.insert(id, (level, self.levels[level].vertices.len()));
            self.levels[level].vertices.push(vertex);
        }
    }

    /// Ends of an edge on one level; `None` for one between levels, or on a storey that is not written.
    fn ends_on_level(&self, edge: &RouteEdgeRecord) -> Option<(usize, [usize; 2])> {
        let [from, to] = edge.nodes.map(|node| self.vertex_of.get(&node));
        let ((level, from), (other, to)) = (from?, to?);
        (level == other).then_some((*level, [*from, *to]))
    }

    /// Lanes of the ways that this robot can take: a vertex wherever a way bends.
    fn add_lanes(&mut self) {
        for edge in self.input.mission_plan.edges.iter().filter(|edge| edge.usable == 1) {
            let Some((level, [from, to])) = self.ends_on_level(edge) else { continue };
            let own = self.doors.iter().find(|door| edge.kind.get() == EdgeKind::Door && door.door == edge.of);
            let level = &mut self.levels[level];
            let mut line = vec![from];
            let points = self.input.mission_plan.points_of(edge);
            for point in points.get(1..points.len().saturating_sub(1)).unwrap_or_default() {
                let at_m = [rounded(point[0]), rounded(point[1])];
                let ends = [line[line.len() - 1], to];
                if ends.iter().all(|&end| level.vertices[end].at_m != at_m) {
                    line.push(level.vertices.len());
                    level.vertices.push(Vertex { at_m, name: String::new(), global_id: None, lift: None });
                }
            }
            line.push(to);
            let lane = |pair: &[usize]| {
                let ends = [pair[0], pair[1]];
                let line = ends.map(|end| level.vertices[end].at_m);
                let crossed = own.filter(|door| door.is_crossed_by(line));
                let crossed = crossed.or_else(|| level.doors.iter().find(|door| door.is_crossed_by(line)));
                Lane { ends, door: crossed.map(|door| door.name.clone()) }
            };
            let mut lanes: Vec<Lane> = line.windows(2).map(lane).collect();
            // A way through a door asks for it, even where its points round to beside the opening.
            if let Some(own) = own.filter(|own| lanes.iter().all(|lane| lane.door.as_ref() != Some(&own.name))) {
                lanes.iter_mut().for_each(|lane| lane.door = Some(own.name.clone()));
            }
            level.lanes.extend(lanes);
        }
    }

    /// A vertex in the cabin of a lift on each level where this robot can board it, with lanes from where it waits.
    fn add_cabins(&mut self, lifts: &[Lift]) {
        let is_taken = |edge: &&RouteEdgeRecord| edge.usable == 1 && edge.kind.get() == EdgeKind::Lift;
        for (at, lift) in lifts.iter().enumerate() {
            let edges = self.input.mission_plan.edges.iter().filter(is_taken).filter(|edge| edge.of == lift.element);
            let stagings: BTreeSet<(usize, usize)> =
                edges.flat_map(|edge| edge.nodes).filter_map(|node| self.vertex_of.get(&node).copied()).collect();
            for (index, level) in self.levels.iter_mut().enumerate() {
                let here: Vec<usize> =
                    stagings.iter().filter(|(k, _)| *k == index).map(|(_, vertex)| *vertex).collect();
                if here.is_empty() {
                    continue;
                }
                let cabin = level.vertices.len();
                let name = format!("{} on {}", lift.name, level.name);
                let global_id = Some(lift.global_id.clone());
                level.vertices.push(Vertex { at_m: lift.centre_m, name, global_id, lift: Some(at) });
                level.lanes.extend(here.into_iter().map(|vertex| Lane { ends: [vertex, cabin], door: None }));
            }
        }
    }

    fn left_out(&self) -> BTreeMap<&'static str, usize> {
        let mut count = BTreeMap::new();
        for edge in self.input.mission_plan.edges.iter().filter(|edge| edge.usable == 1) {
            let is_written = edge.nodes.iter().all(|node| self.vertex_of.contains_key(node));
            if is_written && edge.kind.get() != EdgeKind::Lift && self.ends_on_level(edge).is_none() {
                *count.entry(edge.kind.get().name()).or_default() += 1;
            }
        }
        count
    }
}

fn place(node: &RouteNodeRecord) -> [f64; 2] {
    let [x, y, _] = node.position_in_map_m.map(rounded);
    [x, y]
}
