//! `groundplan way`: the way from a place to another over storeys, or what is missing.

use crate::failure::Failure;
use crate::question::QuestionArgs;
use crate::run::{Outcome, Run};
use site_answers::WayQuestion;

/// Arguments of `way`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Where it begins: a room by number, name, long name or GlobalId, or a point X,Y,STOREY in metres of the frame map, with the
    /// index or name of the storey
    #[arg(value_name = "FROM")]
    from: String,

    /// Where it ends
    #[arg(value_name = "TO")]
    to: String,

    /// Of what.
    #[command(flatten)]
    of: QuestionArgs,
}

const AFTER_HELP: &str = "\
A way exists only if this robot can stand on every cell of it: it is searched on the maps, through
the stairs, ramps, lifts and steps that the robot uses. Its legs name rooms and doors in their order.
Otherwise the answer names what is missing on the way with the fewest obstacles, with GlobalIds: doors
that are closed to the robot, and why; rooms that the schedule closes, and the tasks; stairs, ramps and
lifts that are not built, or not for this robot; floor that is not built, keep-out or too narrow. Then
maps of every later change of the schedule are drawn until there is a way (not with --only-now).
A room is where the robot can stand nearest to the centroid of its floor.
A point with a negative coordinate comes behind two dashes: groundplan way -- -1.5,2,0 'Lab 3'
The JSON document has a schema: config/schemas/way.schema.json.

Examples:
  groundplan way G.02 U.04
  groundplan way G.02 U.04 house.ifc --date 2024-04-15
  groundplan way 3.5,2.0,0 'Lab 3' house.ifc --robot config/robots/legged.toml
  groundplan way G.02 U.04 house.ifc --date 2024-04-15 --json | jq '.missing[].global_id'

Exit codes: 0 there is a way, 1 failed, 2 bad usage or configuration, 3 there is none, 4 the maps of the
running daemons may not be used.";

impl Run for Args {
    /// Finds the way.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, rooms or storeys that do not exist, no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        self.of.answer(&WayQuestion { from: self.from.clone(), to: self.to.clone() }, &["way", &self.from, &self.to])
    }
}
