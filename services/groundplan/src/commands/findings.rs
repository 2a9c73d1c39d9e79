//! `groundplan findings`: what model, schedule and mission plan lack: errors, warnings, assumptions, substitutions, omissions.

use crate::failure::Failure;
use crate::question::QuestionArgs;
use crate::run::{Outcome, Run};
use site_answers::FindingsQuestion;

/// Arguments of `findings`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Of what.
    #[command(flatten)]
    of: QuestionArgs,
}

const AFTER_HELP: &str = "\
Errors and warnings about model, schedule and waypoints; floors and widths that are assumed; bodies for
which a box stands in; rooms and storeys on no map. Each names what it is about with its GlobalId. They
are what report.json and waypoints.json of `convert` have, and the page shows.
The JSON document has a schema: config/schemas/findings.schema.json.

Examples:
  groundplan findings
  groundplan findings house.ifc
  groundplan findings house.ifc --json | jq '.warnings.list[].global_id'

Exit codes: 0 there is neither an error nor a warning, 1 failed, 2 bad usage or configuration, 3 there
is one, 4 the maps of the running daemons may not be used.";

impl Run for Args {
    /// Collects the findings.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        self.of.answer(&FindingsQuestion, &["findings"])
    }
}
