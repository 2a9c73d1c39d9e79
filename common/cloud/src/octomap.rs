//! `octomap/structure.bt` and `octomap/structure.json`: which cells of a volume structure occupies, and which the model knows to be empty.

use crate::bodies::{Effect, Filling};
use crate::octree::{MAX_CELLS, Octree, REACH, octree};
use crate::selection::{LeftOut, Selection, UnknownClass};
use export::{ExportFile, ExportInput, json_text};
use frames::TENTHS_PER_M;
use geometry::MeshView;
use messages::{ElementState, SpaceRecord, element_flags, space_flags};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What becomes cells, of which size, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct OctomapOptions {
    selection: Selection,
    /// Side of a cell, in tenths of a millimetre; even.
    cell_tenths: i64,
    /// Lower and upper corner in `map`, metres.
    volume_m: Option<[[f64; 3]; 2]>,
}

/// Options that no octree can have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OctomapOptionsError {
    /// A resolution out of range.
    #[error("a resolution of {resolution_m} m: 0.01 to 5 m is meant")]
    Resolution {
        /// The resolution.
        resolution_m: f64,
    },
    /// Not the corners of a box.
    #[error(
        "a box has a lower and an upper corner, X0,Y0,Z0,X1,Y1,Z1 in metres, each coordinate below that of the upper one"
    )]
    Volume,
    /// A class that there is not.
    #[error(transparent)]
    Class(#[from] UnknownClass),
}

/// An octree that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OctomapError {
    /// The volume does not fit into the keys of an OctoMap.
    #[error(
        "the octree would reach {farthest_m} m from the origin of the map, and at {resolution_m} m it reaches {reach_m} m: choose a \
         larger resolution, or a box of what lies nearer"
    )]
    TooFar {
        /// Largest coordinate of the volume.
        farthest_m: f64,
        /// Side of a cell.
        resolution_m: f64,
        /// Largest coordinate of an OctoMap.
        reach_m: f64,
    },
    /// Too many cells at surfaces.
    #[error(
        "the octree would have more than {MAX_CELLS} cells of {resolution_m} m at surfaces: choose a larger resolution, or a box of a \
         part"
    )]
    TooManyCells {
        /// Side of a cell.
        resolution_m: f64,
    },
}

impl OctomapOptions {
    /// Side of a cell where none is given.
    pub const RESOLUTION_M: f64 = 0.1;

    /// From the side of a cell in metres, names of classes, and the corners of the volume in `map`; the usual ones where there are
    /// none, and the bounds of structure and rooms. The side is rounded to 0.2 mm.
    ///
    /// # Errors
    /// A resolution out of range, no corners of a box, a class that there is not.
    pub fn of(resolution_m: Option<f64>, classes: &[String], volume_m: &[f64]) -> Result<Self, OctomapOptionsError> {
        let resolution_m = resolution_m.unwrap_or(Self::RESOLUTION_M);
        if !(0.01..=5.0).contains(&resolution_m) {
            return Err(OctomapOptionsError::Resolution { resolution_m });
        }
        let volume_m = match *volume_m {
            [] => None,
            [x0, y0, z0, x1, y1, z1] if x0 < x1 && y0 < y1 && z0 < z1 && volume_m.iter().all(|c| c.is_finite()) => {
                Some([[x0, y0, z0], [x1, y1, z1]])
            }
            _ => return Err(OctomapOptionsError::Volume),
        };
        let cell_tenths = 2 * (resolution_m * f64::from(TENTHS_PER_M) / 2.0).round() as i64;
        Ok(Self { selection: Selection::of(classes)?, cell_tenths, volume_m })
    }

    /// Side of a cell in metres.
    fn resolution_m(&self) -> f64 {
        self.cell_tenths as f64 / f64::from(TENTHS_PER_M)
    }

    fn metres(&self, cell: i64) -> f64 {
        (cell * self.cell_tenths) as f64 / f64::from(TENTHS_PER_M)
    }

    /// The cells of the volume: the lower corner, and that beyond the last ones.
    ///
    /// # Errors
    /// A volume that reaches too far.
    fn volume(&self, fillings: &[Filling<'_>]) -> Result<[[i64; 3]; 2], OctomapError> {
        let cell = self.cell_tenths as f64;
        let [low, high] = match self.volume_m {
            Some(corners) => corners.map(|corner| corner.map(|c| c * f64::from(TENTHS_PER_M))),
            None => bounds(fillings.iter().filter(|f| f.effect != Effect::Unknown)),
        };
        let volume = [low.map(|c| (c / cell).floor()), high.map(|c| (c / cell).ceil())];
        let farthest = volume.iter().flatten().map(|c| c.abs()).fold(0.0, f64::max);
        if farthest > REACH as f64 {
            let (resolution_m, reach_m) = (self.resolution_m(), self.metres(REACH));
            return Err(OctomapError::TooFar {
                farthest_m: export::rounded(farthest * resolution_m),
                resolution_m,
                reach_m,
            });
        }
        Ok(volume.map(|corner| corner.map(|c| c as i64)))
    }
}

/// Bounds of bodies in tenths of a millimetre; of none, nothing.
fn bounds<'a>(fillings: impl Iterator<Item = &'a Filling<'a>>) -> [[f64; 3]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for filling in fillings {
        for corner in (0..filling.n_triangles()).flat_map(|k| filling.triangle(k)) {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(f64::from(corner[k])), high[k].max(f64::from(corner[k])));
            }
        }
    }
    if low[0] > high[0] { [[0.0; 3]; 2] } else { [low, high] }
}

/// What the cells of an octree are of. Lengths in metres in `map`.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Octomap {
    /// Version of this layout: 1.
    version: u32,
    /// `map`.
    frame: &'static str,
    /// Counts changes of the map frame.
    frame_epoch: u32,
    /// Plan time; null if all elements stand.
    plan_time: Option<String>,
    /// Side of a cell.
    resolution_m: f64,
    /// Lower corner of the volume, rounded to cells. Outside of it all is unknown.
    min_m: [f64; 3],
    /// Upper corner of the volume.
    max_m: [f64; 3],
    /// Nodes of the tree.
    nodes: usize,
    /// Volume of the cells that structure occupies.
    occupied_m3: f64,
    /// Volume of the cells that are free.
    free_m3: f64,
    /// Volume of the others.
    unknown_m3: f64,
    /// Elements that occupy cells, by GlobalId.
    occupied_by: Vec<String>,
    /// Rooms in which cells are free, by GlobalId.
    free_in: Vec<String>,
    /// Elements of the selection that occupy nothing; cells that they meet are unknown, where they have a body.
    left_out: BTreeMap<String, LeftOut>,
    /// Elements that stand and whose body could not be made: nobody knows which cells they meet.
    without_body: BTreeSet<String>,
}

/// The files of an octree, in `octomap/`.
///
/// # Errors
/// A volume that reaches too far for its resolution, or too many cells.
pub fn octomap_files(input: &ExportInput<'_>, options: &OctomapOptions) -> Result<Vec<ExportFile>, OctomapError> {
    let site = input.site;
    let (structure, left_out) = options.selection.structure(input);
    let rooms = open_rooms(input);
    let fillings = fillings(input, &structure, &rooms);
    let volume = options.volume(&fillings)?;
    let resolution_m = options.resolution_m();
    let tree =
        octree(&fillings, options.cell_tenths, volume).map_err(|_| OctomapError::TooManyCells { resolution_m })?;
    let cells: u64 = (0..3).map(|k| (volume[1][k] - volume[0][k]) as u64).product();
    let m3 = |n: u64| export::rounded(n as f64 * resolution_m * resolution_m * resolution_m);
    let global_id = |element: u32| site.text(site.elements[element as usize].global_id).to_owned();
    let is_lost = |k: &u32| {
        let stands = !is_absent(input.schedule_state.effective(*k as usize));
        stands && site.elements[*k as usize].has(element_flags::FAILED)
    };
    let [min_m, max_m] = volume.map(|corner| corner.map(|c| options.metres(c)));
    let document = Octomap {
        version: 1,
        frame: "map",
        frame_epoch: site.head.frame_epoch,
        plan_time: input.schedule_state.head.plan_time().map(|time| time.to_string()),
        resolution_m,
        min_m,
        max_m,
        nodes: tree.n_nodes(),
        occupied_m3: m3(tree.n_occupied),
        free_m3: m3(tree.n_free),
        unknown_m3: m3(cells - tree.n_occupied - tree.n_free),
        occupied_by: structure.iter().map(|e| global_id(*e)).collect(),
        free_in: rooms.iter().map(|room| site.text(room.global_id).to_owned()).collect(),
        left_out: left_out.into_iter().map(|(element, why)| (global_id(element), why)).collect(),
        without_body: (0..site.elements.len() as u32).filter(is_lost).map(global_id).collect(),
    };
    Ok(vec![
        ExportFile::new("octomap/structure.bt", file(&tree, resolution_m)),
        ExportFile::new("octomap/structure.json", json_text(&document)),
    ])
}

fn is_absent(state: ElementState) -> bool {
    matches!(state, ElementState::NotStarted | ElementState::Removed)
}

/// Rooms whose volume the model knows to be empty but for elements: not closed by the schedule, no gross areas, no shafts, in which
/// lifts and pipes run.
fn open_rooms<'a>(input: &ExportInput<'a>) -> Vec<&'a SpaceRecord> {
    let is_open = |(k, space): &(usize, &SpaceRecord)| {
        !input.schedule_state.is_blocked(*k) && !space.has(space_flags::METADATA_ONLY) && !space.has(space_flags::SHAFT)
    };
    input.site.spaces.iter().enumerate().filter(is_open).map(|(_, space)| space).collect()
}

/// Structure, all else that stands or is ground, and rooms.
fn fillings<'a>(input: &ExportInput<'a>, structure: &[u32], rooms: &[&SpaceRecord]) -> Vec<Filling<'a>> {
    let site = input.site;
    let mut fillings = Vec::new();
    let mut fill = |meshes: &mut dyn Iterator<Item = MeshView<'a>>, effect| {
        fillings.extend(meshes.map(|mesh| Filling::of(mesh, effect)));
    };
    for (k, element) in
        (0..).zip(site.elements).filter(|(k, _)| !is_absent(input.schedule_state.effective(*k as usize)))
    {
        let is_structure = structure.binary_search(&k).is_ok();
        fill(&mut site.element_meshes(element), if is_structure { Effect::Occupied } else { Effect::Unknown });
    }
    site.terrains.iter().for_each(|terrain| fill(&mut site.terrain_meshes(terrain), Effect::Unknown));
    rooms.iter().for_each(|room| fill(&mut site.space_meshes(room), Effect::Free));
    fillings
}

/// A binary OctoMap.
fn file(tree: &Octree, resolution_m: f64) -> Vec<u8> {
    let n_nodes = tree.n_nodes();
    let mut bytes =
        format!("# Octomap OcTree binary file\nid OcTree\nsize {n_nodes}\nres {resolution_m}\ndata\n").into_bytes();
    // A reader of a tree without nodes reads nothing behind the header.
    if n_nodes > 0 {
        bytes.extend(&tree.bytes);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_no_octree_can_have_are_refused() {
        let refused = |resolution, volume: &[f64]| OctomapOptions::of(resolution, &[], volume).unwrap_err().to_string();
        assert_eq!(refused(Some(0.001), &[]), "a resolution of 0.001 m: 0.01 to 5 m is meant");
        for volume in [&[1.0, 2.0][..], &[0.0, 0.0, 0.0, 1.0, 0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 1.0, f64::INFINITY]] {
            assert!(refused(None, volume).starts_with("a box has a lower and an upper corner"));
        }
        assert!(OctomapOptions::of(None, &["walls".to_owned()], &[]).is_err());
    }

    #[test]
    fn a_volume_that_the_keys_do_not_hold_is_refused() {
        let options = OctomapOptions::of(Some(0.05), &[], &[0.0, 0.0, 0.0, 1_700.0, 1.0, 1.0]).unwrap();
        let why = options.volume(&[]).unwrap_err().to_string();
        assert!(why.contains("reach 1700 m") && why.contains("at 0.05 m it reaches 1638.4 m"), "{why}");
        let part = OctomapOptions::of(Some(0.05), &[], &[-0.01, 0.0, 0.0, 0.31, 1.0, 1.0]).unwrap();
        assert_eq!(part.volume(&[]), Ok([[-1, 0, 0], [7, 20, 20]]));
    }
}
