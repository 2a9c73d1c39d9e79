//! Levels at other heights within a storey: selection and names.

use crate::floor_levels::dominant_height;
use crate::floor_samples::{FloorTriangles, STEP};
use crate::storeys::{MapStorey, SpaceFloor};
use crate::walkable::{HEADROOM, WalkableFloor};
use frames::TENTHS_PER_M;
use geometry::{Bounds, MeshView, MultiPolygon, close_gaps, union_of};
use grid::overlapped_cells;
use messages::FloorKind;

/// A level has at least this much connected floor.
const MIN_LEVEL_M2: f64 = 5.0;

/// A room lies on a level whose height is this near to its own: rooms may begin at the slab, below the finish.
const ROOM_REACH: i32 = 3 * TENTHS_PER_M / 20;

/// Of a room at least this much lies on a level, or half of it.
const MIN_ROOM_M2: f64 = 1.0;

/// A riser: the highest step that people take between two levels, or from a stair's end.
const RISER: i32 = TENTHS_PER_M / 4;

/// A door or a stair this near to a level leads to it.
const BESIDE: i32 = TENTHS_PER_M / 2;

/// A step between two levels is at least this long, in metres.
const MIN_STEP_LENGTH_M: f64 = 0.5;

/// Spaces this near to each other are one floor.
const WALL: i32 = TENTHS_PER_M / 2;

/// Rooms of an assumed storey farther from its floor than this are not on it.
const ASSUMED_REACH: i32 = 3 * TENTHS_PER_M / 2;

/// An access to a floor.
#[derive(Debug, Clone)]
pub(crate) enum Access {
    /// A door: its plan and its sill.
    Door { plan: Bounds, sill_z: i32 },
    /// A flight of a stair or a ramp: its vertices.
    Flight { vertices: Vec<[i32; 3]> },
    /// A slab that is sloped: the corners of its sloped faces. It leads to a level from one that is walked.
    Slope { vertices: Vec<[i32; 3]> },
}

/// Inputs of the search for levels, beside the storeys.
pub(crate) struct LevelInputs<'a> {
    /// Level faces of slabs, coverings and pavements.
    pub(crate) level_faces: &'a FloorTriangles,
    /// Bodies between lowest and highest point that leave no room below them.
    pub(crate) bodies: &'a [([i32; 2], Vec<MeshView<'a>>)],
    /// Doors, stairs, ramps and sloped slabs.
    pub(crate) accesses: &'a [Access],
    /// Rooms.
    pub(crate) spaces: &'a [SpaceFloor],
    /// The map storey that each storey of the files belongs to.
    pub(crate) map_storey_of: &'a [Option<usize>],
}

/// Maps that a site can have: grids are published in that many slots.
pub(crate) const MAX_MAP_STOREYS: usize = 64;

/// Floor of one height that is connected, beside the storeys' own.
#[derive(Debug)]
struct FloorPatch {
    z: i32,
    area_m2: f64,
    samples: Vec<usize>,
    /// Area of rooms on it by their map storey.
    rooms: Vec<(Option<usize>, f64)>,
}

/// A level beside those of the storeys.
#[derive(Debug, Clone, PartialEq)]
struct SplitLevel {
    z: i32,
    floor: FloorKind,
    /// Map storey that it is a level of.
    of: usize,
    area_m2: f64,
}

/// Adds the levels of the storeys at other heights behind them, from low to high; of the levels of a storey the one with
/// most area of rooms keeps the storey's name and place. Returns how many found no place among the maps of a site.
pub(crate) fn add_levels(mapped: &mut Vec<MapStorey>, around: &LevelInputs<'_>) -> usize {
    let mut levels = split_levels(mapped, around);
    let n_left_out = (mapped.len() + levels.len()).saturating_sub(MAX_MAP_STOREYS).min(levels.len());
    levels.truncate(levels.len() - n_left_out);
    let heights: Vec<i32> = mapped.iter().map(|m| m.z).chain(levels.iter().map(|l| l.z)).collect();
    let room_m2 = |z: i32| -> f64 {
        let nearest = |s: &&SpaceFloor| heights.iter().copied().min_by_key(|h| (h - s.z).abs()) == Some(z);
        around.spaces.iter().filter(nearest).map(|s| s.area_m2).sum()
    };
    for (index, storey) in mapped.iter_mut().enumerate() {
        let own = levels.iter_mut().filter(|l| l.of == index);
        let largest = own.max_by(|a, b| room_m2(a.z).total_cmp(&room_m2(b.z)).then(b.z.cmp(&a.z)));
        if let Some(level) = largest.filter(|l| room_m2(l.z) > room_m2(storey.z)) {
            std::mem::swap(&mut level.z, &mut storey.z);
            std::mem::swap(&mut level.floor, &mut storey.floor);
        }
    }
    levels.sort_by_key(|l| (l.z, l.of));
    let named_after = |of: usize| mapped[of].named_after;
    let storey =
        |l: &SplitLevel| MapStorey { z: l.z, floor: l.floor, named_after: named_after(l.of), level_of: Some(l.of) };
    let added: Vec<MapStorey> = levels.iter().map(storey).collect();
    mapped.extend(added);
    n_left_out
}

/// The levels beside the storeys' own floors that have a room, or to which a door, a stair, a step or a ramp leads: those
/// with the largest floor first.
fn split_levels(mapped: &[MapStorey], around: &LevelInputs<'_>) -> Vec<SplitLevel> {
    let mut levels = built_levels(mapped, around);
    levels.extend(assumed_levels(mapped, around));
    levels.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2).then(a.z.cmp(&b.z)));
    let mut chosen: Vec<SplitLevel> = Vec::new();
    for level in levels {
        if chosen.iter().all(|other| (other.z - level.z).abs() > STEP) {
            chosen.push(level);
        }
    }
    chosen
}

fn is_mapped(mapped: &[MapStorey], z: i32) -> bool {
    mapped.iter().any(|m| (m.z - z).abs() <= STEP)
}

fn built_levels(mapped: &[MapStorey], around: &LevelInputs<'_>) -> Vec<SplitLevel> {
    if mapped.iter().all(|m| m.floor == FloorKind::Missing) {
        return Vec::new();
    }
    let other: FloorTriangles =
        around.level_faces.iter().filter(|t| t.iter().any(|v| !is_mapped(mapped, v[2]))).copied().collect();
    let other = large(other);
    let Some(bounds) = Bounds::of(other.iter().flatten().map(|v| [v[0], v[1]])) else { return Vec::new() };
    let Some(mut walkable) = WalkableFloor::new(around.level_faces, grown(bounds, BESIDE)) else { return Vec::new() };
    let z = || other.iter().flatten().map(|v| v[2]);
    let (lowest, highest) = (z().min().unwrap_or(0), z().max().unwrap_or(0));
    for (range, meshes) in around.bodies {
        if lowest - STEP <= range[1] && range[0] <= highest + HEADROOM {
            meshes.iter().for_each(|mesh| walkable.close_below(*mesh));
        }
    }
    let patches = patches(&walkable, mapped, around);
    let walked = walked(&walkable, &patches, mapped, around);
    let walked = patches.iter().zip(walked).filter(|(_, walked)| *walked);
    let level = |patch: &FloorPatch| SplitLevel {
        z: patch.z,
        floor: FloorKind::Built,
        of: owner(patch, mapped),
        area_m2: patch.area_m2,
    };
    walked.map(|(patch, _)| level(patch)).collect()
}

fn grown(bounds: Bounds, by: i32) -> Bounds {
    Bounds { min: bounds.min.map(|c| c.saturating_sub(by)), max: bounds.max.map(|c| c.saturating_add(by)) }
}

/// The triangles at heights around which there is enough floor for a level.
fn large(mut faces: FloorTriangles) -> FloorTriangles {
    faces.sort_unstable_by_key(|t| t[0][2]);
    let area = |t: &[[i32; 3]; 3]| {
        let d = |k: usize, i: usize| f64::from(t[k][i]) - f64::from(t[0][i]);
        (d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)) / 2.0 / f64::from(TENTHS_PER_M).powi(2)
    };
    let mut is_large = vec![false; faces.len()];
    let (mut first, mut sum_m2) = (0, 0.0);
    for last in 0..faces.len() {
        sum_m2 += area(&faces[last]);
        while faces[last][0][2] - faces[first][0][2] > 2 * STEP {
            sum_m2 -= area(&faces[first]);
            first += 1;
        }
        if sum_m2 >= MIN_LEVEL_M2 * 0.99 {
            is_large[first..=last].fill(true);
        }
    }
    let mut kept = is_large.iter();
    faces.retain(|_| kept.next() == Some(&true));
    faces
}

/// Connected floor beside the storeys' own that is large enough, each with the rooms on it.
fn patches(walkable: &WalkableFloor, mapped: &[MapStorey], around: &LevelInputs<'_>) -> Vec<FloorPatch> {
    let is_other: Vec<bool> = walkable.samples.iter().map(|s| !is_mapped(mapped, s.1)).collect();
    let wide = walkable.wide(&is_other);
    let mut taken = vec![false; walkable.samples.len()];
    let mut patches = Vec::new();
    for start in 0..walkable.samples.len() {
        if taken[start] || !wide[start] {
            continue;
        }
        let samples = connected(walkable, &wide, &is_other, &mut taken, start);
        let mut heights: Vec<i32> = samples.iter().map(|&k| walkable.samples[k].1).collect();
        heights.sort_unstable();
        let Some(z) = dominant_height(&heights, heights[0]) else { continue };
        let samples: Vec<usize> = samples.into_iter().filter(|&k| (walkable.samples[k].1 - z).abs() <= STEP).collect();
        let area_m2 = samples.len() as f64 * walkable.sample_m2();
        // Samples on the rim of a floor of exactly this area may be missing.
        if area_m2 >= MIN_LEVEL_M2 * 0.98 && !is_mapped(mapped, z) {
            let rooms = rooms_on(walkable, &samples, z, around);
            patches.push(FloorPatch { z, area_m2, samples, rooms });
        }
    }
    patches
}

/// The samples of the floor around `start`: wide ones beside each other, and what is within half a
/// person's width of them.
fn connected(walkable: &WalkableFloor, wide: &[bool], counts: &[bool], taken: &mut [bool], start: usize) -> Vec<usize> {
    let mut waiting = vec![start];
    let mut found = vec![start];
    taken[start] = true;
    let rim = walkable.width_reach().max(1);
    while let Some(at) = waiting.pop() {
        let beside: Vec<usize> = walkable.around(at, 1).collect();
        for next in walkable.around(at, rim) {
            let is_level = (walkable.samples[next].1 - walkable.samples[at].1).abs() <= STEP;
            // Wide floor on the other side of a thin wall is another patch.
            let is_apart = wide[next] && !beside.contains(&next);
            if taken[next] || !counts[next] || !is_level || is_apart {
                continue;
            }
            taken[next] = true;
            found.push(next);
            if wide[next] {
                waiting.push(next);
            }
        }
    }
    found
}

/// Area of the rooms at a height on these samples, by the map storey that the rooms belong to.
fn rooms_on(
    walkable: &WalkableFloor,
    samples: &[usize],
    z: i32,
    around: &LevelInputs<'_>,
) -> Vec<(Option<usize>, f64)> {
    let mut is_here = vec![false; walkable.spec.n_cells()];
    samples.iter().for_each(|&k| is_here[walkable.samples[k].0 as usize] = true);
    let mut rooms = Vec::new();
    for space in around.spaces.iter().filter(|s| (s.z - z).abs() <= ROOM_REACH) {
        let runs = overlapped_cells(&space.polygon, &[], &walkable.spec);
        let places = runs.iter().flat_map(|r| {
            let row = r.row as usize * walkable.spec.width as usize;
            row + r.start as usize..row + r.end as usize
        });
        let area_m2 = places.filter(|&place| is_here[place]).count() as f64 * walkable.sample_m2();
        if area_m2 >= MIN_ROOM_M2.min(space.area_m2 / 2.0) {
            let of = space.storey.and_then(|k| around.map_storey_of.get(k).copied().flatten());
            rooms.push((of, area_m2));
        }
    }
    rooms
}

/// Which patches have a room, a door, a flight that ends there, or a step to floor that is walked.
fn walked(
    walkable: &WalkableFloor,
    patches: &[FloorPatch],
    mapped: &[MapStorey],
    around: &LevelInputs<'_>,
) -> Vec<bool> {
    let mut walked: Vec<bool> =
        patches.iter().map(|p| !p.rooms.is_empty() || has_access(walkable, p, patches, mapped, around)).collect();
    let mut patch_of: Vec<Option<usize>> = vec![None; walkable.samples.len()];
    for (k, patch) in patches.iter().enumerate() {
        patch.samples.iter().for_each(|&sample| patch_of[sample] = Some(k));
    }
    loop {
        let step = |patch: &FloorPatch| {
            let leads = |sample: &&usize| {
                walkable.around(**sample, 1).any(|next| {
                    let z = walkable.samples[next].1;
                    let is_walked = is_mapped(mapped, z) || patch_of[next].is_some_and(|other| walked[other]);
                    is_walked && (STEP..=RISER).contains(&(z - patch.z).abs())
                })
            };
            let n_least = (MIN_STEP_LENGTH_M / walkable.spec.resolution_m()).ceil() as usize;
            patch.samples.iter().filter(leads).take(n_least).count() == n_least
        };
        let height_is_walked = |z: i32| {
            let others = patches.iter().zip(&walked).filter(|(_, walked)| **walked).map(|(patch, _)| patch.z);
            mapped.iter().map(|m| m.z).chain(others).any(|other| (other - z).abs() <= STEP)
        };
        let slope = |patch: &FloorPatch| {
            let beside = PatchExtent::of(walkable, patch);
            beside.is_some_and(|b| {
                around.accesses.iter().any(|access| slope_leads(access, patch.z, &b, height_is_walked))
            })
        };
        let is_next = |k: &usize| !walked[*k] && (step(&patches[*k]) || slope(&patches[*k]));
        let Some(next) = (0..patches.len()).find(is_next) else { return walked };
        walked[next] = true;
    }
}

/// True if a door or a flight leads to the patch.
fn has_access(
    walkable: &WalkableFloor,
    patch: &FloorPatch,
    patches: &[FloorPatch],
    mapped: &[MapStorey],
    around: &LevelInputs<'_>,
) -> bool {
    let Some(beside) = PatchExtent::of(walkable, patch) else { return false };
    // A flight that ends at another floor does not lead to one a riser away from it.
    let is_nearest = |z: i32| {
        let far = (z - patch.z).abs();
        let others = mapped.iter().map(|m| m.z).chain(patches.iter().map(|p| p.z));
        far <= RISER && others.into_iter().all(|other| far <= (other - z).abs())
    };
    around.accesses.iter().any(|access| match access {
        Access::Door { plan, sill_z } => (sill_z - patch.z).abs() <= RISER && beside.is_near(*plan),
        Access::Flight { vertices } => {
            let z = || vertices.iter().map(|v| v[2]);
            let ends: Vec<i32> = [z().min(), z().max()].into_iter().flatten().filter(|z| is_nearest(*z)).collect();
            let leads =
                |v: &&[i32; 3]| (v[2] - patch.z).abs() <= STEP || ends.iter().any(|end| (v[2] - end).abs() <= STEP);
            beside.any_is_near(vertices.iter().filter(leads).map(|v| [v[0], v[1]]))
        }
        // What leads up it decides, see [`slope_leads`].
        Access::Slope { .. } => false,
    })
}

/// True if a sloped slab ends at a level of this height, and its other end is at a height that is walked.
fn slope_leads(access: &Access, z: i32, beside: &PatchExtent, is_walked: impl Fn(i32) -> bool) -> bool {
    let Access::Slope { vertices } = access else { return false };
    let heights = || vertices.iter().map(|v| v[2]);
    let (Some(low), Some(high)) = (heights().min(), heights().max()) else { return false };
    [(low, high), (high, low)].into_iter().any(|(end, other)| {
        let at_end = vertices.iter().filter(|v| (v[2] - end).abs() <= STEP).map(|v| [v[0], v[1]]);
        (end - z).abs() <= STEP && is_walked(other) && beside.any_is_near(at_end)
    })
}

/// Extent of a patch in plan.
struct PatchExtent {
    places: Vec<[i32; 2]>,
    bounds: Bounds,
}

impl PatchExtent {
    fn of(walkable: &WalkableFloor, patch: &FloorPatch) -> Option<Self> {
        let size = i64::from(walkable.spec.cell_tenths);
        let at = |sample: &usize| {
            let place = i64::from(walkable.samples[*sample].0);
            let cell = [place % i64::from(walkable.spec.width), place / i64::from(walkable.spec.width)];
            [0, 1].map(|k| ((cell[k] + i64::from(walkable.spec.first_cell[k])) * size + size / 2) as i32)
        };
        let places: Vec<[i32; 2]> = patch.samples.iter().map(at).collect();
        let bounds = grown(Bounds::of(places.iter().copied())?, BESIDE);
        Some(Self { places, bounds })
    }

    /// True if the patch is no farther from a rectangle than from what is beside it.
    fn is_near(&self, plan: Bounds) -> bool {
        let around = grown(plan, BESIDE);
        plan.meets(&self.bounds) && self.places.iter().any(|p| lies_in(p, &around))
    }

    /// The same for any of some points.
    fn any_is_near(&self, points: impl Iterator<Item = [i32; 2]>) -> bool {
        let mut near: Vec<[i32; 2]> = points.filter(|p| lies_in(p, &self.bounds)).collect();
        near.sort_unstable();
        near.dedup();
        near.into_iter().any(|p| {
            let around = grown(Bounds { min: p, max: p }, BESIDE);
            self.places.iter().any(|place| lies_in(place, &around))
        })
    }
}

fn lies_in(p: &[i32; 2], bounds: &Bounds) -> bool {
    (0..2).all(|k| bounds.min[k] <= p[k] && p[k] <= bounds.max[k])
}

/// The map storey that a patch is a level of: that of most of its rooms, else the nearest in height, of two the lower.
fn owner(patch: &FloorPatch, mapped: &[MapStorey]) -> usize {
    let area = |k: usize| patch.rooms.iter().filter(|r| r.0 == Some(k)).map(|r| r.1).sum::<f64>();
    let by_rooms = (0..mapped.len()).filter(|&k| area(k) > 0.0).max_by(|&a, &b| area(a).total_cmp(&area(b)));
    by_rooms.unwrap_or_else(|| nearest(patch.z, mapped))
}

fn nearest(z: i32, mapped: &[MapStorey]) -> usize {
    (0..mapped.len()).min_by_key(|&k| ((mapped[k].z - z).abs(), mapped[k].z)).unwrap_or(0)
}

/// Levels of storeys whose floor is that of their spaces: where spaces lie higher or lower.
fn assumed_levels(mapped: &[MapStorey], around: &LevelInputs<'_>) -> Vec<SplitLevel> {
    let of = |space: &SpaceFloor| {
        let own = space.storey.and_then(|k| around.map_storey_of.get(k).copied().flatten());
        own.unwrap_or_else(|| nearest(space.z, mapped))
    };
    let is_other = |s: &&SpaceFloor| {
        let storey = mapped.get(of(s)).filter(|m| m.floor == FloorKind::AssumedFromSpaces);
        !s.is_external && !is_mapped(mapped, s.z) && storey.is_some_and(|m| (m.z - s.z).abs() <= ASSUMED_REACH)
    };
    let mut spaces: Vec<&SpaceFloor> = around.spaces.iter().filter(is_other).collect();
    spaces.sort_by_key(|s| (of(s), s.z));
    let mut levels = Vec::new();
    for group in spaces.chunk_by(|a, b| of(a) == of(b) && b.z - a.z <= STEP) {
        let floor: MultiPolygon = close_gaps(&union_of(group.iter().map(|s| &s.polygon)), WALL);
        let areas = floor.0.into_iter().map(|polygon| MultiPolygon(vec![polygon]).area_m2());
        let area_m2 = areas.fold(0.0, f64::max);
        let Some(largest) = group.iter().max_by(|a, b| a.area_m2.total_cmp(&b.area_m2)) else { continue };
        if area_m2 >= MIN_LEVEL_M2 {
            levels.push(SplitLevel { z: largest.z, floor: FloorKind::AssumedFromSpaces, of: of(largest), area_m2 });
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walkable::tests::cuboid;
    use geometry::{FillRule, union, upward_triangles};

    /// Boxes in metres that are floor, boxes that are not, spaces and ways onto floor; the storey of the file is mapped at 0.
    #[derive(Default)]
    struct House {
        slabs: Vec<[[f64; 3]; 2]>,
        bodies: Vec<[[f64; 3]; 2]>,
        spaces: Vec<SpaceFloor>,
        accesses: Vec<Access>,
    }

    fn tenths(m: f64) -> i32 {
        (m * f64::from(TENTHS_PER_M)).round() as i32
    }

    impl House {
        /// Ten by ten metres of floor at 0.
        fn new() -> Self {
            Self { slabs: vec![[[0.0, 0.0, -0.3], [10.0, 10.0, 0.0]]], ..Self::default() }
        }

        /// A slab to the east of the house, so wide and so high.
        fn beside(mut self, width_m: f64, top_m: f64) -> Self {
            self.slabs.push([[10.0, 0.0, top_m - 0.3], [10.0 + width_m, 10.0, top_m]]);
            self
        }

        fn room(mut self, [x0, x1]: [f64; 2], z_m: f64) -> Self {
            let [x0, x1, y1] = [x0, x1, 10.0].map(tenths);
            let polygon = union(&[vec![[x0, 0], [x1, 0], [x1, y1], [x0, y1]]], FillRule::NonZero);
            let area_m2 = polygon.area_m2();
            self.spaces.push(SpaceFloor {
                polygon,
                z: tenths(z_m),
                area_m2,
                storey: Some(0),
                is_external: false,
                is_void: false,
            });
            self
        }

        fn levels_of(&self, floor: FloorKind) -> Vec<(f64, Option<usize>)> {
            let body = |[min, max]: &[[f64; 3]; 2]| cuboid(min.map(tenths), max.map(tenths));
            let meshes: Vec<_> = self.slabs.iter().chain(&self.bodies).map(body).collect();
            let view = |k: usize| MeshView { vertices: &meshes[k].0, triangles: &meshes[k].1, closed: true };
            let level_faces: FloorTriangles =
                (0..self.slabs.len()).flat_map(|k| upward_triangles(view(k), 0.01)).collect();
            let bodies: Vec<_> = (0..meshes.len())
                .map(|k| {
                    let (low, high) = view(k).z_range().unwrap();
                    ([low, high], vec![view(k)])
                })
                .collect();
            let around = LevelInputs {
                level_faces: &level_faces,
                bodies: &bodies,
                accesses: &self.accesses,
                spaces: &self.spaces,
                map_storey_of: &[Some(0)],
            };
            let mut mapped = vec![MapStorey { z: 0, floor, named_after: Some(0), level_of: None }];
            assert_eq!(add_levels(&mut mapped, &around), 0);
            mapped.iter().map(|m| (frames::metres(m.z), m.level_of)).collect()
        }

        fn levels(&self) -> Vec<(f64, Option<usize>)> {
            self.levels_of(FloorKind::Built)
        }
    }

    const PLAIN: (f64, Option<usize>) = (0.0, None);

    #[test]
    fn a_lower_part_with_a_room_is_a_level_of_its_own() {
        let house = House::new().beside(4.0, -0.45).room([0.0, 10.0], 0.0).room([10.0, 14.0], -0.45);
        assert_eq!(house.levels(), [PLAIN, (-0.45, Some(0))]);
        let half_a_storey = House::new().beside(4.0, 1.4).room([10.0, 14.0], 1.4).room([0.0, 10.0], 0.0);
        assert_eq!(half_a_storey.levels(), [PLAIN, (1.4, Some(0))]);
    }

    #[test]
    fn the_level_with_most_room_area_keeps_the_plain_name() {
        let house = House::new().beside(20.0, 0.45).room([0.0, 4.0], 0.0).room([10.0, 30.0], 0.45);
        assert_eq!(house.levels(), [(0.45, None), (0.0, Some(0))]);
    }

    #[test]
    fn a_canopy_and_a_patch_of_roof_are_no_levels() {
        assert_eq!(House::new().beside(4.0, 2.5).levels(), [PLAIN]);
        assert_eq!(House::new().beside(4.0, 0.6).levels(), [PLAIN], "too high for a step");
    }

    #[test]
    fn a_step_a_door_and_a_stair_lead_to_a_level() {
        assert_eq!(House::new().beside(4.0, 0.13).levels(), [PLAIN, (0.13, Some(0))], "a step");
        let mut roof = House::new().beside(4.0, 2.5);
        let plan = Bounds { min: [tenths(12.0), tenths(10.0)], max: [tenths(13.0), tenths(10.2)] };
        roof.accesses = vec![Access::Door { plan, sill_z: tenths(2.5) }];
        assert_eq!(roof.levels(), [PLAIN, (2.5, Some(0))], "a door");
        let vertices = [[9.0, 1.0, 0.0], [9.8, 1.0, 2.3]].map(|v: [f64; 3]| v.map(tenths)).to_vec();
        roof.accesses = vec![Access::Flight { vertices: vertices.clone() }];
        assert_eq!(roof.levels(), [PLAIN, (2.5, Some(0))], "a stair whose last riser is the floor's edge");
        let away = vertices.iter().map(|v| [v[0] - tenths(5.0), v[1], v[2]]).collect();
        roof.accesses = vec![Access::Flight { vertices: away }];
        assert_eq!(roof.levels(), [PLAIN], "a stair elsewhere");
    }

    #[test]
    fn a_level_has_five_square_metres_of_connected_floor() {
        let with = |width_m: f64| House::new().beside(width_m, -0.45).room([10.0, 12.0], -0.45).levels().len();
        assert_eq!([0.45, 0.6, 1.0].map(with), [1, 2, 2], "4.5 m2, 6 m2, 10 m2");
        let mut parted = House::new().beside(0.8, -0.45).room([10.0, 10.8], -0.45);
        assert_eq!(parted.levels().len(), 2);
        parted.bodies.push([[10.0, 4.8, -0.45], [10.8, 5.2, 2.0]]);
        assert_eq!(parted.levels(), [PLAIN], "a wall makes two of 3.8 m2 of it");
    }

    #[test]
    fn a_level_has_headroom() {
        let with = |bottom_m: f64| {
            let mut house = House::new().beside(4.0, -0.45).room([10.0, 14.0], -0.45);
            house.bodies.push([[10.0, 0.0, bottom_m], [14.0, 10.0, 3.0]]);
            house.levels().len()
        };
        assert_eq!((with(0.8), with(0.9)), (1, 2));
    }

    #[test]
    fn a_slab_below_a_screed_is_no_level() {
        let mut house = House::new().room([0.0, 10.0], 0.0);
        house.slabs.push([[0.0, 0.0, -0.6], [10.0, 10.0, -0.3]]);
        assert_eq!(house.levels(), [PLAIN]);
    }

    #[test]
    fn five_centimetres_are_one_level() {
        assert_eq!(House::new().beside(4.0, 0.05).room([10.0, 14.0], 0.05).levels(), [PLAIN]);
        assert_eq!(House::new().beside(4.0, 0.06).room([10.0, 14.0], 0.06).levels().len(), 2);
    }

    #[test]
    fn rooms_of_an_assumed_storey_at_other_heights_are_levels() {
        let house = House { slabs: vec![], ..House::new() }.room([0.0, 10.0], 0.0).room([10.0, 14.0], -0.45);
        assert_eq!(house.levels_of(FloorKind::AssumedFromSpaces), [PLAIN, (-0.45, Some(0))]);
        assert_eq!(house.levels(), [PLAIN], "a space is no floor of a storey with slabs");
    }
}
