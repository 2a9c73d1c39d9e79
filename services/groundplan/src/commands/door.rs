//! `groundplan door`: where a door is, whether this robot can pass it, and when that changes.

use crate::failure::Failure;
use crate::question::{Answer, Question, QuestionArgs};
use crate::run::{Outcome, Run};
use answers::{Circumstances, DoorAnswer, FindError, Later, Situation, find_door};
use messages::Site;
use std::collections::BTreeSet;
use waypoints::MissionPlanOptions;

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
        self.of.answer(self)
    }
}

impl Question for Args {
    type Found = usize;
    type Answer = DoorAnswer;

    fn command(&self) -> Vec<&str> {
        vec!["door", &self.door]
    }

    fn find(&self, site: &Site<'_>) -> Result<usize, FindError> {
        find_door(site, &self.door)
    }

    fn options(&self, _: &Site<'_>, _: &usize, options: MissionPlanOptions) -> MissionPlanOptions {
        MissionPlanOptions { kinds: BTreeSet::new(), ..options }
    }

    fn depends_on_start(&self) -> bool {
        false
    }

    fn answer(&self, situation: &Situation<'_>, door: &usize) -> DoorAnswer {
        answers::door(situation, *door)
    }

    fn verdict(&self, situation: &Situation<'_>, door: &usize) -> Option<bool> {
        answers::can_pass(situation, *door)
    }
}

impl Answer for DoorAnswer {
    fn verdict(&self) -> Option<bool> {
        self.can_pass
    }

    fn wants_later(&self) -> bool {
        true
    }

    fn set_changes(&mut self, changes: Later) {
        self.changes = Some(changes);
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }

    fn text(&self) -> String {
        self.text()
    }
}
