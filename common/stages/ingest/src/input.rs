//! Source files of a site, and options of ingestion.

use crate::progress::Progress;
use crate::site_frame::SiteFrame;
use frames::{UprightRigid3, World};
use messages::SiteOutline;
use std::path::PathBuf;

/// Bytes of the largest file of a model that a caller has to read: STEP has less, and nothing larger fits an index.
pub const MAX_MODEL_BYTES: u64 = 4 << 30;

/// A file of the site, read.
#[derive(Debug)]
pub struct SourceFile {
    /// Path of the file; only the base name is kept in outputs.
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

/// Options of ingestion.
#[derive(Clone, Copy)]
pub struct IngestOptions<'a> {
    /// The site's frame from an earlier run; `None` fixes it anew.
    pub frame: Option<SiteFrame>,
    /// The site that `frame` is of: another building, which shares few of its elements, gets a frame of its own. `None` keeps
    /// the frame for any model.
    pub frame_of: Option<&'a SiteOutline>,
    /// Epoch of a frame that is fixed anew, from 1.
    pub frame_epoch: u32,
    /// Placement of each file by index; further files have none.
    pub places: &'a [Option<FilePlacement>],
    /// Of elements with one GlobalId and different bodies, keep the last instead of refusing.
    pub prefer_last: bool,
    /// Accept a file of whose bodies more than half are bounding boxes.
    pub allow_boxes: bool,
    /// Meshes in another process those bodies of which nothing bounds what they need; `None`: in this one.
    pub isolation: Option<&'a ifc::Isolation<'a>>,
    /// Meshes of an earlier reading of these files, or of others, which takes those of this one.
    pub cache: Option<&'a ifc::MeshCache>,
    /// Threads for meshing; `None`: a pool of its own for each file, with as many threads as the caller's has.
    pub pool: Option<&'a ifc::MeshPool>,
    /// Called as work advances.
    pub progress: &'a (dyn Fn(Progress<'_>) + Sync),
}

/// Those of a model alone: a frame of its own, no placements, the strictest checks; all is meshed here and anew.
impl Default for IngestOptions<'_> {
    fn default() -> Self {
        Self {
            frame: None,
            frame_of: None,
            frame_epoch: 1,
            places: &[],
            prefer_last: false,
            allow_boxes: false,
            isolation: None,
            cache: None,
            pool: None,
            progress: &|_| {},
        }
    }
}

/// Placement of a file's world in the site's world, given by the user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilePlacement {
    /// Translation in metres.
    pub translation_m: [f64; 3],
    /// Turn about Z in radians.
    pub yaw_rad: f64,
}

impl FilePlacement {
    /// The motion from the file's world to that of the site.
    pub(crate) fn motion(self) -> UprightRigid3<World, World> {
        UprightRigid3::new(self.translation_m, self.yaw_rad)
    }
}

/// Spaces that a site may have: the `space` layer holds a 16-bit index plus one.
pub const MAX_SPACES: usize = u16::MAX as usize;
