//! `groundplan changes`: when anything changes, and what differs between two dates.

use crate::args::{ModelArgs, RobotArgs, ScheduleArgs, ScheduleInput, with_timeline};
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use answers::AnswerBasis;
use answers::changes::{self, revision};
use serde::Serialize;
use site_answers::{Drawing, KeptRasterizer, difference_between};
use std::path::PathBuf;
use waypoints::MissionPlanOptions;

/// Arguments of `changes`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// What differs between two dates
    #[arg(long, num_args = 2, value_names = ["A", "B"])]
    diff: Vec<String>,

    /// What the schedule files change against an older revision of the plan, in these files; may be repeated. Rules, table of
    /// links and reported progress are the same for both, --delay is for the new one only
    #[arg(long, value_name = "OLD_PLAN", requires = "schedule_file", conflicts_with = "diff")]
    against: Vec<PathBuf>,

    /// Rules and additions.
    #[command(flatten)]
    schedule: ScheduleArgs,

    /// The robot, for --diff.
    #[command(flatten)]
    robot: RobotArgs,

    /// The site.
    #[command(flatten)]
    model: ModelArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,
}

const AFTER_HELP: &str = "\
With --diff the maps of both dates are drawn for the robot and compared: which elements come and go, which doors can
be passed and which no longer, which spaces can be reached and which not.
With --against rooms that open at other dates are listed, elements that stand at others, and when the maps of each storey
may differ: an element in its heights or a space of it has another state.

Examples:
  groundplan changes house.ifc
  groundplan changes house.ifc --json | jq -r '.change_instants[]'
  groundplan changes house.ifc --diff 2024-04-15 2024-05-02
  groundplan changes house.ifc --schedule-file new.xer --against old.xer

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

impl Run for Args {
    /// Lists the changes.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, dates that can be read in two ways, maps that cannot be drawn.
    fn run(&self) -> Result<Outcome, Failure> {
        let schedule = ScheduleInput::read(&self.schedule)?;
        let instant_s = |text: &String| date_argument::instant_s(text, schedule.site_zone());
        let diff_s: Vec<i64> = self.diff.iter().map(instant_s).collect::<Result<_, _>>()?;
        let robot = self.robot.robot()?;
        let against = (!self.against.is_empty()).then(|| schedule.of_older_files(&self.against)).transpose()?;
        with_timeline(&self.model, &schedule, |site, timeline, progress| {
            if let Some(older) = &against {
                let older_tasks = older.linked_tasks(site)?;
                let older_timeline = older.timeline(&older_tasks.site(site)?)?;
                let revision = revision(site, (&older_timeline, older.file_names()), (timeline, schedule.file_names()));
                return if self.json { json(&revision) } else { Ok(revision.text().into()) };
            }
            let &[from_s, to_s] = diff_s.as_slice() else {
                let changes = timeline.changes();
                return if self.json {
                    json(&changes::document(site, timeline, &changes))
                } else {
                    Ok(changes::text(site, timeline, &changes).into())
                };
            };
            let drawing = Drawing {
                site,
                timeline: Some(timeline),
                robot: &robot,
                resolution_m: self.robot.resolution,
                options: &MissionPlanOptions::centres_only(),
                basis: AnswerBasis::Models,
                only_now: None,
                progress,
            };
            let kept = &mut KeptRasterizer::default();
            let difference =
                difference_between(&drawing, site, timeline, [from_s, to_s], kept).map_err(Failure::work)?;
            if self.json { json(&difference) } else { Ok(difference.text().into()) }
        })
    }
}

fn json(value: &impl Serialize) -> Result<Outcome, Failure> {
    Ok((serde_json::to_string(value).map_err(Failure::work)? + "\n").into())
}
