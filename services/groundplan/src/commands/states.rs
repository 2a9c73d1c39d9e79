//! `groundplan states`: which elements stand and which spaces may be entered.

use crate::args::{ModelArgs, ScheduleArgs, ScheduleInput, with_timeline};
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use answers::states::{StateProbabilities, states, text_of, whole_day};
use messages::{ScheduleState, Site};
use schedule::{Period, Probabilities, Timeline};

/// Arguments of `states`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// The date, an instant: 2024-04-15 is its midnight; may be repeated
    #[arg(long, value_name = "DATE", required = true)]
    date: Vec<String>,

    /// List the union from the date until this one, as `convert` draws it; days count whole
    #[arg(long, value_name = "DATE")]
    until: Option<String>,

    /// List how probable it is that elements stand, or are there at all, and that spaces are open; and the safest days of
    /// each space in the four weeks from the date on. Durations are drawn by [uncertainty] of the rules
    #[arg(long)]
    probability: bool,

    /// Rules and additions.
    #[command(flatten)]
    schedule: ScheduleArgs,

    /// The site.
    #[command(flatten)]
    model: ModelArgs,

    /// Print one JSON document on standard output and nothing else there; an array if there are several dates
    #[arg(long)]
    json: bool,
}

const AFTER_HELP: &str = "\
Dates are local to the site, or carry an offset, which is converted to the site's zone.
States are those of an instant: 2024-04-15 is its midnight, or 2024-04-15T08:30:00.
A map serves a whole day: `convert --date 2024-04-15` draws the union of all instants of the day,
which is `--date 2024-04-15 --until 2024-04-15` here. For a date without a time, what differs during
the day is listed, too (\"whole_day\" in JSON). In a union a space is blocked if it is at any instant,
and an element that does not stand throughout is in_progress.
States of elements: not_started, in_progress, built, being_removed, removed.
Reasons of blocked spaces: task:GlobalId, before_room_date, or what the rules say (private).

Examples:
  groundplan states house.ifc --date 2024-04-15
  groundplan states house.ifc --date 2024-04-15T08:00:00 --date 2024-05-02 --json | jq '.[].spaces'
  groundplan states house.ifc --date 2024-04-15 --until 2024-04-19
  groundplan states house.ifc --date 2024-04-15 --probability --json | jq .probability.spaces
  groundplan states house.ifc --date 2024-04-15 --delay 'Partition walls=5d'

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

impl Run for Args {
    /// Prints the states at every given date.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, dates that can be read in two ways.
    fn run(&self) -> Result<Outcome, Failure> {
        let schedule = ScheduleInput::read(&self.schedule)?;
        let until = self.until.as_deref();
        if until.is_some() && self.date.len() > 1 {
            return Err(Failure::usage("--until ends one period: give one --date"));
        }
        let period = |text: &String| date_argument::instant_or_period(text, until, schedule.site_zone());
        let periods: Vec<(Period, Option<Period>)> = self.date.iter().map(period).collect::<Result<_, _>>()?;
        with_timeline(&self.model, &schedule, |site, timeline, _| {
            let probabilities = self.probability.then(|| schedule.probabilities(site, timeline)).transpose()?;
            let at = |asked: &(Period, Option<Period>)| at(site, timeline, probabilities.as_ref(), *asked, self.json);
            let all: Vec<String> = periods.iter().map(at).collect::<Result<_, _>>()?;
            let text = match all.as_slice() {
                [one] => one.clone(),
                several if self.json => format!("[{}]\n", several.join(",").replace('\n', "")),
                several => several.join("\n"),
            };
            Ok(text.into())
        })
    }
}

fn at(
    site: &Site<'_>,
    timeline: &Timeline,
    probabilities: Option<&Probabilities<'_>>,
    (period, day): (Period, Option<Period>),
    json: bool,
) -> Result<String, Failure> {
    let schedule_state = timeline.schedule_state(period).finish();
    let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
    let of_day = day.map(|day| timeline.schedule_state(day).finish());
    let of_day = of_day
        .as_ref()
        .map(|schedule_state| ScheduleState::open(schedule_state.bytes()))
        .transpose()
        .map_err(Failure::work)?;
    let whole_day = day.zip(of_day.as_ref()).map(|(day, of_day)| whole_day(site, &schedule_state, day, of_day));
    let probability = probabilities.map(|probabilities| StateProbabilities::of(site, probabilities, period));
    if json {
        let states = states(site, &schedule_state, period, whole_day, probability);
        Ok(serde_json::to_string(&states).map_err(Failure::work)? + "\n")
    } else {
        let more = probability.map_or(String::new(), |probability| probability.text(site));
        Ok(text_of(site, timeline, &schedule_state, period, whole_day) + &more)
    }
}
