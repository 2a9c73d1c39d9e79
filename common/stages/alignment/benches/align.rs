//! Cost of tracking and of pose search as storeys grow, on one thread.

use alignment::{PreparedMap, align_maps, track_map};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use frames::Rigid2;
use occupancy::{Cell, OccupancyMap};
use std::hint::black_box;

const CELL_M: f64 = 0.05;
/// Rooms of 5 x 4 m: 200, 1500 and 6000 m2.
const ROOMS: [[usize; 2]; 3] = [[4, 3], [9, 9], [18, 17]];
const ROOM_CELLS: [usize; 2] = [100, 80];
const WALL_CELLS: usize = 3;
const DOOR_CELLS: usize = 20;

/// Rooms with a door in each wall, nowhere at the same place.
fn model([across, up]: [usize; 2]) -> OccupancyMap {
    let size = [across * ROOM_CELLS[0] + WALL_CELLS, up * ROOM_CELLS[1] + WALL_CELLS];
    let mut cells = vec![Cell::Free; size[0] * size[1]];
    let mut chance: u64 = 1;
    let mut door_at = |length: usize| {
        chance = chance.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        WALL_CELLS + (chance >> 33) as usize % (length - DOOR_CELLS - WALL_CELLS)
    };
    for (k, last) in [(0, across), (1, up)] {
        let (along, rooms) = (1 - k, if k == 0 { up } else { across });
        for wall in 0..=last {
            for room in 0..rooms {
                let door = door_at(ROOM_CELLS[along]);
                let is_outer = wall == 0 || wall == last;
                for step in 0..ROOM_CELLS[along] + WALL_CELLS {
                    if !is_outer && (door..door + DOOR_CELLS).contains(&step) {
                        continue;
                    }
                    for thick in 0..WALL_CELLS {
                        let mut at = [0; 2];
                        at[k] = wall * ROOM_CELLS[k] + thick;
                        at[along] = room * ROOM_CELLS[along] + step;
                        cells[at[1] * size[0] + at[0]] = Cell::Occupied;
                    }
                }
            }
        }
    }
    OccupancyMap { width: size[0], cells, resolution_m: CELL_M, origin: [0.0; 3] }
}

/// What a robot sees of it: sides of walls, in a frame of its own.
fn seen(model: &OccupancyMap) -> OccupancyMap {
    let mut map = OccupancyMap { origin: [3.0, -2.0, 0.6], ..model.clone() };
    let (width, height) = (model.width, model.cells.len() / model.width);
    for index in 0..model.cells.len() {
        let (column, row) = (index % width, index / width);
        let is_inner = 0 < column && column + 1 < width && 0 < row && row + 1 < height;
        let beside = || [index - 1, index + 1, index - width, index + width].map(|n| model.cells[n]);
        if model.cells[index] == Cell::Occupied && (!is_inner || !beside().contains(&Cell::Free)) {
            map.cells[index] = Cell::Unknown;
        }
    }
    map
}

fn align(criterion: &mut Criterion) {
    for rooms in ROOMS {
        let reference = [PreparedMap::of_model(&model(rooms))];
        let map = seen(&model(rooms));
        let size = format!("{} m2", rooms[0] * rooms[1] * 20);
        let found = align_maps(&reference, &PreparedMap::of_slam(&map), None);
        let [x_m, y_m, yaw_rad] = found.poses.first().map_or([0.0; 3], |p| p.map_from_slam.x_y_yaw());
        let start = Rigid2::new([x_m + 0.1, y_m - 0.1], yaw_rad + 0.005);
        criterion.bench_with_input(BenchmarkId::new("follow", &size), &map, |b, map| {
            b.iter(|| track_map(&reference, &PreparedMap::of_slam(black_box(map)), (0, &start)));
        });
        criterion.bench_with_input(BenchmarkId::new("search", &size), &map, |b, map| {
            b.iter(|| align_maps(&reference, &PreparedMap::of_slam(black_box(map)), None));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = align
}
criterion_main!(benches);
