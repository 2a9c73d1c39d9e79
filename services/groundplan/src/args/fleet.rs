//! Arguments of the files for the control of fleets.

use fleet::FleetFormat;

/// Files for the control of fleets.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct FleetArgs {
    /// Write what the control of a fleet reads too, in these formats, separated by commas or repeated: vda5050, zone sets and maps to
    /// download; lif, the route graph as layouts
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', value_parser = ["vda5050", "lif"])]
    fleet: Vec<String>,
}

impl FleetArgs {
    /// The formats that are asked for.
    pub(crate) fn formats(&self) -> Vec<FleetFormat> {
        let is_named = |format: &FleetFormat| self.fleet.iter().any(|name| name == format.name());
        FleetFormat::ALL.into_iter().filter(is_named).collect()
    }
}
