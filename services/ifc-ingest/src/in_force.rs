//! The state in force of ifc-ingest: revisions of the site, their reader, and the outline that they are compared with.

use crate::model_files::names_of;
use crate::proposal::{Intent, Proposal};
use crate::revision_reader::RevisionReader;
use crate::revision_verdict::Refusal;
use crate::revisions::{Refused, Revisions};
use daemon::facts::MeshFacts;
use daemon::{Failure, FileStamp, FileWatch, MachineTime, SiteConfig};
use ingest::SiteFrame;
use messages::{Checked, SiteOutline, payload};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Waits before a revision that found no room on disk or in shared memory is tried again.
const MIN_WAIT: Duration = Duration::from_secs(10);
const MAX_WAIT: Duration = Duration::from_secs(600);

/// What a decision changes.
#[derive(Clone)]
pub struct InForce {
    pub(crate) reader: Arc<RevisionReader>,
    pub(crate) revisions: Revisions,
    /// Of the site in force.
    pub(crate) outline: Option<Arc<SiteOutline>>,
    /// Files that changed, until they are whole.
    pub(crate) watch: FileWatch,
    /// Files to be read as soon as the daemon is attached: the configuration names others.
    pub(crate) to_read: Option<Vec<PathBuf>>,
    /// Why the configuration, or the map frame, cannot be used.
    pub(crate) error: Option<String>,
    /// When a revision that found no room on disk is tried again, and how long that waited.
    pub(crate) next_try: Option<NextTry>,
    /// Meshes of the files that were read last.
    pub(crate) meshes: Option<MeshFacts>,
    /// The files that this decision has read.
    pub(crate) read: Option<ReadFiles>,
    /// A revision that is on the bus as a candidate until schedule-eval has judged it.
    pub(crate) proposal: Option<Proposal>,
}

/// Files that were read for a decision.
#[derive(Debug, Clone)]
pub(crate) struct ReadFiles {
    pub(crate) models: Vec<PathBuf>,
    /// What they looked like.
    pub(crate) stamps: Vec<Option<FileStamp>>,
    pub(crate) intent: Intent,
    /// True if a client asked for it.
    pub(crate) is_asked: bool,
}

/// When something is tried again.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NextTry {
    /// By the machine's count since its boot, in milliseconds.
    at_ms: i64,
    waited: Duration,
}

impl NextTry {
    /// True if it is time.
    pub(crate) fn is_due(&self, now: MachineTime) -> bool {
        self.at_ms <= now.since_boot_ms
    }

    /// The first try after a failure, or the one after another: twice as late.
    fn after(last: Option<Self>, now: MachineTime) -> Self {
        let waited = last.map_or(MIN_WAIT, |last| (last.waited * 2).min(MAX_WAIT));
        let wait_ms = i64::try_from(waited.as_millis()).unwrap_or(i64::MAX);
        Self { at_ms: now.since_boot_ms.saturating_add(wait_ms), waited }
    }
}

impl InForce {
    /// Files that the configuration names since it was edited are to be read; what was loaded by a command counts until then.
    pub(crate) fn follow_configured_models(&mut self, config: &SiteConfig) {
        let before = std::mem::replace(&mut self.revisions.configured, config.models.clone());
        if before != config.models && config.models != self.revisions.models && !config.models.is_empty() {
            self.to_read = Some(config.models.clone());
        }
    }

    /// Takes why a revision cannot take effect; the error for who asked, and what the history says of it.
    pub(crate) fn refuse(&mut self, refused: Refused, refusal: Refusal) -> (Failure, Option<String>) {
        let told = format!("{} refused: {}", names_of(&refused.models), refused.why);
        if refusal != Refusal::Kept {
            return (self.revisions.stays(&refused.why).into(), Some(told));
        }
        self.revisions.see(&refused.models, &refused.stamps);
        let is_news = !self.revisions.refused.as_ref().is_some_and(|before| before.is_same(&refused));
        self.revisions.refused = Some(refused);
        (self.revisions.standing().error.unwrap_or_default().into(), is_news.then_some(told))
    }

    /// A decision that has read files could not be committed: what it found stands without being kept, and files that were to take effect
    /// are tried again, but not at once. Files that were only to be compared, and others than those of the site, are forgotten.
    pub(crate) fn not_committed(&mut self, decided: Self, why: &str, now: MachineTime) {
        let Some(ReadFiles { models, stamps, intent, is_asked }) = decided.read else { return };
        self.to_read = self.to_read.take().filter(|to_read| *to_read != models);
        self.proposal = self.proposal.take().filter(|proposal| proposal.revision.models != models);
        if decided.revisions.refused.as_ref().is_some_and(|refused| refused.models == models) {
            (self.revisions.refused, self.revisions.seen) = (decided.revisions.refused, decided.revisions.seen);
            return;
        }
        if Refusal::of(&models, &intent, is_asked, &self.revisions) == Refusal::Kept {
            self.next_try = Some(NextTry::after(self.next_try, now));
            self.refuse(Refused { models, stamps, why: why.to_owned() }, Refusal::Kept);
        }
    }
}

/// The map frame of a site.
pub(crate) fn frame_of(site: &Checked<payload::Site>) -> SiteFrame {
    let site = site.view();
    SiteFrame { map_from_world: site.map_from_world(), frame_epoch: site.head.frame_epoch }
}

pub(crate) fn is_same_frame(one: &SiteFrame, other: &SiteFrame) -> bool {
    let motion = |frame: &SiteFrame| (frame.map_from_world.translation_m(), frame.map_from_world.yaw_rad());
    one.frame_epoch == other.frame_epoch && motion(one) == motion(other)
}
