//! Files of a site and how they become one.

use crate::progress::Progress;
use crate::site_frame::SiteFrame;
use frames::{UprightRigid3, World};
use std::path::PathBuf;

/// A file of the site, read.
#[derive(Debug)]
pub struct SourceFile {
    /// Where it was read from; only the base name is kept in products.
    pub path: PathBuf,
    /// Its bytes: STEP or a zip container.
    pub bytes: Vec<u8>,
}

impl SourceFile {
    /// The base name, for products and messages.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }
}

/// How files become a site.
#[derive(Clone, Copy)]
pub struct IngestOptions<'a> {
    /// The site's frame from an earlier run; `None` fixes it anew.
    pub frame: Option<SiteFrame>,
    /// Epoch of a frame that is fixed anew, from 1.
    pub frame_epoch: u32,
    /// Where each file lies, by its index; files beyond the end have no place of their own.
    pub places: &'a [Option<Place>],
    /// Of elements with one GlobalId and different bodies, keep the last instead of refusing.
    pub prefer_last: bool,
    /// Accept a file of whose bodies more than half are bounding boxes.
    pub allow_boxes: bool,
    /// Called as work advances.
    pub progress: &'a (dyn Fn(Progress<'_>) + Sync),
}

/// Where a file's world lies in the site's world, as the user says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Translation in metres.
    pub translation_m: [f64; 3],
    /// Turn about Z in radians.
    pub yaw_rad: f64,
}

impl Place {
    /// The motion from the file's world to that of the site.
    pub(crate) fn motion(self) -> UprightRigid3<World, World> {
        UprightRigid3::new(self.translation_m, self.yaw_rad)
    }
}

/// Spaces that a site may have: the `space` layer holds a 16-bit index plus one.
pub const MAX_SPACES: usize = u16::MAX as usize;
