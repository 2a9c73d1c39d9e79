//! `groundplan confirm`: confirms the pending pose or absent elements, takes that back, and lists both.

use crate::alignment_request::{other_answer, outcome_of, published};
use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join};
use bus::{Bus, Waiter};
use daemon::facts::Pose;
use daemon::{AlignAnswer, AlignRequest, Confirmations, Confirmed, ConfirmedElement, ListedPose};
use serde_json::{Value, json};
use std::fmt::Write;

/// The word for the pending pose.
const POSE: &str = "pose";

/// Arguments of `confirm`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// `pose`, or GlobalIds of elements that are absent although they are planned to be there: maps leave them out until they
    /// are observed [default: the pose that waits]
    #[arg(value_name = "pose|GLOBALID")]
    what: Vec<String>,

    /// List what waits, and what was confirmed by whom
    #[arg(long, conflicts_with_all = ["what", "undo"])]
    list: bool,

    /// Take the confirmation of these elements back, or that of the pose: the pose before it comes back
    #[arg(long)]
    undo: bool,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

const AFTER_HELP: &str = "\
Examples:
  groundplan confirm --list
  groundplan confirm                              # the pose that waits
  groundplan confirm 0T8xbPmeHQFhEy1wPGGLbq       # an element that is absent
  groundplan confirm --undo 0T8xbPmeHQFhEy1wPGGLbq

Exit codes: 0 done, 1 failed (nothing waits, an element that the robot has not seen through), 2 bad usage or configuration.";

impl Run for Args {
    /// Confirms, takes back or lists.
    ///
    /// # Errors
    /// No daemons, nothing that waits or can be taken back, elements that the robot has not seen through.
    fn run(&self) -> Result<Outcome, Failure> {
        let (bus, mut waiter) = join(&self.site.config()?)?;
        if self.list {
            return self.list(&bus, &mut waiter);
        }
        let is_pose = self.what.is_empty() || self.what == [POSE];
        if !is_pose && self.what.iter().any(|what| what == POSE) {
            return Err(Failure::usage("confirm the pose and elements one after the other"));
        }
        let elements = if is_pose { Vec::new() } else { self.what.clone() };
        let request = match (self.undo, is_pose) {
            (true, _) => AlignRequest::UndoConfirm { elements },
            (false, true) => AlignRequest::ConfirmPose,
            (false, false) => AlignRequest::ConfirmAbsent { elements },
        };
        match ask(&bus, &mut waiter, &request)? {
            AlignAnswer::Pose(alignment) => {
                let sample = published(&bus, &mut waiter, alignment)?;
                Ok(Outcome { exit_code: 0, ..outcome_of(&sample, self.json) })
            }
            AlignAnswer::Elements(elements) => Ok(self.elements(&elements).into()),
            _ => Err(other_answer()),
        }
    }
}

impl Args {
    fn list(&self, bus: &Bus, waiter: &mut Waiter) -> Result<Outcome, Failure> {
        let AlignAnswer::Confirmations(listed) = ask(bus, waiter, &AlignRequest::ListConfirmed)? else {
            return Err(other_answer());
        };
        Ok(if self.json { format!("{:#}\n", json!(listed)) } else { list_text(&listed) }.into())
    }

    fn elements(&self, elements: &[ConfirmedElement]) -> String {
        if self.json {
            let key = if self.undo { "no_longer_absent" } else { "absent" };
            return format!("{:#}\n", Value::from_iter([(key, json!(elements))]));
        }
        let what = if self.undo { "no longer confirmed to be absent" } else { "confirmed to be absent" };
        elements.iter().map(|element| format!("{what}: {}\n", element_text(element))).collect()
    }
}

fn list_text(listed: &Confirmations) -> String {
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = match &listed.waiting {
        Some(pose) => writeln!(out, "waits: the pose of the SLAM map, {}; groundplan confirm pose", pose_text(pose)),
        None => writeln!(out, "no pose waits"),
    };
    if let Some((pose, by)) = &listed.before_confirmed {
        let (by, pose) = (confirmed_text(by), pose_text(pose));
        let _ = writeln!(out, "confirmed {by}: the pose in effect; before it {pose}; groundplan confirm --undo pose");
    }
    for element in &listed.absent {
        let by = element.confirmed.as_ref().map_or("earlier".to_owned(), confirmed_text);
        let _ = writeln!(out, "confirmed {by}: absent {}", element_text(element));
    }
    if listed.absent.is_empty() {
        out.push_str("no element is confirmed to be absent\n");
    }
    out
}

fn pose_text(ListedPose { storey, map_from_slam }: &ListedPose) -> String {
    let Pose { x_m, y_m, yaw_rad } = map_from_slam;
    format!("storey {storey}, x {x_m:.3} m, y {y_m:.3} m, yaw {:.3} degrees", yaw_rad.to_degrees())
}

fn confirmed_text(Confirmed { by, at }: &Confirmed) -> String {
    format!("{at:.0} by {by}")
}

fn element_text(ConfirmedElement { global_id, ifc_type, name, storey, .. }: &ConfirmedElement) -> String {
    match ifc_type.is_empty() {
        true => global_id.clone(),
        false => format!("{global_id}  {ifc_type} {name:?}, {storey}"),
    }
}
