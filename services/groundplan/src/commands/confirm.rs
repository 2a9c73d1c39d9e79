//! `groundplan confirm`: confirms the pending pose, the revision of the model that waits, or absent elements; takes that back, and
//! lists all.

use crate::alignment_request::{other_answer, outcome_of, published};
use crate::args::SiteOfRobotArgs;
use crate::failure::Failure;
use crate::load_progress::LoadProgress;
use crate::revision_report;
use crate::run::{Outcome, Run};
use crate::wait::{ask, ask_with_progress, join, wait_for_site};
use bus::{Bus, Waiter};
use daemon::facts::Pose;
use daemon::{
    AlignAnswer, AlignRequest, Confirmations, Confirmed, ConfirmedElement, IngestRequest, ListedPose, Revision,
    RevisionEffect, SiteConfig,
};
use serde_json::{Value, json};
use std::fmt::Write;

/// The word for the pending pose.
const POSE: &str = "pose";
/// The word for the revision that waits.
const MODEL: &str = "model";

/// Arguments of `confirm`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// `pose`, `model`, or GlobalIds of elements that are absent although they are planned to be there: maps leave them out
    /// until they are observed [default: the pose or the revision of the model that waits]
    #[arg(value_name = "pose|model|GLOBALID")]
    what: Vec<String>,

    /// List what waits, and what was confirmed by whom
    #[arg(long, conflicts_with = "what")]
    list: bool,

    /// Take confirmations back: `groundplan undo`.
    #[arg(skip)]
    undo: bool,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,
}

const AFTER_HELP: &str = "\
Examples:
  groundplan confirm --list
  groundplan confirm                              # the pose or the revision that waits
  groundplan confirm model                        # the revision that `groundplan load` compared
  groundplan confirm 0T8xbPmeHQFhEy1wPGGLbq       # an element that is absent
  groundplan undo 0T8xbPmeHQFhEy1wPGGLbq          # takes that back

Exit codes: 0 done, 1 failed (nothing waits, an element that the robot has not seen through), 2 bad usage or configuration.";

impl Args {
    /// Takes confirmations back.
    pub(crate) fn undo(what: Vec<String>, json: bool, site: SiteOfRobotArgs) -> Self {
        Self { what, list: false, undo: true, json, site }
    }
}

impl Run for Args {
    /// Confirms, takes back or lists.
    ///
    /// # Errors
    /// No daemons, nothing that waits or can be taken back, elements that the robot has not seen through.
    fn run(&self) -> Result<Outcome, Failure> {
        // A revision is of the whole site.
        let config = if self.what == [MODEL] { self.site.config_of_any()? } else { self.site.config()? };
        let (bus, mut waiter) = join(&config)?;
        // Of a site that another machine draws, revisions wait there.
        let draws = config.follow.is_none();
        if self.list {
            return self.list(draws, &bus, &mut waiter);
        }
        let is_model = self.what == [MODEL];
        if is_model && self.undo {
            return Err(Failure::usage("a revision is taken back with `groundplan load` of the files before it"));
        }
        if is_model || self.what.is_empty() && !self.undo && draws && is_revision_meant(&bus, &mut waiter)? {
            return self.model(&self.site.site().config_of_drawing()?, &bus, &mut waiter);
        }
        let is_pose = self.what.is_empty() || self.what == [POSE];
        if !is_pose && self.what.iter().any(|what| what == POSE || what == MODEL) {
            return Err(Failure::usage("confirm the pose, the model and elements one after the other"));
        }
        let elements = if is_pose { Vec::new() } else { self.what.clone() };
        let request = match (self.undo, is_pose) {
            (true, true) => {
                let confirmed = confirmations(&bus, &mut waiter)?.before_confirmed;
                let (before, _) = confirmed.ok_or_else(|| Failure::work("no confirmed pose can be taken back"))?;
                AlignRequest::UndoPose { before }
            }
            (true, false) => AlignRequest::UndoAbsent { elements },
            (false, true) => {
                let waiting = confirmations(&bus, &mut waiter)?.waiting;
                let waiting = waiting.ok_or_else(|| Failure::work("no pose waits to be confirmed"))?;
                AlignRequest::ConfirmPose { waiting }
            }
            (false, false) => AlignRequest::ConfirmAbsent { elements },
        };
        match ask(&bus, &mut waiter, &request)? {
            AlignAnswer::Pose(alignment) => {
                let sample = published(&bus, &mut waiter, alignment)?;
                Ok(Outcome { exit_code: 0, ..outcome_of(&sample, None, self.json) })
            }
            AlignAnswer::Elements(elements) => Ok(self.elements(&elements).into()),
            _ => Err(other_answer()),
        }
    }
}

/// The revision of the model that waits.
fn waiting_revision(bus: &Bus, waiter: &mut Waiter) -> Result<Option<Revision>, Failure> {
    let answer = ask(bus, waiter, &IngestRequest::GetRevision)?;
    Ok(answer.revision.filter(|_| answer.effect == RevisionEffect::Waits))
}

fn confirmations(bus: &Bus, waiter: &mut Waiter) -> Result<Confirmations, Failure> {
    match ask(bus, waiter, &AlignRequest::ListConfirmed)? {
        AlignAnswer::Confirmations(listed) => Ok(listed),
        _ => Err(other_answer()),
    }
}

/// True if a revision waits, and no pose.
///
/// # Errors
/// Both wait: one of them has to be named.
fn is_revision_meant(bus: &Bus, waiter: &mut Waiter) -> Result<bool, Failure> {
    let Some(revision) = waiting_revision(bus, waiter)? else { return Ok(false) };
    match confirmations(bus, waiter)?.waiting {
        None => Ok(true),
        Some(pose) => Err(Failure::work(format!(
            "{}\nthe pose of the SLAM map waits, {}\nsay which: groundplan confirm model, or groundplan confirm pose",
            revision_text(&revision),
            pose_text(&pose)
        ))),
    }
}

fn revision_text(revision: &Revision) -> String {
    let names: Vec<String> = revision.models.iter().map(|path| path.display().to_string()).collect();
    format!("the revision {} waits ({})", names.join(", "), revision.comparison.objections.join("; "))
}

impl Args {
    /// Confirms the revision that waits, and waits for its maps.
    fn model(&self, config: &SiteConfig, bus: &Bus, waiter: &mut Waiter) -> Result<Outcome, Failure> {
        let revision = waiting_revision(bus, waiter)?;
        let Revision { sha256, .. } = revision.ok_or_else(|| Failure::work("no revision waits to be confirmed"))?;
        let progress = LoadProgress::new();
        let answer = ask_with_progress(bus, waiter, &IngestRequest::Confirm { sha256 }, |news| progress.show(news))?;
        let is_in_force = answer.effect == RevisionEffect::InForce;
        if is_in_force {
            progress.waits_for("drawing maps");
            wait_for_site(waiter, config, &answer.site, "the revision")?;
        }
        drop(progress);
        let text = if self.json { format!("{:#}\n", json!(answer)) } else { revision_report::text(&answer) };
        Ok(Outcome::judged(text, is_in_force))
    }

    fn list(&self, draws: bool, bus: &Bus, waiter: &mut Waiter) -> Result<Outcome, Failure> {
        let revision = if draws { waiting_revision(bus, waiter)? } else { None };
        let listed = confirmations(bus, waiter)?;
        if self.json {
            let mut document = json!(listed);
            document["revision"] = json!(revision);
            return Ok(format!("{document:#}\n").into());
        }
        let model = revision.map_or("no revision of the model waits".to_owned(), |revision| {
            format!("{}; groundplan confirm model", revision_text(&revision))
        });
        Ok(format!("{model}\n{}", list_text(&listed)).into())
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
        let _ = writeln!(out, "confirmed {by}: the pose in effect; before it {pose}; groundplan undo pose");
    }
    for element in &listed.absent {
        let by = element.confirmed.as_ref().map_or_else(String::new, confirmed_text);
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
    format!("{global_id}  {ifc_type} {name:?}, {storey}")
}
