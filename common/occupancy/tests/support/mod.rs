//! Drawn buildings, as model maps and as simulated SLAM maps.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]
#![allow(dead_code, reason = "every test file uses a part of this")]

#[path = "../../../messages/tests/support/box_part.rs"]
mod box_part;

use box_part::{add_box_part, box_element};
use bytemuck::Zeroable;
use frames::{Map, Rigid2, Slam};
use grid::Class;
use messages::*;
use occupancy::{Cell, OccupancyMap};

/// Walls as boxes: x from, y from, x to, y to, in metres.
pub(crate) type Walls = Vec<[f64; 4]>;

/// A flat of 12 x 9 m that looks like itself in no other pose.
pub(crate) fn flat() -> Walls {
    vec![
        [0.0, 0.0, 12.0, 0.2],
        [0.0, 8.8, 12.0, 9.0],
        [0.0, 0.0, 0.2, 9.0],
        [11.8, 0.0, 12.0, 9.0],
        [4.0, 0.2, 4.15, 3.6],
        [4.0, 4.6, 4.15, 8.8],
        [4.15, 5.2, 9.0, 5.35],
        [10.0, 5.2, 11.8, 5.35],
        [7.3, 0.2, 7.45, 2.0],
        [7.3, 3.0, 7.45, 5.2],
        [0.2, 6.4, 2.0, 6.55],
    ]
}

/// Two rooms of 5 x 6 m, the one a half turn of the other.
pub(crate) fn twin() -> Walls {
    let half: Walls = vec![
        [0.0, 0.0, 5.0, 0.2],
        [0.0, 5.8, 10.0, 6.0],
        [0.0, 0.0, 0.2, 6.0],
        [1.5, 3.0, 3.5, 3.15],
        [2.4, 0.2, 2.55, 1.9],
    ];
    let turned = |[a, b, c, d]: &[f64; 4]| [10.0 - c, 6.0 - d, 10.0 - a, 6.0 - b];
    half.iter().copied().chain(half.iter().map(turned)).collect()
}

fn bounds(walls: &Walls) -> [f64; 2] {
    [2, 3].map(|k| walls.iter().map(|w| w[k]).fold(0.0, f64::max))
}

/// The map of the model: walls, floor between them, unknown outside.
pub(crate) fn model(walls: &Walls) -> OccupancyMap {
    let [wide, high] = bounds(walls);
    let (width, height) = ((wide / 0.05) as usize + 40, (high / 0.05) as usize + 40);
    let cell = |k: usize| {
        let p = [k % width, k / width].map(|c| (c as f64 + 0.5) * 0.05 - 1.0);
        match inside(walls, p) {
            true => Cell::Occupied,
            false if p[0] > 0.0 && p[1] > 0.0 && p[0] < wide && p[1] < high => Cell::Free,
            false => Cell::Unknown,
        }
    };
    OccupancyMap {
        width,
        cells: (0..width * height).map(cell).collect(),
        resolution_m: 0.05,
        origin: [-1.0, -1.0, 0.0],
    }
}

pub(crate) fn inside(walls: &Walls, [x, y]: [f64; 2]) -> bool {
    walls.iter().any(|w| w[0] <= x && x < w[2] && w[1] <= y && y < w[3])
}

/// What a lidar that turns around sees from these places, in its own frame.
pub(crate) fn scanned(
    walls: &Walls,
    places: &[[f64; 2]],
    map_from_slam: Rigid2<Map, Slam>,
    resolution_m: f64,
    origin_yaw_rad: f64,
) -> OccupancyMap {
    scanned_bent(walls, places, map_from_slam, resolution_m, origin_yaw_rad, &|p| p)
}

/// The same by a robot that takes places for others.
pub(crate) fn scanned_bent(
    walls: &Walls,
    places: &[[f64; 2]],
    map_from_slam: Rigid2<Map, Slam>,
    resolution_m: f64,
    origin_yaw_rad: f64,
    believed: &dyn Fn([f64; 2]) -> [f64; 2],
) -> OccupancyMap {
    let n = (30.0 / resolution_m) as usize;
    let slam_from_map = map_from_slam.inverse();
    let middle = slam_from_map.apply(places[0]);
    let (sin, cos) = libm::sincos(origin_yaw_rad);
    // The corner from which the first place is in the middle of the square.
    let half = n as f64 * resolution_m / 2.0;
    let origin = [middle[0] - cos * half + sin * half, middle[1] - sin * half - cos * half];
    let mut cells = vec![Cell::Unknown; n * n];
    let mut mark = |p: [f64; 2], what: Cell| {
        let q = slam_from_map.apply(believed(p));
        let d = [q[0] - origin[0], q[1] - origin[1]];
        let [x, y] = [cos * d[0] + sin * d[1], -sin * d[0] + cos * d[1]].map(|c| (c / resolution_m) as usize);
        if x < n && y < n && cells[y * n + x] != Cell::Occupied {
            cells[y * n + x] = what;
        }
    };
    for place in places {
        for k in 0..2000 {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 2000.0);
            for step in 1..1200 {
                let far = f64::from(step) * 0.01;
                let p = [place[0] + cos * far, place[1] + sin * far];
                if inside(walls, p) {
                    mark(p, Cell::Occupied);
                    break;
                }
                mark(p, Cell::Free);
            }
        }
    }
    OccupancyMap { width: n, cells, resolution_m, origin: [origin[0], origin[1], origin_yaw_rad] }
}

pub(crate) const PLACES: [[f64; 2]; 4] = [[2.0, 2.0], [2.0, 7.5], [5.5, 3.5], [9.5, 7.0]];

/// Metres to tenths of a millimetre.
fn t(m: f64) -> i32 {
    frames::tenths(m).unwrap()
}

/// A storey to be: elements as boxes that stand on the floor.
#[derive(Default)]
pub(crate) struct Storey {
    pub(crate) builder: SiteBuilder,
}

impl Storey {
    pub(crate) fn of(walls: &Walls) -> Self {
        let mut storey = Self::default();
        walls.iter().for_each(|w| {
            storey.add(Class::Wall, *w, [0.0, 2.5]);
        });
        storey
    }

    /// Adds a box between two heights; its index.
    pub(crate) fn add(&mut self, class: Class, [x0, y0, x1, y1]: [f64; 4], [lo, hi]: [f64; 2]) -> usize {
        let (min, max) = ([x0, y0, lo].map(t), [x1, y1, hi].map(t));
        let b = &mut self.builder;
        let first_part = add_box_part(b, min, max);
        b.elements.push(box_element(class, first_part, [min, max]));
        b.elements.len() - 1
    }

    /// Adds a door that fills a box in a wall along x.
    pub(crate) fn door(&mut self, [x0, y0, x1, y1]: [f64; 4]) -> usize {
        let element = self.add(Class::Door, [x0, y0, x1, y1], [0.0, 2.1]);
        let half = [(x1 - x0) / 2.0, (y1 - y0) / 2.0].map(|h| h * 1e4);
        let passage = BoxRecord { centre: [(x0 + x1) * 5e3, (y0 + y1) * 5e3], axis: [1.0, 0.0], half };
        self.builder.elements[element].door = self.builder.doors.len() as u32;
        self.builder.doors.push(DoorRecord {
            clear_width_from: ClearWidth::Assumed.into(),
            element: element as u32,
            opening: NONE,
            spaces: [NONE; 2],
            beside: [NONE; 2],
            overall_width_m: x1 - x0,
            passage,
            ..Zeroable::zeroed()
        });
        element
    }

    pub(crate) fn site(mut self) -> ArchiveBuffer {
        let name = self.builder.texts.add("Ground");
        let corners = |of: fn(&ElementRecord) -> [i32; 3]| self.builder.elements.iter().map(of).collect::<Vec<_>>();
        let (min, max) = (corners(|e| e.min_tenths), corners(|e| e.max_tenths));
        let least = |k: usize| min.iter().map(|p| p[k]).min().unwrap();
        let most = |k: usize| max.iter().map(|p| p[k]).max().unwrap();
        self.builder.map_storeys.push(MapStoreyRecord {
            global_id: Text::default(),
            name,
            floor_z_tenths: 0,
            floor: FloorKind::Built.into(),
            bounds_tenths: [least(0), least(1), most(0), most(1)],
        });
        self.builder.finish()
    }
}
