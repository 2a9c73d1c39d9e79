//! Time and energy of driving: over a stretch of ground with a slope, along a line, through a portal.

use crate::free_space::FreeSpace;
use crate::path_search::{PathGrid, SIDE, pulled};
use crate::portal::{Portal, PortalKind};
use crate::walked_line::{Stretch, stretches};
use frames::{Map, Point2, metres};
use messages::{DriveModel, WayCost};
use std::iter::Sum;

/// Standard gravity.
const GRAVITY_M_S2: f64 = 9.806_65;

/// What a way takes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Driven {
    /// Time.
    pub duration_s: f64,
    /// Energy from the battery; 0 if the mass of the robot is unknown.
    pub energy_j: f64,
}

impl Sum for Driven {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |sum, part| Self {
            duration_s: sum.duration_s + part.duration_s,
            energy_j: sum.energy_j + part.energy_j,
        })
    }
}

/// A stretch of even slope. Its energy is m g (sin s + c cos s) / efficiency for each metre along the slope, with the coefficient of
/// rolling resistance c, and what runs all the time; where the slope alone drives the robot the battery gets nothing back.
///
/// # Source
/// Siciliano and Khatib (eds.), Springer Handbook of Robotics, 2nd edition, 2016: rolling resistance and grade of wheeled robots.
pub(crate) fn driven(model: &DriveModel, Stretch { plan_m, rise_m }: Stretch) -> Driven {
    let duration_s = libm::hypot(plan_m, rise_m) / model.speed_m_s + model.climb_s_per_m * rise_m.max(0.0);
    let work_j = model.mass_kg * GRAVITY_M_S2 * (rise_m + model.rolling_resistance * plan_m);
    with_energy(model, duration_s, work_j.max(0.0) / model.drive_efficiency)
}

/// The work of the drive, and of what runs all the time.
fn with_energy(model: &DriveModel, duration_s: f64, drive_j: f64) -> Driven {
    Driven { duration_s, energy_j: if model.has_energy() { drive_j + model.idle_w * duration_s } else { 0.0 } }
}

/// A line over the ground of a storey.
pub(crate) fn driven_line(model: &DriveModel, free_space: &FreeSpace, line: &[Point2<Map>]) -> Driven {
    stretches(free_space, line).map(|stretch| driven(model, stretch)).sum()
}

/// A portal of a length, taken up by its rise or down. On stairs the robot lifts itself in the time of their length; a lift or escalator
/// does it for the robot.
pub(crate) fn driven_portal(model: &DriveModel, kind: PortalKind, length_m: f64, rise_m: f64) -> Driven {
    let stretch =
        |rise_m: f64| Stretch { plan_m: libm::sqrt((length_m * length_m - rise_m * rise_m).max(0.0)), rise_m };
    match kind {
        PortalKind::Ramp { .. } | PortalKind::Step | PortalKind::Ground => driven(model, stretch(rise_m)),
        PortalKind::Stair => driven(&DriveModel { climb_s_per_m: 0.0, ..*model }, stretch(rise_m)),
        PortalKind::Lift | PortalKind::Escalator => with_energy(model, length_m / model.speed_m_s, 0.0),
    }
}

/// How much higher the second end of a portal is than the first.
pub(crate) fn rise_m(free_spaces: &[&FreeSpace], portal: &Portal) -> f64 {
    let [low, high] = portal.ends.map(|end| metres(free_spaces[end.storey].z_tenths(end.cell)));
    high - low
}

/// By what ways are compared: time in seconds, energy in joules.
pub(crate) fn measured(cost: WayCost, length_m: f64, driven: Driven) -> f64 {
    match cost {
        WayCost::Length => length_m,
        WayCost::Time => driven.duration_s,
        WayCost::Energy => driven.energy_j,
    }
}

/// Costs of steps by time or energy are in so many parts of those by length.
const PARTS: f64 = 64.0;

/// The cost of a step by length, of a stretch that is as dear as so many metres of level ground.
fn in_parts(by_length: f64) -> u32 {
    (by_length * PARTS).round() as u32
}

/// How many metres of level ground cost as much as this.
fn as_level_m(model: &DriveModel, length_m: f64, driven_there: Driven) -> f64 {
    let cost = model.cost.get();
    let level = driven(model, Stretch { plan_m: 1.0, rise_m: 0.0 });
    measured(cost, length_m, driven_there) / measured(cost, 1.0, level)
}

/// The cost of a step over cells of a path grid that costs `step` by length: as of level ground, or as its rise makes it.
pub(crate) fn step_cost(
    model: &DriveModel,
    free_space: &FreeSpace,
    path_grid: &PathGrid,
    [cell, next]: [usize; 2],
    step: u32,
) -> u32 {
    if model.cost == WayCost::Length {
        return step;
    }
    if free_space.is_level() {
        return in_parts(f64::from(step));
    }
    let [low, high] = [cell, next].map(|cell| metres(free_space.z_tenths(path_grid.cell_in(&free_space.spec, cell))));
    let is_corner = cell.abs_diff(next) != 1 && cell.abs_diff(next) != path_grid.width;
    let plan_m = free_space.spec.resolution_m() * if is_corner { std::f64::consts::SQRT_2 } else { 1.0 };
    let stretch = Stretch { plan_m, rise_m: high - low };
    let length_m = libm::hypot(plan_m, stretch.rise_m);
    in_parts(f64::from(step) * as_level_m(model, length_m, driven(model, stretch)) / plan_m)
}

/// The cost of a portal beside such steps.
pub(crate) fn portal_cost(model: &DriveModel, kind: PortalKind, length_m: f64, rise_m: f64, resolution_m: f64) -> u32 {
    if model.cost == WayCost::Length {
        return (length_m / resolution_m * f64::from(SIDE)).ceil() as u32;
    }
    let level_m = as_level_m(model, length_m, driven_portal(model, kind, length_m, rise_m));
    in_parts((level_m / resolution_m * f64::from(SIDE)).ceil())
}

/// The line along cells that costs least of those that are pulled tight where that costs no more than the cells do, and that which is
/// pulled tight altogether.
pub(crate) fn cheapest_line(
    model: &DriveModel,
    free_space: &FreeSpace,
    path_grid: &PathGrid,
    cells: &[usize],
    [from, to]: [Point2<Map>; 2],
) -> Vec<Point2<Map>> {
    let tight = path_grid.pull_string(cells, from, to);
    if model.cost == WayCost::Length || free_space.is_level() {
        return tight;
    }
    let cheap = pulled_where_cheaper(model, free_space, path_grid, cells, [from, to]);
    let cost = |line: &[Point2<Map>]| line_cost(model, free_space, line);
    if cost(&cheap) < cost(&tight) { cheap } else { tight }
}

/// What a line costs by time or energy.
pub(crate) fn line_cost(model: &DriveModel, free_space: &FreeSpace, line: &[Point2<Map>]) -> f64 {
    measured(model.cost.get(), 0.0, driven_line(model, free_space, line))
}

/// Cells are left out while the straight line is clear and costs no more than they do.
fn pulled_where_cheaper(
    model: &DriveModel,
    free_space: &FreeSpace,
    path_grid: &PathGrid,
    cells: &[usize],
    [from, to]: [Point2<Map>; 2],
) -> Vec<Point2<Map>> {
    let mut points = vec![from];
    points.extend(cells.iter().map(|&cell| path_grid.middle(cell)).chain([to]));
    points.dedup();
    // Cost of the way over the cells up to each point.
    let mut so_far = vec![0.0];
    for pair in points.windows(2) {
        so_far.push(so_far[so_far.len() - 1] + line_cost(model, free_space, pair));
    }
    pulled(&points, |at, to| {
        path_grid.is_clear(points[at], points[to])
            && line_cost(model, free_space, &[points[at], points[to]]) <= so_far[to] - so_far[at]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: DriveModel = DriveModel { climb_s_per_m: 10.0, mass_kg: 100.0, idle_w: 20.0, ..DriveModel::DEFAULT };

    #[test]
    fn a_ramp_of_8_percent_takes_the_time_of_its_length_and_climb_and_the_work_of_lifting_and_rolling() {
        let up = driven(&MODEL, Stretch { plan_m: 10.0, rise_m: 0.8 });
        let length_m = libm::sqrt(100.64);
        assert!((up.duration_s - (length_m / 0.5 + 8.0)).abs() < 1e-12, "{up:?}");
        // 100 kg are lifted by 0.8 m, and roll 10 m at 2 %.
        let work_j = 100.0 * 9.806_65 * (0.8 + 0.2);
        assert!((up.energy_j - (work_j / 0.7 + 20.0 * up.duration_s)).abs() < 1e-9, "{up:?}");
        let down = driven(&MODEL, Stretch { plan_m: 10.0, rise_m: -0.8 });
        assert!((down.duration_s - length_m / 0.5).abs() < 1e-12, "{down:?}");
        assert!((down.energy_j - 20.0 * down.duration_s).abs() < 1e-9, "nothing comes back: {down:?}");
        let gentle = driven(&MODEL, Stretch { plan_m: 10.0, rise_m: -0.1 });
        let left_j = 100.0 * 9.806_65 * (0.2 - 0.1) / 0.7;
        assert!((gentle.energy_j - (left_j + 20.0 * gentle.duration_s)).abs() < 1e-9, "{gentle:?}");
    }

    #[test]
    fn without_a_mass_there_is_no_energy_and_without_options_time_goes_by_length() {
        let up = driven(&DriveModel::DEFAULT, Stretch { plan_m: 3.0, rise_m: 4.0 });
        assert_eq!(up, Driven { duration_s: 10.0, energy_j: 0.0 });
    }

    #[test]
    fn stairs_and_lifts_take_the_time_of_their_length() {
        let [stair, lift, ramp] = [PortalKind::Stair, PortalKind::Lift, PortalKind::Ramp { slope_rad: 0.1 }]
            .map(|kind| driven_portal(&MODEL, kind, 5.0, 3.0));
        assert_eq!([stair.duration_s, lift.duration_s, ramp.duration_s], [10.0, 10.0, 40.0]);
        assert_eq!(lift.energy_j, 200.0, "it stands in the lift");
        assert!((stair.energy_j - (100.0 * 9.806_65 * 3.08 / 0.7 + 200.0)).abs() < 1e-9, "{stair:?}");
    }

    #[test]
    fn costs_by_length_are_those_of_steps_and_others_finer() {
        let by = |cost: WayCost| DriveModel { cost: cost.into(), ..MODEL };
        let portal = |cost: WayCost, rise_m: f64| portal_cost(&by(cost), PortalKind::Step, 1.0, rise_m, 0.05);
        assert_eq!([portal(WayCost::Length, 0.0), portal(WayCost::Length, 0.6)], [100, 100]);
        assert_eq!([portal(WayCost::Time, 0.0), portal(WayCost::Energy, 0.0)], [6_400; 2]);
        // A metre of level ground takes 2 s, this 2 s and 6 s for its climb.
        assert_eq!([portal(WayCost::Time, 0.6), portal(WayCost::Time, -0.6)], [4 * 6_400, 6_400]);
    }
}
