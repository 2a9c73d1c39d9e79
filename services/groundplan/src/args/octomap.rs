//! Arguments of the octree of structure.

use crate::args::cloud::CloudArgs;
use crate::failure::Failure;
use cloud::OctomapOptions;

/// Cells for planners that look in three dimensions.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct OctomapArgs {
    /// Write which cells of a volume are occupied by what the cloud would have points of, and which are free in rooms, as an
    /// OctoMap too, for planners of arms and of what flies
    #[arg(long)]
    octomap: bool,

    /// Side of a cell [default: 0.1]
    #[arg(long, value_name = "METRES", requires = "octomap")]
    octomap_resolution: Option<f64>,

    /// Lower and upper corner of the volume in `map`, X0,Y0,Z0,X1,Y1,Z1 in metres [default: bounds of structure and rooms]
    #[arg(long, value_name = "CORNERS", value_delimiter = ',', allow_hyphen_values = true, requires = "octomap")]
    octomap_box: Vec<f64>,
}

impl OctomapArgs {
    /// What the octree is like; `None` if none is asked for. Classes are those of the cloud.
    ///
    /// # Errors
    /// Values that no octree can have.
    pub(crate) fn options(&self, cloud: &CloudArgs) -> Result<Option<OctomapOptions>, Failure> {
        let options =
            || OctomapOptions::of(self.octomap_resolution, cloud.classes(), &self.octomap_box).map_err(Failure::usage);
        self.octomap.then(options).transpose()
    }
}
