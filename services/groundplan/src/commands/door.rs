//! `groundplan door`: where a door is, whether this robot can pass it, and when that changes.

use crate::failure::Failure;
use crate::question::QuestionArgs;
use crate::run::{Outcome, Run};
use site_answers::DoorQuestion;

/// Arguments of `door`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// The door, by name or GlobalId
    #[arg(value_name = "DOOR")]
    door: String,

    /// Of what.
    #[command(flatten)]
    of: QuestionArgs,
}

const AFTER_HELP: &str = "\
A door can be passed if it hangs, this robot opens doors of its kind, its clear width is the robot's
diameter and margin, and the map has a way through it; whether a way leads to it is the question of
`groundplan way`. The answer says every reason why it cannot, when it is hung, and, with maps of every
later change of the schedule, when that changes (not with --only-now). Where no door hangs yet,
its opening can be passed if it has floor and is as wide on the map as the robot; else that is
not known.
The JSON document has a schema: config/schemas/door.schema.json.

Examples:
  groundplan door 0HqJ8fVbD8MwFo$C6Ls2Rf
  groundplan door 'Door G.02' house.ifc --date 2024-04-15
  groundplan door 'Door G.02' house.ifc --json | jq '.reasons'

Exit codes: 0 the robot can pass it, 1 failed, 2 bad usage or configuration, 3 it cannot, or that is not
known, 4 the maps of the running daemons may not be used.";

impl Run for Args {
    /// Looks at the door.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, a door that does not exist, no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        self.of.answer(&DoorQuestion { door: self.door.clone() }, &["door", &self.door])
    }
}
