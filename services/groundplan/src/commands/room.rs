//! `groundplan room`: where a room is, whether this robot may enter it, when that changes, and what is in it.

use crate::failure::Failure;
use crate::question::QuestionArgs;
use crate::run::{Outcome, Run};
use site_answers::RoomQuestion;

/// Arguments of `room`.
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
A robot may enter a room that the schedule has open, and to which a way leads from where the robot
starts: see [tour] start in config/waypoints.toml. The answer says why it may not, when the schedule
opens and closes the room, and, with maps of every later change of the schedule, when this robot may
enter it or may not any more (not with --only-now). It lists doors, scans, tasks and findings.
The JSON document has a schema: config/schemas/room.schema.json.

Examples:
  groundplan room G.02
  groundplan room 'Lab 3' house.ifc --date 2024-04-15
  groundplan room 'Lab 3' house.ifc --date 2024-04-15 --json | jq '.changes.at'

Exit codes: 0 the robot may enter it, 1 failed, 2 bad usage or configuration, 3 it may not, or that is
not known, 4 the maps of the running daemons may not be used.";

impl Run for Args {
    /// Looks at the room.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, a room that does not exist, no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        self.of.answer(&RoomQuestion { room: self.room.clone() }, &["room", &self.room])
    }
}
