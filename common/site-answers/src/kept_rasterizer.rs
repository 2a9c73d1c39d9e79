//! A rasterizer that is kept for the next answer: slicing a site takes most of the time of drawing one date of it.

use messages::{ContentHash, RobotProfile, Site};
use raster::{RasterizeError, Rasterizer};

/// The last rasterizer, of a site for a robot at a resolution.
#[derive(Default)]
pub struct KeptRasterizer(Option<(Key, Rasterizer)>);

/// What a rasterizer is of.
type Key = (ContentHash, RobotProfile, u64);

impl KeptRasterizer {
    /// The rasterizer of a site for a robot; made anew where another one is kept.
    ///
    /// # Errors
    /// A site that cannot be drawn so.
    pub fn of(
        &mut self,
        site: &Site<'_>,
        robot: &RobotProfile,
        resolution_m: f64,
    ) -> Result<&mut Rasterizer, RasterizeError> {
        let key = (site.content_hash(), *robot, resolution_m.to_bits());
        let kept = match self.0.take() {
            Some((known, rasterizer)) if known == key => rasterizer,
            _ => Rasterizer::new(site, robot, resolution_m)?,
        };
        Ok(&mut self.0.insert((key, kept)).1)
    }

    /// Gives it up.
    pub fn clear(&mut self) {
        self.0 = None;
    }
}
