//! A point of a cloud.

use frames::TENTHS_PER_M;

/// A point on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// In `map`, in tenths of a millimetre.
    pub(crate) at_tenths: [i32; 3],
    /// Unit vector.
    pub(crate) normal: [f32; 3],
    /// Class id.
    pub(crate) class: u8,
    /// Index of the element among those that have points.
    pub(crate) element: u32,
}

impl Point {
    /// In `map`, in metres.
    pub(crate) fn at_m(&self) -> [f32; 3] {
        self.at_tenths.map(|c| (f64::from(c) / f64::from(TENTHS_PER_M)) as f32)
    }
}
