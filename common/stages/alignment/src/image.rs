//! Scalar images: Gaussian blur and gradient.

use occupancy::{Cell, Raster};

/// One number for each cell.
#[derive(Debug, Clone)]
pub(crate) struct Image {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<f32>,
}

impl Image {
    pub(crate) fn new(width: usize, values: Vec<f32>) -> Self {
        Self { width, height: values.len().checked_div(width).unwrap_or(0), values }
    }

    /// Convolved with a Gaussian of this size in cells, cut at three times that; borders are continued.
    pub(crate) fn blurred(self, sigma: f64) -> Self {
        let reach = (3.0 * sigma).ceil() as i64;
        let weights: Vec<f64> =
            (-reach..=reach).map(|k| libm::exp(-((k * k) as f64) / (2.0 * sigma * sigma))).collect();
        let whole: f64 = weights.iter().sum();
        let kernel: Vec<f32> = weights.iter().map(|w| (w / whole) as f32).collect();
        self.convolved(&kernel)
    }

    /// Sums over squares of `side` cells, an odd number.
    pub(crate) fn summed(self, side: usize) -> Self {
        self.convolved(&vec![1.0; side])
    }

    /// The same kernel along rows and along columns, in place; its length is odd.
    fn convolved(mut self, kernel: &[f32]) -> Self {
        let (w, h, n) = (self.width, self.height, kernel.len());
        let reach = n / 2;
        let mut line = vec![0.0f32; w + 2 * reach];
        // Of the rows that a row needs, the sums along them: those of row y at y modulo their number.
        let mut across = vec![0.0f32; w * n];
        let mut next = 0;
        for y in 0..h {
            while next < (y + reach + 1).min(h) {
                let row = &self.values[next * w..][..w];
                line[..reach].fill(row[0]);
                line[reach..reach + w].copy_from_slice(row);
                line[reach + w..].fill(row[w - 1]);
                let shifted: Vec<&[f32]> = (0..n).map(|k| &line[k..k + w]).collect();
                weighted_sums(kernel, &shifted, &mut across[next % n * w..][..w]);
                next += 1;
            }
            let row = |k: usize| (y + k).saturating_sub(reach).min(h - 1) % n * w;
            let rows: Vec<&[f32]> = (0..n).map(|k| &across[row(k)..][..w]).collect();
            weighted_sums(kernel, &rows, &mut self.values[y * w..][..w]);
        }
        self
    }

    /// The slope at a cell that is not on the border, per cell.
    pub(crate) fn slope(&self, index: usize) -> [f32; 2] {
        let v = &self.values;
        [(v[index + 1] - v[index - 1]) / 2.0, (v[index + self.width] - v[index - self.width]) / 2.0]
    }

    /// True for cells with eight neighbours.
    pub(crate) fn is_inside(&self, index: usize) -> bool {
        let (x, y) = (index % self.width, index / self.width);
        x > 0 && y > 0 && x + 1 < self.width && y + 1 < self.height
    }
}

/// Sums of the lines of a kernel, each with its weight; a block of columns at a time stays in registers.
fn weighted_sums(kernel: &[f32], lines: &[&[f32]], out: &mut [f32]) {
    const BLOCK: usize = 16;
    let (blocks, rest) = out.as_chunks_mut::<BLOCK>();
    let n_in_blocks = blocks.len() * BLOCK;
    for (block, out) in blocks.iter_mut().enumerate() {
        let mut sums = [0.0; BLOCK];
        for (weight, line) in kernel.iter().zip(lines) {
            let values = &line[block * BLOCK..][..BLOCK];
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
        }
        *out = sums;
    }
    rest.fill(0.0);
    for (weight, line) in kernel.iter().zip(lines) {
        rest.iter_mut().zip(&line[n_in_blocks..]).for_each(|(sum, value)| *sum += weight * value);
    }
}

/// 1 where a map is free, 0 where it is occupied, between them where it is unknown.
pub(crate) fn openness(raster: &Raster) -> Image {
    let value = |cell: &Cell| match cell {
        Cell::Free => 1.0,
        Cell::Occupied => 0.0,
        Cell::Unknown => 0.5,
    };
    Image::new(raster.width, raster.cells.iter().map(value).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blur_keeps_the_sum_and_a_plane_its_slope() {
        let mut image = Image::new(31, vec![0.0; 31 * 31]);
        image.values[15 * 31 + 15] = 1.0;
        let blurred = image.clone().blurred(1.6);
        assert!((blurred.values.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let plane = Image::new(31, (0..31 * 31).map(|k| 2.0 * (k % 31) as f32 - (k / 31) as f32).collect());
        let slope = plane.blurred(4.0).slope(15 * 31 + 15);
        assert!((slope[0] - 2.0).abs() < 1e-3 && (slope[1] + 1.0).abs() < 1e-3, "{slope:?}");
        assert_eq!(image.summed(3).values.iter().filter(|v| **v == 1.0).count(), 9);
    }
}
