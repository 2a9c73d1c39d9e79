//! Arguments of the cloud of structure.

use crate::failure::Failure;
use cloud::CloudOptions;

/// Points for lidars that look in three dimensions.
#[derive(Debug, Clone, clap::Args)]
#[command(group(clap::ArgGroup::new("structure").args(["cloud", "octomap"]).multiple(true)))]
pub(super) struct CloudArgs {
    /// Write the surfaces of what stands finished as points with normals too, for lidars that look in three dimensions
    #[arg(long)]
    cloud: bool,

    /// Distance between points [default: 0.05]
    #[arg(long, value_name = "METRES", requires = "cloud")]
    cloud_spacing: Option<f64>,

    /// Classes that have points, and cells of --octomap, as classes.png has them; glass and boxes that stand in never do [default:
    /// wall,column,stair,ramp,curtain_wall,slab,beam, with coverings and footings]
    #[arg(long, value_name = "CLASS", value_delimiter = ',', requires = "structure")]
    cloud_classes: Vec<String>,
}

impl CloudArgs {
    /// What the cloud is like; `None` if none is asked for.
    ///
    /// # Errors
    /// Values that no cloud can have.
    pub(crate) fn options(&self) -> Result<Option<CloudOptions>, Failure> {
        let options = || CloudOptions::of(self.cloud_spacing, &self.cloud_classes).map_err(Failure::usage);
        self.cloud.then(options).transpose()
    }

    /// The classes that are asked for.
    pub(crate) fn classes(&self) -> &[String] {
        &self.cloud_classes
    }
}
