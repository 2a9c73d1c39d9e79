//! Places in the air that are tried: on a lattice over the floor that maps show, at each height above it. Those that keep the clearance
//! are nodes.
//!
//! The lattice is the same on all storeys. Its step is about a quarter of the clearance, and larger where a site has too many places.

use super::air::Air;
use super::outdoor_ground::{CellGround, OutdoorGround};
use crate::flight_options::FlightOptions;
use crate::input::MissionPlanInput;
use crate::options::MissionPlanOptions;
use messages::{FloorKind, Grid, NONE, Site};
use rayon::prelude::*;

/// Places that are tried, at most; more make the step larger.
pub(crate) const MAX_PLACES: usize = 2_000_000;

/// Steps of the lattice between waypoints as far apart as may be, at least.
const MIN_STEPS: i32 = 4;

/// Ground within this of another is the same, in tenths of a millimetre: ground outdoors and the floor of a storey, a floor and what lies
/// on it.
const SAME_GROUND: i32 = 3_000;

/// Coordinates of places are below this: beyond it archives may say what they like. In tenths of a millimetre.
const MAX_COORDINATE: i64 = 1 << 30;

/// Row and column of the lattice.
pub(crate) type LatticePlace = [i32; 2];

/// Where the places of the lattice lie in `map`, in tenths of a millimetre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lattice {
    pub(crate) step: i32,
    offset: i32,
}

/// Why there is no lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoLattice {
    /// More places than are tried, however large the step may be.
    TooManyPlaces(usize),
    /// Cells of this side, of which there are too few between waypoints.
    CellsTooLarge(i32),
}

/// A place over the floor of a storey.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FloorPlace {
    at: LatticePlace,
    /// Index of the grid.
    grid: u32,
    /// The highest ground within the clearance in plan.
    ground: i32,
    /// Space plus 1; 0 outside of spaces.
    space: u32,
}

/// A place in the air that keeps the clearance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AirNode {
    /// Index of the grid, and of the height.
    pub(crate) layer: [u32; 2],
    pub(crate) at: LatticePlace,
    pub(crate) position: [i32; 3],
    pub(crate) ground: i32,
    /// Space plus 1; 0 outside of spaces.
    pub(crate) space: u32,
    /// To what stands and to closed rooms, as far as it was looked for; in tenths of a millimetre.
    pub(crate) distance: f64,
}

/// What was found of a space, or outside of spaces, at a height.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Tried {
    pub(crate) n_places: u32,
    /// Places that keep the clearance over their own floor.
    pub(crate) n_clear: u32,
    /// Places that keep the clearance, and have another floor below them.
    pub(crate) n_over_other_floor: u32,
    /// The largest distance that was found where none keeps the clearance; in tenths of a millimetre.
    pub(crate) largest: f64,
}

/// Nodes by layer, row and column; and what was found, by space plus 1 and height.
#[derive(Debug, Default)]
pub(crate) struct AirNodes {
    pub(crate) nodes: Vec<AirNode>,
    pub(crate) tried: Vec<Tried>,
}

impl Lattice {
    /// The lattice for options, with so many cells of floor, of a side in tenths of a millimetre.
    ///
    /// # Errors
    /// More places than are tried on the widest lattice that the spacing allows, or none that it allows.
    pub(crate) fn of(options: &FlightOptions, n_cells: usize, cell: i32) -> Result<Self, NoLattice> {
        let widest = options.spacing_tenths / MIN_STEPS / cell;
        if widest == 0 {
            return Err(NoLattice::CellsTooLarge(cell));
        }
        let n_heights = options.heights_tenths.len();
        let n_of = |k: i32| n_cells / (k as usize * k as usize) * n_heights;
        let usual = (options.clearance_tenths / 4 / cell).clamp(1, widest);
        let step = (usual..=widest).find(|&k| n_of(k) <= MAX_PLACES);
        step.map(|k| Self { step: k * cell, offset: cell / 2 }).ok_or(NoLattice::TooManyPlaces(n_of(widest)))
    }

    fn middle(&self, at: i32) -> i32 {
        at * self.step + self.offset
    }

    /// Rows or columns whose places lie in `n` cells from the first; none of cells too far from the origin.
    fn range(&self, first: i32, n: u32, cell: i32) -> std::ops::Range<i32> {
        let (first, n, cell, step) = (i64::from(first), i64::from(n), i64::from(cell), i64::from(self.step));
        let [low, end] = [first * cell, (first + n) * cell];
        if low < -MAX_COORDINATE || end > MAX_COORDINATE {
            return 0..0;
        }
        // The first place at or beyond a coordinate.
        let from = |z: i64| -(i64::from(self.offset) - z).div_euclid(step);
        from(low) as i32..from(end) as i32
    }
}

/// Which places of a storey are over floor of spaces that are asked for, and open.
pub(crate) struct Wanted<'a> {
    options: &'a MissionPlanOptions,
    /// By space plus 1.
    pub(crate) is_wanted: Vec<bool>,
}

impl<'a> Wanted<'a> {
    pub(crate) fn of(input: &MissionPlanInput<'a>) -> Self {
        let MissionPlanInput { site, schedule_state, options, .. } = *input;
        let is_open = |k: usize| !schedule_state.is_blocked(k) && is_asked_for(options, site, k);
        let spaces = (0..site.spaces.len()).map(is_open);
        Self { options, is_wanted: std::iter::once(options.spaces.is_empty()).chain(spaces).collect() }
    }

    /// Indices of the grids whose storeys are asked for.
    fn grids(&self, input: &MissionPlanInput<'_>) -> Vec<usize> {
        (0..input.grids.count()).filter(|&at| self.options.wants_storey(input.grids.head(at).map_storey)).collect()
    }

    /// True of the number of a space, plus 1, or of 0.
    fn has(&self, space: u32) -> bool {
        self.is_wanted.get(space as usize).is_some_and(|is_wanted| *is_wanted)
    }
}

/// True if flight waypoints over a space are asked for.
pub(crate) fn is_asked_for(options: &MissionPlanOptions, site: &Site<'_>, space: usize) -> bool {
    let map_storey = site.spaces[space].map_storey;
    options.wants_space(site, space) && (map_storey == NONE || options.wants_storey(map_storey))
}

/// The lattice of a site.
///
/// # Errors
/// Too many places, or cells that are too large.
pub(crate) fn lattice(
    input: &MissionPlanInput<'_>,
    flight: &FlightOptions,
    wanted: &Wanted<'_>,
    outdoors: &OutdoorGround,
) -> Result<Lattice, NoLattice> {
    let count = |at: &usize| {
        input.grids.with(*at, |grid| {
            let ground = outdoors.of_grid(*at, grid);
            (0..grid.floor.len())
                .filter(|&cell| ground.at(cell).is_some() && wanted.has(u32::from(grid.space[cell])))
                .count()
        })
    };
    let grids = wanted.grids(input);
    let n_cells = grids.iter().map(count).sum();
    let cell = grids.iter().map(|&at| input.grids.head(at).cell_tenths).max().unwrap_or(1);
    Lattice::of(flight, n_cells, cell)
}

/// The places over floor that keep the clearance, and have no other floor below them.
pub(crate) fn air_nodes(
    by_grid: &[Vec<FloorPlace>],
    flight: &FlightOptions,
    wanted: &Wanted<'_>,
    lattice: Lattice,
    air: &Air,
) -> AirNodes {
    let (n_heights, clearance) = (flight.heights_tenths.len(), f64::from(flight.clearance_tenths));
    let mut found = AirNodes { nodes: Vec::new(), tried: vec![Tried::default(); wanted.is_wanted.len() * n_heights] };
    // Links between places that are farther from everything are clear without a look at triangles.
    let reach = clearance + 3.0 * f64::from(lattice.step);
    for places in by_grid {
        for (height, &above) in (0..).zip(&flight.heights_tenths) {
            let look = |place: &FloorPlace| {
                let [x, y] = [place.at[1], place.at[0]].map(|c| lattice.middle(c));
                let position = [x, y, place.ground.saturating_add(above)];
                let distance = air.distance(position, reach);
                let over_floor = [x, y, place.ground.saturating_add(SAME_GROUND)];
                let is_over_other =
                    distance >= clearance && air.has_ground_above(over_floor, f64::from(above - SAME_GROUND));
                (position, distance, is_over_other)
            };
            let looks: Vec<([i32; 3], f64, bool)> = places.par_iter().map(look).collect();
            for (place, (position, distance, is_over_other)) in places.iter().zip(looks) {
                let FloorPlace { at, grid, ground, space } = *place;
                let tried = &mut found.tried[space as usize * n_heights + height as usize];
                tried.n_places += 1;
                if distance < clearance {
                    tried.largest = tried.largest.max(distance);
                } else if is_over_other {
                    tried.n_over_other_floor += 1;
                } else {
                    tried.n_clear += 1;
                    found.nodes.push(AirNode { layer: [grid, height], at, position, ground, space, distance });
                }
            }
        }
    }
    found
}

/// Places over floor that is asked for, by grid, row and column: ground outdoors is left out where a storey shows it as its floor.
pub(crate) fn floor_places(
    input: &MissionPlanInput<'_>,
    clearance: i32,
    wanted: &Wanted<'_>,
    outdoors: &OutdoorGround,
    lattice: Lattice,
) -> Vec<Vec<FloorPlace>> {
    let is_outdoors = |at: u32| input.grids.head(at as usize).floor == FloorKind::Ground;
    let places = |at: usize| {
        input.grids.with(at, |grid| places_of(grid, at as u32, &outdoors.of_grid(at, grid), clearance, lattice))
    };
    let mut by_grid: Vec<Vec<FloorPlace>> = wanted.grids(input).into_iter().map(places).collect();
    let levels = by_grid.iter().flatten().filter(|place| !is_outdoors(place.grid));
    let mut on_levels: Vec<(LatticePlace, i32)> = levels.map(|place| (place.at, place.ground)).collect();
    on_levels.sort_unstable();
    let is_on_level = |place: &FloorPlace| {
        let first = on_levels.partition_point(|(at, _)| *at < place.at);
        let mut here = on_levels[first..].iter().take_while(|(at, _)| *at == place.at);
        here.any(|(_, ground)| ground.abs_diff(place.ground) <= SAME_GROUND.unsigned_abs())
    };
    let is_kept = |place: &FloorPlace| wanted.has(place.space) && !(is_outdoors(place.grid) && is_on_level(place));
    by_grid.iter_mut().for_each(|places| places.retain(is_kept));
    by_grid
}

fn places_of(grid: &Grid<'_>, at: u32, ground: &CellGround<'_>, clearance: i32, lattice: Lattice) -> Vec<FloorPlace> {
    let spec = grid.spec();
    let reach = &Reach::of(clearance, spec.cell_tenths);
    let rows: Vec<i32> = lattice.range(spec.first_cell[1], spec.height, spec.cell_tenths).collect();
    let columns = lattice.range(spec.first_cell[0], spec.width, spec.cell_tenths);
    let of_row = |&row: &i32| {
        let cell_row = lattice.middle(row).div_euclid(spec.cell_tenths) - spec.first_cell[1];
        let place = move |column: i32| {
            let cell_column = lattice.middle(column).div_euclid(spec.cell_tenths) - spec.first_cell[0];
            let cell = cell_row as usize * spec.width as usize + cell_column as usize;
            ground.at(cell)?;
            let space = u32::from(grid.space[cell]);
            Some(FloorPlace {
                at: [row, column],
                grid: at,
                ground: reach.highest(ground, [cell_column, cell_row]),
                space,
            })
        };
        columns.clone().filter_map(place).collect::<Vec<_>>()
    };
    rows.par_iter().flat_map_iter(of_row).collect()
}

/// Cells around one whose middle lies within a distance, half a cell more: their rows, and half the cells in each.
struct Reach(Vec<(i32, i32)>);

impl Reach {
    fn of(distance: i32, cell: i32) -> Self {
        let most = i64::from(distance) + i64::from(cell) / 2;
        let is_within =
            |row: i64, column: i64| (row * row + column * column) * i64::from(cell) * i64::from(cell) <= most * most;
        let n = most / i64::from(cell);
        let half = |row: i64| (0..=n).take_while(|&column| is_within(row, column)).last();
        Self((-n..=n).filter_map(|row| Some((row as i32, half(row)? as i32))).collect())
    }

    /// The highest ground of a storey around a cell that has some.
    fn highest(&self, ground: &CellGround<'_>, [column, row]: [i32; 2]) -> i32 {
        let CellGround { heights, grid } = *ground;
        if heights.is_empty() {
            return grid.head.floor_z_tenths;
        }
        let (width, height) = (grid.head.width as i32, grid.head.height as i32);
        let highest_in = |(off, half): &(i32, i32)| {
            let row = row + off;
            let (from, to) = ((column - half).max(0), (column + half).min(width - 1));
            let is_row = (0..height).contains(&row);
            let cells = is_row.then(|| (row * width + from) as usize..=(row * width + to) as usize);
            // Cells without ground have the least of all numbers.
            cells.and_then(|cells| heights[cells].iter().max().copied())
        };
        self.0.iter().filter_map(highest_in).max().unwrap_or(grid.head.floor_z_tenths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(clearance_tenths: i32, spacing_tenths: i32) -> FlightOptions {
        FlightOptions { heights_tenths: vec![15_000, 30_000], clearance_tenths, spacing_tenths }
    }

    #[test]
    fn a_step_is_a_quarter_of_the_clearance_and_larger_over_much_floor() {
        let step = |n_cells| Lattice::of(&options(8_000, 40_000), n_cells, 500).map(|lattice| lattice.step);
        assert_eq!(step(10_000), Ok(2_000));
        // 64 million cells are 1 million places of 0.4 m, at two heights.
        assert_eq!(step(64_000_000), Ok(4_000));
        assert_eq!(step(1 << 30), Err(NoLattice::TooManyPlaces((1 << 30) / 400 * 2)));
        assert_eq!(Lattice::of(&options(8_000, 9_000), 10, 2_500), Err(NoLattice::CellsTooLarge(2_500)));
    }

    #[test]
    fn places_of_the_lattice_are_middles_of_cells_of_the_grid() {
        let lattice = Lattice { step: 1_500, offset: 250 };
        for (first, n) in [(-7, 5), (0, 1), (3, 10), (-30, 61)] {
            let is_in = |at: i32| (first..first + n as i32).contains(&lattice.middle(at).div_euclid(500));
            let expected: Vec<i32> = (-100..100).filter(|at| is_in(*at)).collect();
            assert_eq!(lattice.range(first, n, 500).collect::<Vec<_>>(), expected);
        }
        assert_eq!(lattice.range(i32::MIN, 1 << 20, 500).count() + lattice.range(0, u32::MAX, 500).count(), 0);
    }

    #[test]
    fn a_reach_is_the_cells_whose_middle_lies_in_a_circle() {
        let Reach(rows) = Reach::of(8_000, 500);
        let n: i32 = rows.iter().map(|(_, half)| 2 * half + 1).sum();
        let within = |x: i32, y: i32| x * x + y * y <= 16 * 16 + 16;
        let expected = (-20..=20).flat_map(|x| (-20..=20).map(move |y| (x, y))).filter(|(x, y)| within(*x, *y)).count();
        assert_eq!(n as usize, expected);
    }
}
