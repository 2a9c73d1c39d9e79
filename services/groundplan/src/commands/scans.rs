//! `groundplan scans`: where the robot scans in a room, what each scan sees, or why there is none.

use crate::failure::Failure;
use crate::question::QuestionArgs;
use crate::run::{Outcome, Run};
use site_answers::ScansQuestion;

/// Arguments of `scans`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// The room, by number, name, long name or GlobalId
    #[arg(value_name = "ROOM")]
    room: String,

    /// Of what.
    #[command(flatten)]
    of: QuestionArgs,
}

const AFTER_HELP: &str = "\
Scans are planned for the whole site, as `convert` does: what a scan of another room sees through a
door is not scanned again, so that a room may have none. Each pose says how much floor it sees that no
scan before it saw, how many sides of cells, and which scans it joins.
The JSON document has a schema: config/schemas/scans.schema.json.

Examples:
  groundplan scans G.02
  groundplan scans 'Lab 3' house.ifc --date 2024-04-15
  groundplan scans 'Lab 3' house.ifc --json | jq '.scans[].at_m'

Exit codes: 0 there are scans in it, 1 failed, 2 bad usage or configuration, 3 there is none, 4 the maps
of the running daemons may not be used.";

impl Run for Args {
    /// Looks at the scans of the room.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, a room that does not exist, no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        self.of.answer(&ScansQuestion { room: self.room.clone() }, &["scans", &self.room])
    }
}
