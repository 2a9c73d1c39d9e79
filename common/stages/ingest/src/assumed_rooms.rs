//! Rooms whose floor is assumed: those without any slab, where nothing lies below them or where the storey has no slabs.

use crate::floor_levels::{FloorFaces, REACH, sample_spec};
use crate::floor_samples::each_sample;
use crate::storeys::SpaceFloor;
use frames::TENTHS_PER_M;
use geometry::{Bounds, MultiPolygon, intersection};
use grid::{GridSpec, Mask, overlapped_cells};
use messages::{FloorKind, MapStoreyRecord, NONE, SiteBuilder, space_flags};

/// A room of which floor faces cover less has no slab: what covers it is the edge of a neighbour's.
const MIN_SLAB_SHARE: f64 = 0.1;

/// Something lies below a room if it does so under more of it: walls of the storey below reach under its edges.
const MAX_BELOW_SHARE: f64 = 0.02;

/// Floors of rooms this much lower are below.
const BELOW: i32 = 4 * TENTHS_PER_M / 10;

/// Marks the rooms on map storeys whose floor is assumed, in the complete model.
///
/// On a storey that is built a room without a slab has floor only if neither floor nor a room, shaft or map storey lies below
/// it: an atrium is a void, and so is what is named one. On a storey that is not, each room without a slab has. A room with a
/// slab has what is built, and what is outdoors too.
pub(crate) fn mark_assumed_rooms(
    builder: &mut SiteBuilder,
    floors: &[Option<SpaceFloor>],
    shafts: &[SpaceFloor],
    faces: &FloorFaces,
) {
    let rooms: Vec<&SpaceFloor> = floors.iter().flatten().chain(shafts).collect();
    for (index, storey) in (0..).zip(&builder.map_storeys) {
        let kind = storey.floor.get();
        if !matches!(kind, FloorKind::Built | FloorKind::AssumedFromSpaces) {
            continue;
        }
        let own = |record: &messages::SpaceRecord| record.map_storey == index && !record.has(space_flags::EXTERNAL);
        let candidates: Vec<(usize, &SpaceFloor)> = (0..floors.len())
            .filter(|&k| builder.spaces[k].map_storey != NONE && own(&builder.spaces[k]))
            .filter_map(|k| Some((k, floors[k].as_ref()?)))
            .collect();
        let Some(slabs) = SlabSamples::of(faces, &candidates, storey.floor_z_tenths) else { continue };
        let is_lower = |other: &&MapStoreyRecord| other.floor_z_tenths < storey.floor_z_tenths - BELOW;
        let lower: Vec<Bounds> = builder.map_storeys.iter().filter(is_lower).map(plan_of).collect();
        let is_assumed = |room: &SpaceFloor| {
            let [here, below] = slabs.shares(&room.polygon);
            let is_over = || below > MAX_BELOW_SHARE || lies_over_a_room(room, &rooms) || lies_over(room, &lower);
            here < MIN_SLAB_SHARE && !room.is_void && (kind == FloorKind::AssumedFromSpaces || !is_over())
        };
        for (k, room) in candidates {
            if is_assumed(room) {
                builder.spaces[k].flags |= space_flags::ASSUMED_FLOOR;
            }
        }
    }
}

fn plan_of(storey: &MapStoreyRecord) -> Bounds {
    let [x0, y0, x1, y1] = storey.bounds_tenths;
    Bounds { min: [x0, y0], max: [x1, y1] }
}

/// True if a lower map storey lies under the room.
fn lies_over(room: &SpaceFloor, lower: &[Bounds]) -> bool {
    room.polygon.bounds().is_some_and(|plan| lower.iter().any(|storey| overlap(storey, &plan)))
}

/// True if a room or a shaft with a lower floor lies under the room.
fn lies_over_a_room(room: &SpaceFloor, rooms: &[&SpaceFloor]) -> bool {
    let Some(bounds) = room.polygon.bounds() else { return false };
    let is_near =
        |other: &SpaceFloor| other.z < room.z - BELOW && other.polygon.bounds().is_some_and(|b| overlap(&b, &bounds));
    let below_m2 = |other: &&&SpaceFloor| intersection(&other.polygon, &room.polygon).area_m2();
    rooms.iter().filter(|other| is_near(other)).any(|other| below_m2(&other) > MAX_BELOW_SHARE * room.area_m2)
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    (0..2).all(|k| a.min[k] < b.max[k] && b.min[k] < a.max[k])
}

/// Places in plan at which a storey has floor faces, and at which there are some below it.
struct SlabSamples {
    spec: GridSpec,
    here: Mask,
    below: Mask,
}

impl SlabSamples {
    /// Around the rooms of a storey; `None` if it has none.
    fn of(faces: &FloorFaces, rooms: &[(usize, &SpaceFloor)], floor_z: i32) -> Option<Self> {
        let bounds = rooms.iter().filter_map(|(_, room)| room.polygon.bounds()).reduce(Bounds::joined)?;
        let spec = sample_spec(bounds)?;
        let mask = || Mask::new(spec.width as usize, spec.height as usize);
        let mut samples = Self { spec, here: mask(), below: mask() };
        let [lowest, highest] = [floor_z - REACH, floor_z + REACH];
        let reaches_up_to = |triangle: &[[i32; 3]; 3]| triangle.iter().any(|corner| corner[2] <= highest);
        for triangle in faces.slabs.iter().filter(|triangle| reaches_up_to(triangle)) {
            each_sample(&spec, triangle, |place, z| {
                samples.here.cells[place as usize] |= (lowest..=highest).contains(&z);
                samples.below.cells[place as usize] |= z < lowest;
            });
        }
        // Footings lie below walls, and are no floor that somebody falls on.
        for triangle in faces.footings.iter().filter(|triangle| reaches_up_to(triangle)) {
            each_sample(&spec, triangle, |place, z| {
                samples.here.cells[place as usize] |= (lowest..=highest).contains(&z)
            });
        }
        Some(samples)
    }

    /// Shares of a room with floor at the storey's height, and with floor below it only.
    fn shares(&self, room: &MultiPolygon) -> [f64; 2] {
        let (mut all, mut here, mut below) = (0u32, 0u32, 0u32);
        for run in overlapped_cells(room, &[], &self.spec) {
            let row = run.row as usize * self.spec.width as usize;
            for place in row + run.start as usize..row + run.end as usize {
                all += 1;
                here += u32::from(self.here.cells[place]);
                below += u32::from(self.below.cells[place] && !self.here.cells[place]);
            }
        }
        [here, below].map(|n| f64::from(n) / f64::from(all.max(1)))
    }
}
