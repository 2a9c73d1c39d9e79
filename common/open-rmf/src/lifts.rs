//! Lifts that join levels: cabins as the model has them, with their landing doors.

use crate::doors::is_hung;
use crate::names::unique;
use export::{ExportInput, rounded};
use frames::TENTHS_PER_M;
use geometry::OrientedBox;
use messages::{EdgeKind, NONE};
use std::collections::{BTreeMap, BTreeSet};

/// A door as near as this to a side of a cabin is a landing door of the lift.
const LANDING_M: f64 = 1.0;

/// Cosine between a landing door and the side of the cabin that it serves.
const PARALLEL: f64 = 0.7;

/// What of a level a lift goes by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LevelFloor {
    pub(crate) map_storey: u32,
    pub(crate) elevation_m: f64,
}

/// A lift.
#[derive(Debug)]
pub(crate) struct Lift {
    /// Of the site.
    pub(crate) element: u32,
    pub(crate) name: String,
    pub(crate) global_id: String,
    /// Middle of the cabin in `map`.
    pub(crate) centre_m: [f64; 2],
    /// Of its x axis in `map`, which leads out of its first door.
    pub(crate) yaw_rad: f64,
    /// Half its sides along its x and y axis.
    pub(crate) half_m: [f64; 2],
    /// At most one for each side.
    pub(crate) doors: Vec<LiftDoor>,
    /// Levels that it joins, as places among those of the building, from below.
    pub(crate) levels: Vec<usize>,
    /// Doors of the site that are its landing doors.
    pub(crate) landing_doors: BTreeSet<u32>,
}

/// A cabin door, with landing doors before it.
#[derive(Debug)]
pub(crate) struct LiftDoor {
    pub(crate) name: String,
    pub(crate) side: Side,
    /// Middle of the door along the side, counter-clockwise around the cabin.
    pub(crate) along_m: f64,
    pub(crate) width_m: f64,
    /// Levels to which it opens.
    pub(crate) levels: Vec<usize>,
}

/// A side of a cabin, by its axis that points out of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Side {
    /// +x.
    Front,
    /// +y.
    Left,
    /// -x.
    Back,
    /// -y.
    Right,
}

impl Side {
    const ALL: [Self; 4] = [Self::Front, Self::Left, Self::Back, Self::Right];

    /// Directions out of the cabin and along the side, counter-clockwise, in the frame of the cabin.
    pub(crate) fn axes(self) -> [[f64; 2]; 2] {
        match self {
            Self::Front => [[1.0, 0.0], [0.0, 1.0]],
            Self::Left => [[0.0, 1.0], [-1.0, 0.0]],
            Self::Back => [[-1.0, 0.0], [0.0, -1.0]],
            Self::Right => [[0.0, -1.0], [1.0, 0.0]],
        }
    }
}

/// A landing door in the frame of the cabin.
struct Landing {
    door: u32,
    level: usize,
    side: Side,
    along_m: f64,
    width_m: f64,
}

/// The lifts by which ways lead between levels, whether or not this robot takes them.
pub(crate) fn lifts(input: &ExportInput<'_>, levels: &[LevelFloor]) -> Vec<Lift> {
    let site = input.site;
    let (nodes, edges) = (input.mission_plan.nodes, input.mission_plan.edges);
    let mut served: BTreeMap<u32, BTreeSet<usize>> = BTreeMap::new();
    for edge in edges.iter().filter(|edge| edge.kind.get() == EdgeKind::Lift) {
        let level = |node: u32| levels.iter().position(|level| level.map_storey == nodes[node as usize].map_storey);
        served.entry(edge.of).or_default().extend(edge.nodes.into_iter().filter_map(level));
    }
    let elements: Vec<u32> = served.keys().copied().collect();
    let records = elements.iter().map(|&element| &site.elements[element as usize]);
    let names = unique(records.map(|e| (site.text(e.name).to_owned(), site.text(e.global_id))));
    let of = |((element, served), name): ((u32, BTreeSet<usize>), String)| {
        let mut from_below: Vec<usize> = served.into_iter().collect();
        from_below.sort_by(|a, b| levels[*a].elevation_m.total_cmp(&levels[*b].elevation_m));
        lift(input, levels, element, name, from_below)
    };
    served.into_iter().zip(names).filter(|((_, served), _)| served.len() > 1).filter_map(of).collect()
}

fn lift(
    input: &ExportInput<'_>,
    all_levels: &[LevelFloor],
    element: u32,
    name: String,
    levels: Vec<usize>,
) -> Option<Lift> {
    let site = input.site;
    let cabin = cabin(input, element)?;
    let mut landings = landings(input, all_levels, &levels, &cabin);
    let turned = landings.first().map_or(0, |landing| Side::ALL.iter().position(|s| *s == landing.side).unwrap_or(0));
    // The x axis leads out of the first door.
    let axis = Side::ALL[turned].axes()[0];
    let across = cabin.across();
    let x_axis = [0, 1].map(|k| axis[0] * cabin.axis[k] + axis[1] * across[k]);
    for landing in &mut landings {
        let side = Side::ALL.iter().position(|s| *s == landing.side).unwrap_or(0);
        landing.side = Side::ALL[(side + 4 - turned) % 4];
    }
    let half = cabin.half.map(|half| rounded(half / f64::from(TENTHS_PER_M)));
    let half_m = if turned.is_multiple_of(2) { half } else { [half[1], half[0]] };
    Some(Lift {
        element,
        name,
        global_id: site.text(site.elements[element as usize].global_id).to_owned(),
        centre_m: cabin.centre.map(|c| rounded(c / f64::from(TENTHS_PER_M))),
        yaw_rad: libm::atan2(x_axis[1], x_axis[0]),
        half_m,
        doors: doors_of(&landings, half_m),
        levels,
        landing_doors: landings.iter().map(|landing| landing.door).collect(),
    })
}

/// One door for each side, the widest of its landing doors telling its width and place.
fn doors_of(landings: &[Landing], half_m: [f64; 2]) -> Vec<LiftDoor> {
    let mut doors: Vec<LiftDoor> = Vec::new();
    for side in Side::ALL {
        let here = || landings.iter().filter(|landing| landing.side == side);
        let Some(widest) = here().max_by(|a, b| a.width_m.total_cmp(&b.width_m)) else { continue };
        let levels: BTreeSet<usize> = here().map(|landing| landing.level).collect();
        // No wider than the side, and within it.
        let reach = if matches!(side, Side::Front | Side::Back) { half_m[1] } else { half_m[0] };
        let width_m = widest.width_m.min(2.0 * reach);
        doors.push(LiftDoor {
            name: format!("door{}", doors.len() + 1),
            side,
            along_m: rounded(widest.along_m.clamp(width_m / 2.0 - reach, reach - width_m / 2.0)),
            width_m: rounded(width_m),
            levels: levels.into_iter().collect(),
        });
    }
    doors
}

/// The plan of a lift: of its own body and those of its parts that are no doors.
fn cabin(input: &ExportInput<'_>, element: u32) -> Option<OrientedBox> {
    let site = input.site;
    let is_part = |mut at: u32| {
        // The bound ends cycles in broken files.
        for _ in 0..16 {
            if at == element || at == NONE {
                break;
            }
            at = site.elements[at as usize].whole;
        }
        at == element
    };
    let own = (0..).zip(site.elements).filter(|(index, record)| record.door == NONE && is_part(*index));
    let meshes = own.flat_map(|(_, record)| site.element_meshes(record));
    let points: Vec<[i32; 2]> = meshes.flat_map(|mesh| mesh.vertices).map(|&[x, y, _]| [x, y]).collect();
    OrientedBox::smallest_around(&points).filter(|plan| plan.half.iter().all(|half| *half > 0.0))
}

/// Finished doors before a side of the cabin on the levels of the lift, from below.
fn landings(input: &ExportInput<'_>, all_levels: &[LevelFloor], levels: &[usize], cabin: &OrientedBox) -> Vec<Landing> {
    let mut found = Vec::new();
    for &level in levels {
        let is_here = |door: &messages::DoorRecord| door.map_storey == all_levels[level].map_storey;
        for (door, record) in (0..).zip(input.site.doors).filter(|(_, d)| is_here(d) && is_hung(input, d)) {
            let off = [0, 1].map(|k| record.passage.centre[k] - cabin.centre[k]);
            let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
            let axes = [cabin.axis, cabin.across()];
            let place = axes.map(|axis| dot(off, axis));
            let direction = axes.map(|axis| dot(record.passage.axis, axis));
            let is_before = |side: &Side| {
                let [out, along] = side.axes();
                let reach = |axis: [f64; 2]| (axis[0] * cabin.half[0]).abs() + (axis[1] * cabin.half[1]).abs();
                let gap = dot(place, out) - reach(out);
                (-record.passage.half[1]..=LANDING_M * f64::from(TENTHS_PER_M)).contains(&gap)
                    && dot(place, along).abs() <= reach(along)
                    && dot(direction, along).abs() >= PARALLEL
            };
            if let Some(side) = Side::ALL.into_iter().find(is_before) {
                let per_m = f64::from(TENTHS_PER_M);
                let along_m = dot(place, side.axes()[1]) / per_m;
                found.push(Landing { door, level, side, along_m, width_m: 2.0 * record.passage.half[0] / per_m });
            }
        }
    }
    found
}
