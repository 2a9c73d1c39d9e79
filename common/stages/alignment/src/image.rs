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
    pub(crate) fn blurred(&self, sigma: f64) -> Self {
        let reach = (3.0 * sigma).ceil() as i64;
        let weights: Vec<f64> =
            (-reach..=reach).map(|k| libm::exp(-((k * k) as f64) / (2.0 * sigma * sigma))).collect();
        let whole: f64 = weights.iter().sum();
        let kernel: Vec<f32> = weights.iter().map(|w| (w / whole) as f32).collect();
        self.convolved(&kernel)
    }

    /// Sums over squares of `side` cells, an odd number.
    pub(crate) fn summed(&self, side: usize) -> Self {
        self.convolved(&vec![1.0; side])
    }

    /// The same kernel along rows and along columns; its length is odd.
    fn convolved(&self, kernel: &[f32]) -> Self {
        let (w, h, reach) = (self.width, self.height, kernel.len() / 2);
        let mut across = vec![0.0f32; w * h];
        let mut line = vec![0.0f32; w + 2 * reach];
        for (row, out) in self.values.chunks_exact(w.max(1)).zip(across.chunks_exact_mut(w.max(1))) {
            line[..reach].fill(row[0]);
            line[reach..reach + w].copy_from_slice(row);
            line[reach + w..].fill(row[w - 1]);
            for (k, weight) in kernel.iter().enumerate() {
                out.iter_mut().zip(&line[k..]).for_each(|(o, v)| *o += weight * v);
            }
        }
        let mut values = vec![0.0f32; w * h];
        for (y, out) in values.chunks_exact_mut(w.max(1)).enumerate() {
            for (k, weight) in kernel.iter().enumerate() {
                let from = (y + k).saturating_sub(reach).min(h - 1) * w;
                out.iter_mut().zip(&across[from..from + w]).for_each(|(o, v)| *o += weight * v);
            }
        }
        Self { width: w, height: h, values }
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
        let blurred = image.blurred(1.6);
        assert!((blurred.values.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let plane = Image::new(31, (0..31 * 31).map(|k| 2.0 * (k % 31) as f32 - (k / 31) as f32).collect());
        let slope = plane.blurred(4.0).slope(15 * 31 + 15);
        assert!((slope[0] - 2.0).abs() < 1e-3 && (slope[1] + 1.0).abs() < 1e-3, "{slope:?}");
        assert_eq!(image.summed(3).values.iter().filter(|v| **v == 1.0).count(), 9);
    }
}
