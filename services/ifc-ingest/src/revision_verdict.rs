//! The verdict on a revision that was read and compared: it takes effect, waits for an operator, or is refused.
//!
//! | what schedule-eval says of its schedule | the proposal | verdict |
//! |---|---|---|
//! | nothing yet | was refused before | stays refused |
//! | nothing yet | a client has waited for [`MAX_WAIT_MS`] | refused |
//! | nothing yet | any other | open |
//! | it cannot be used | was refused before, for the same reason | stays refused |
//! | it cannot be used | any other | refused |
//! | it can be used | is to be compared only | compared |
//! | it can be used | has no objections; is forced; is confirmed by the hashes of its files; is of the very files in force | takes effect |
//! | it can be used | any other | waits for an operator |
//!
//! Objections, with their limits in `messages::SiteComparison`: less than half of the elements of the smaller one are shared; most bodies moved; the
//! georeference is another; a storey loses most of its elements or bodies, or its map; many more warnings, or more damaged records.
//! A revision is refused before it is proposed where its files cannot be read, or the map frame that is kept cannot be used; one that finds no room on disk or on the bus is refused and tried again
//! (`in_force.rs`). [`Refusal`] says what is
//! kept of one that is refused.

use crate::model_files::names_of;
use crate::proposal::{Intent, Proposal};
use crate::revisions::Revisions;
use daemon::ScheduleVerdict;
use std::path::PathBuf;

/// How long a client waits for schedule-eval to judge a revision.
pub(crate) const MAX_WAIT_MS: i64 = 30_000;

/// What becomes of a proposal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It is looked at again.
    Open,
    /// It is refused for the reason that is kept already; its files may have changed meanwhile.
    StaysRefused,
    /// It is refused, and why.
    Refused(String),
    /// How it differs from the site in force is told; nothing changes.
    Compared,
    /// It is kept until an operator confirms or discards it.
    WaitsForOperator,
    /// It is in force.
    TakesEffect,
}

/// The verdict on a proposal, from what schedule-eval has said of it by now.
pub(crate) fn verdict_on(
    proposal: &Proposal,
    schedule: Option<&ScheduleVerdict>,
    revisions: &Revisions,
    since_boot_ms: i64,
) -> Verdict {
    let names = || names_of(&proposal.revision.models);
    let refused = match schedule {
        None if proposal.refused.is_some() => return Verdict::StaysRefused,
        None if proposal.asked.is_none() || since_boot_ms - proposal.since_boot_ms < MAX_WAIT_MS => {
            return Verdict::Open;
        }
        None => Some(format!("schedule-eval has not said whether {} has a schedule: does it run?", names())),
        Some(verdict) => {
            verdict.refused.as_ref().map(|why| format!("the schedule of {} cannot be used: {why}", names()))
        }
    };
    match refused {
        Some(why) if proposal.refused.as_ref() == Some(&why) => Verdict::StaysRefused,
        Some(why) => Verdict::Refused(why),
        None if proposal.intent == Intent::Compare => Verdict::Compared,
        None if needs_operator(proposal, revisions) => Verdict::WaitsForOperator,
        None => Verdict::TakesEffect,
    }
}

/// True if a revision that can be used takes effect only when an operator says so.
fn needs_operator(proposal: &Proposal, revisions: &Revisions) -> bool {
    let revision = &proposal.revision;
    let is_confirmed = match &proposal.intent {
        Intent::Force => true,
        Intent::Confirm(sha256) => *sha256 == revision.sha256(),
        Intent::Load | Intent::Compare => false,
    };
    // Read again after the cache was lost, for instance.
    let is_in_force = revisions.are_in_force(&revision.models, &revision.stamps);
    !(is_confirmed || is_in_force || revision.comparison.objections.is_empty())
}

/// What is kept of a revision that is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// Nothing: it is told to who asked.
    Told,
    /// It is told, and stands in the history: a client asked for other files than those of the site.
    Recorded,
    /// It stands in the status, over restarts, until its files change, it can be used, it is discarded, or another revision takes effect
    /// or waits; and in the history, unless the last refusal was of the same files for the same reason. Where it could not be written, it
    /// stands there until the daemon ends.
    Kept,
}

impl Refusal {
    pub(crate) fn of(models: &[PathBuf], intent: &Intent, is_asked: bool, revisions: &Revisions) -> Self {
        let is_of_site = revisions.is_without_site() || revisions.models == models;
        match intent {
            Intent::Compare => Self::Told,
            _ if is_asked && !is_of_site => Self::Recorded,
            _ => Self::Kept,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::revision_reader::ReadRevision;
    use daemon::{Asked, Caller, FileStamp, Reporter};
    use messages::{Checked, ContentHash, SiteBuilder, SiteComparison, SiteOutline};
    use std::sync::Arc;

    fn proposal(intent: Intent, objections: &[&str]) -> Proposal {
        let site = Checked::new(SiteBuilder::default().finish()).unwrap();
        let objections = objections.iter().map(|&why| why.to_owned()).collect();
        let revision = ReadRevision {
            models: vec![PathBuf::from("/b.ifc")],
            stamps: vec![None],
            outline: Arc::new(SiteOutline::of(&site.view())),
            site: Arc::new(site),
            comparison: SiteComparison { objections, ..SiteComparison::default() },
            meshes: None,
        };
        let asked = Some(Asked { by: Caller { uid: 7 }, reporter: Reporter::default() });
        Proposal { revision: Arc::new(revision), intent, asked, since_boot_ms: 1_000, refused: None }
    }

    fn said(refused: Option<&str>) -> Option<ScheduleVerdict> {
        Some(ScheduleVerdict { site_hash: ContentHash::default(), refused: refused.map(str::to_owned) })
    }

    /// Of files beside those in force, `waited_ms` after they were proposed.
    fn verdict(proposal: &Proposal, said: Option<ScheduleVerdict>, waited_ms: i64) -> Verdict {
        let revisions = Revisions { models: vec![PathBuf::from("/a.ifc")], ..Revisions::default() };
        verdict_on(proposal, said.as_ref(), &revisions, proposal.since_boot_ms + waited_ms)
    }

    #[test]
    fn a_client_waits_for_the_schedule_so_long_and_changed_files_forever() {
        let asked = proposal(Intent::Force, &[]);
        assert_eq!(verdict(&asked, None, MAX_WAIT_MS - 1), Verdict::Open);
        assert!(matches!(verdict(&asked, None, MAX_WAIT_MS), Verdict::Refused(why) if why.contains("does it run?")));
        let unasked = Proposal { asked: None, ..asked };
        assert_eq!(verdict(&unasked, None, 100 * MAX_WAIT_MS), Verdict::Open);
    }

    #[test]
    fn without_a_schedule_nothing_takes_effect_whoever_forces_it() {
        for intent in [Intent::Compare, Intent::Load, Intent::Force, Intent::Confirm(Vec::new())] {
            let mut proposal = proposal(intent, &[]);
            let Verdict::Refused(why) = verdict(&proposal, said(Some("a loop")), 0) else {
                panic!("it has a schedule")
            };
            assert_eq!(why, "the schedule of b.ifc cannot be used: a loop");
            proposal.refused = Some(why);
            assert_eq!(verdict(&proposal, None, 0), Verdict::StaysRefused);
            assert_eq!(verdict(&proposal, said(Some("a loop")), 0), Verdict::StaysRefused);
            assert!(matches!(verdict(&proposal, said(Some("no calendar")), 0), Verdict::Refused(_)), "it is news");
        }
    }

    #[test]
    fn what_an_operator_has_to_confirm_waits_unless_it_is_of_these_files_that_it_was_confirmed() {
        let check = |intent: Intent, objections: &[&str], expected: Verdict| {
            assert_eq!(verdict(&proposal(intent.clone(), objections), said(None), 0), expected, "{intent:?}");
        };
        let other = Intent::Confirm(vec![messages::ContentId::from_sha256([1; 32])]);
        check(Intent::Load, &[], Verdict::TakesEffect);
        check(Intent::Load, &["another building"], Verdict::WaitsForOperator);
        check(Intent::Force, &["another building"], Verdict::TakesEffect);
        check(Intent::Confirm(Vec::new()), &["another building"], Verdict::TakesEffect);
        check(other, &["another building"], Verdict::WaitsForOperator);
        check(Intent::Compare, &["another building"], Verdict::Compared);

        let again = proposal(Intent::Load, &["another building"]);
        let ReadRevision { models, stamps, .. } = &*again.revision;
        let in_force = Revisions { models: models.clone(), stamps: stamps.clone(), ..Revisions::default() };
        assert_eq!(verdict_on(&again, said(None).as_ref(), &in_force, 0), Verdict::TakesEffect);
    }

    #[test]
    fn a_refusal_is_kept_of_the_sites_files_and_of_those_without_a_request() {
        let of_a = Revisions {
            models: vec![PathBuf::from("/a.ifc")],
            stamps: vec![None::<FileStamp>],
            ..Revisions::default()
        };
        let check = |file: &str, intent: Intent, is_asked: bool, revisions: &Revisions, expected: Refusal| {
            assert_eq!(
                Refusal::of(&[PathBuf::from(file)], &intent, is_asked, revisions),
                expected,
                "{file} {intent:?}"
            );
        };
        check("/a.ifc", Intent::Compare, true, &of_a, Refusal::Told);
        check("/a.ifc", Intent::Load, true, &of_a, Refusal::Kept);
        check("/b.ifc", Intent::Load, true, &of_a, Refusal::Recorded);
        check("/b.ifc", Intent::Load, false, &of_a, Refusal::Kept);
        check("/b.ifc", Intent::Load, true, &Revisions::default(), Refusal::Kept);
    }
}
