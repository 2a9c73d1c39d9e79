//! Lattice of places: maps places of one frame into another, bilinear between the corners of squares.

/// Where the places of a rectangle lie in another frame: known at the corners of squares, and bilinear between them.
#[derive(Debug)]
pub struct PlaceLattice {
    origin_m: [f64; 2],
    side_m: f64,
    /// Squares in a row and in a column.
    n_squares: [usize; 2],
    /// Places of the corners, row by row from the lower left; not a number where there is none.
    corners: Vec<[f64; 2]>,
}

impl PlaceLattice {
    /// Over a rectangle whose lower left corner and size are given, in squares of `side_m`; metres. `place` tells where a corner lies.
    pub fn over(
        origin_m: [f64; 2],
        size_m: [f64; 2],
        side_m: f64,
        place: impl Fn([f64; 2]) -> Option<[f64; 2]>,
    ) -> Self {
        let n_squares = size_m.map(|length_m| (length_m / side_m).ceil().max(1.0) as usize);
        let row = n_squares[0] + 1;
        let corner = |k: usize| [(0, k % row), (1, k / row)].map(|(axis, n)| origin_m[axis] + n as f64 * side_m);
        let corners = (0..row * (n_squares[1] + 1)).map(|k| place(corner(k)).unwrap_or([f64::NAN; 2])).collect();
        Self { origin_m, side_m, n_squares, corners }
    }

    /// Where a place lies; `None` outside of the rectangle, and where a corner around it lies nowhere.
    pub fn at(&self, place_m: [f64; 2]) -> Option<[f64; 2]> {
        let [x, y] = [0, 1].map(|axis| (place_m[axis] - self.origin_m[axis]) / self.side_m);
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.n_squares[0] as f64 && y < self.n_squares[1] as f64;
        if !is_inside {
            return None;
        }
        let (column, row, stride) = (x as usize, y as usize, self.n_squares[0] + 1);
        let [u, v] = [x - column as f64, y - row as f64];
        let lower = row * stride + column;
        let [a, b, c, d] = [lower, lower + 1, lower + stride, lower + stride + 1].map(|k| self.corners[k]);
        let along = |k: usize| (1.0 - v) * ((1.0 - u) * a[k] + u * b[k]) + v * ((1.0 - u) * c[k] + u * d[k]);
        let found = [along(0), along(1)];
        found[0].is_finite().then_some(found)
    }

    /// Index of the square of a place, row by row from the lower left; `None` outside of the rectangle.
    pub(crate) fn square(&self, place_m: [f64; 2]) -> Option<usize> {
        let [x, y] = [0, 1].map(|axis| ((place_m[axis] - self.origin_m[axis]) / self.side_m).floor());
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.n_squares[0] as f64 && y < self.n_squares[1] as f64;
        is_inside.then(|| y as usize * self.n_squares[0] + x as usize)
    }

    /// Middles of all squares, by index.
    pub(crate) fn middles_m(&self) -> impl Iterator<Item = [f64; 2]> + use<'_> {
        let place = |axis: usize, n: usize| self.origin_m[axis] + (n as f64 + 0.5) * self.side_m;
        let [n_columns, n_rows] = self.n_squares;
        (0..n_rows).flat_map(move |row| (0..n_columns).map(move |column| [place(0, column), place(1, row)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_between_the_corners_of_their_square_and_nowhere_outside() {
        let lattice = PlaceLattice::over([10.0, 20.0], [1.2, 0.5], 0.5, |[x, y]| Some([-2.0 * y, x]));
        let [x, y] = lattice.at([10.7, 20.1]).unwrap();
        assert!((x + 40.2).abs() < 1e-9 && (y - 10.7).abs() < 1e-9);
        assert!(lattice.at([9.99, 20.1]).is_none() && lattice.at([10.7, 20.51]).is_none());
        assert!(lattice.at([11.4, 20.1]).is_some(), "the last square is whole");
        assert_eq!((lattice.square([11.1, 20.4]), lattice.middles_m().nth(2)), (Some(2), Some([11.25, 20.25])));
    }

    #[test]
    fn a_square_with_a_corner_that_lies_nowhere_has_no_places() {
        let lattice = PlaceLattice::over([0.0; 2], [2.0, 1.0], 1.0, |p| (p[0] < 1.5).then_some(p));
        assert!(lattice.at([0.5, 0.5]).is_some() && lattice.at([1.5, 0.5]).is_none());
    }
}
