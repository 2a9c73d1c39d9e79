//! Places the sensor of a robot that stands at a place: above the ground along the normal of the ground.

use crate::free_space::FreeSpace;
use crate::options::MissionPlanOptions;
use frames::{Map, Point2, UPRIGHT, metres};
use grid::Cell;
use messages::{RobotProfile, Site};

/// The place of a sensor, and the direction that is up for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SensorPlace {
    /// In `map`.
    pub(crate) at_m: [f64; 3],
    /// Unit vector in `map`.
    pub(crate) up: [f64; 3],
}

/// The sensor of a robot at a place of a storey; what flies is upright.
pub(crate) fn sensor_place(
    site: &Site<'_>,
    robot: &RobotProfile,
    options: &MissionPlanOptions,
    free_space: &FreeSpace,
    at: Point2<Map>,
    space: Option<usize>,
) -> SensorPlace {
    let height_m = sensor_height_m(site, robot, options, space);
    let up = if options.flies { UPRIGHT } else { ground_normal(free_space, at, robot.radius_m) };
    let ground_m = [at.x_m(), at.y_m(), free_space.z_m(at)];
    SensorPlace { at_m: [0, 1, 2].map(|k| ground_m[k] + height_m * up[k]), up }
}

/// Height of the sensor over the floor; half the height of the space for flying robots.
fn sensor_height_m(site: &Site<'_>, robot: &RobotProfile, options: &MissionPlanOptions, space: Option<usize>) -> f64 {
    let half = space.map(|s| metres(site.spaces[s].height_tenths) / 2.0);
    half.filter(|_| options.flies).unwrap_or(robot.sensor_height_m)
}

/// Cells around the place that decide at least, whatever the radius.
const LEAST_CELLS: f64 = 1.5;

/// Cells at the distance of the radius count, whatever its last digits are; in cells.
const ROUNDING: f64 = 1e-6;

/// Normal of the ground under a robot: that of the plane through the heights of the free cells whose middles lie within its radius,
/// by least squares. Across a break of the ground the robot stands as between its sides.
fn ground_normal(free_space: &FreeSpace, at: Point2<Map>, radius_m: f64) -> [f64; 3] {
    let spec = &free_space.spec;
    let Some(own) = spec.cell_at(at).filter(|_| !free_space.is_level()) else { return UPRIGHT };
    let reach = (radius_m / spec.resolution_m()).max(LEAST_CELLS);
    let [x, y] = free_space.in_cells(at);
    let around = |at: f64, n: u32| {
        let [low, high] = [at - reach - 1.0, at + reach + 1.0].map(|end| end.clamp(0.0, f64::from(n)) as u32);
        low..high
    };
    let z = i64::from(free_space.z_tenths(spec.index(own)));
    let mut moments = Moments::default();
    for row in around(y, spec.height) {
        for column in around(x, spec.width) {
            let cell = spec.index(Cell { column, row });
            let far = libm::hypot(f64::from(column) + 0.5 - x, f64::from(row) + 0.5 - y);
            if far <= reach + ROUNDING && free_space.is_free(cell) {
                let [along, across] =
                    [(column, own.column), (row, own.row)].map(|(to, from)| i64::from(to) - i64::from(from));
                moments.add(along, across, i64::from(free_space.z_tenths(cell)) - z);
            }
        }
    }
    let gradient = moments.gradient().map(|rise| rise / f64::from(spec.cell_tenths));
    if gradient == [0.0; 2] {
        return UPRIGHT;
    }
    let [dx, dy] = gradient;
    let length = libm::sqrt(1.0 + dx * dx + dy * dy);
    // No negative zero.
    [-dx / length + 0.0, -dy / length + 0.0, 1.0 / length]
}

/// Sums over points from which a plane is fitted; exact, so that level ground is level.
#[derive(Default)]
struct Moments {
    n: i64,
    first: [i64; 3],
    /// Of x x, x y, y y, x z, y z.
    second: [i64; 5],
}

impl Moments {
    fn add(&mut self, x: i64, y: i64, z: i64) {
        self.n += 1;
        self.first.iter_mut().zip([x, y, z]).for_each(|(sum, value)| *sum += value);
        self.second.iter_mut().zip([x * x, x * y, y * y, x * z, y * z]).for_each(|(sum, value)| *sum += value);
    }

    /// Rise of the plane along x and y; 0 where the points lie on one line.
    fn gradient(&self) -> [f64; 2] {
        let centred = |sum: i64, a: i64, b: i64| i128::from(self.n * sum - a * b);
        let [x, y, z] = self.first;
        let [xx, xy, yy, xz, yz] = self.second;
        let [xx, xy, yy] = [centred(xx, x, x), centred(xy, x, y), centred(yy, y, y)];
        let [xz, yz] = [centred(xz, x, z), centred(yz, y, z)];
        let determinant = xx * yy - xy * xy;
        if determinant == 0 {
            return [0.0; 2];
        }
        [xz * yy - yz * xy, yz * xx - xz * xy].map(|rise| rise as f64 / determinant as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::tests::drawn;
    use messages::{ArchiveBuffer, Grid, GridHead, GridWriter};

    /// Ground of 80 x 80 cells of 0.05 m with heights in tenths of a millimetre from x and y in metres.
    fn ground(z_tenths: impl Fn(f64, f64) -> f64) -> ArchiveBuffer {
        let head = GridHead { cell_tenths: 500, width: 80, height: 80, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_with_heights(head.spec().n_cells()));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        layers.planning.fill(0);
        layers.keepout.fill(-1);
        layers.slope.fill(0);
        for cell in 0..layers.elevation.len() {
            let [x, y] = [cell % 80, cell / 80].map(|at| (at as f64 + 0.5) * 0.05);
            layers.elevation[cell] = z_tenths(x, y).round() as i32;
        }
        writer.seal();
        buffer
    }

    fn normal(ground: &ArchiveBuffer, x: f64, y: f64) -> [f64; 3] {
        let free_space = FreeSpace::of(&Grid::open(ground.bytes()).unwrap(), 0.3);
        ground_normal(&free_space, Point2::new(x, y), 0.3)
    }

    #[test]
    fn the_normal_on_a_plane_is_that_of_the_plane() {
        let plane = ground(|x, y| 800.0 * x - 300.0 * y);
        let length = libm::sqrt(1.0f64 + 0.08 * 0.08 + 0.03 * 0.03);
        let expected = [-0.08 / length, 0.03 / length, 1.0 / length];
        for (x, y) in [(1.0, 1.0), (2.013, 1.987), (3.25, 0.775)] {
            let found = normal(&plane, x, y);
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 2e-4), "{found:?}, {expected:?}");
        }
    }

    #[test]
    fn level_ground_and_level_storeys_are_upright_to_the_bit() {
        let terrace = ground(|x, _| if x < 2.0 { 1_000.0 } else { 1_000.0 + 800.0 * (x - 2.0) });
        assert_eq!(normal(&terrace, 1.0, 2.0), UPRIGHT);
        let between = normal(&terrace, 2.0, 2.0);
        assert!(-0.06 < between[0] && between[0] < -0.02, "at the foot it stands as between both: {between:?}");
        assert_eq!(normal(&drawn("......\n......\n......"), 0.25, 0.15), UPRIGHT);
    }
}
