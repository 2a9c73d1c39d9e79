//! `site-frame.json`: the map frame of a site, reused by later runs.

use frames::{Map, UprightRigid3, World};
use messages::Site;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The map frame: `p_map = Rz(yaw) p_world + (x, y, z)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SiteFrameFile {
    /// The motion from the IFC world to the map.
    pub map_from_world: MapFromWorld,
    /// Counts changes of the frame, from 1.
    pub frame_epoch: u32,
}

/// A turn about Z and a shift.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapFromWorld {
    /// Shift along x in metres.
    pub x_m: f64,
    /// Shift along y in metres.
    pub y_m: f64,
    /// Shift along z in metres.
    pub z_m: f64,
    /// Turn about Z in radians.
    pub yaw_rad: f64,
}

/// A text that is no site frame.
#[derive(Debug, thiserror::Error)]
#[error("this is no site frame")]
pub struct SiteFrameError(#[from] serde_json::Error);

impl SiteFrameFile {
    /// The frame of a site.
    pub fn of(site: &Site<'_>) -> Self {
        // Adding zero turns a negative zero into a positive one.
        let [x_m, y_m, z_m] = site.head.map_from_world_m.map(|shift| shift + 0.0);
        let yaw_rad = site.head.map_from_world_yaw_rad + 0.0;
        Self { map_from_world: MapFromWorld { x_m, y_m, z_m, yaw_rad }, frame_epoch: site.head.frame_epoch }
    }

    /// Reads the file.
    ///
    /// # Errors
    /// Text that is not JSON of this shape.
    pub fn parse(bytes: &[u8]) -> Result<Self, SiteFrameError> {
        Ok(serde_json::from_slice(bytes)?)
    }

    /// The motion.
    pub fn motion(&self) -> UprightRigid3<Map, World> {
        let MapFromWorld { x_m, y_m, z_m, yaw_rad } = self.map_from_world;
        UprightRigid3::new([x_m, y_m, z_m], yaw_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_survives_its_file_to_the_last_bit() {
        let map_from_world =
            MapFromWorld { x_m: -400_000.0, y_m: 0.1 + 0.2, z_m: 0.0, yaw_rad: -0.523_598_775_598_298_8 };
        let frame = SiteFrameFile { map_from_world, frame_epoch: 3 };
        assert_eq!(SiteFrameFile::parse(&crate::json::text(&frame)).unwrap(), frame);
        assert!(SiteFrameFile::parse(b"{}").is_err());
    }
}
