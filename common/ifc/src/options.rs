//! Options and progress of reading a file.

use crate::{MeshCache, MeshPool};
use diagnostics::Named;

/// Runs a task for [`mesh_task`](crate::mesh_task) in another process: takes the parts of its bytes and the CPU time in seconds
/// that it may take in all, and hands on the bytes of its answers as they come, in pieces of any length. Gives the CPU time that
/// it took, and why there are no more answers where it ended too early. What an answer may take is for the process to limit.
pub type Isolation<'a> = dyn Fn(&[&[u8]], Option<f64>, &mut dyn FnMut(&[u8])) -> (f64, Result<(), String>) + Sync + 'a;

/// Options of reading. They change the result only where [`ReadOptions::isolation`] has to give up.
#[derive(Clone, Copy, Default)]
pub struct ReadOptions<'a> {
    /// Threads for meshing; `None`: a pool of its own for each file, with as many threads as the caller's has.
    pub pool: Option<&'a MeshPool>,
    /// Called as work advances, from any thread.
    pub progress: Option<&'a (dyn Fn(Progress<'_>) + Sync)>,
    /// Meshes in another process those bodies of which nothing bounds what the kernel may need, and those that are costly to cut;
    /// `None`: in this one.
    pub isolation: Option<&'a Isolation<'a>>,
    /// Meshes of an earlier reading, which takes those of this one.
    pub cache: Option<&'a MeshCache>,
}

impl ReadOptions<'_> {
    /// Calls the progress function, if there is one.
    pub(crate) fn report(&self, progress: Progress<'_>) {
        if let Some(report) = self.progress {
            report(progress);
        }
    }
}

/// Progress of reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress<'a> {
    /// Stage of the work.
    pub stage: Stage,
    /// Steps done in this stage.
    pub done: usize,
    /// Steps of this stage.
    pub total: usize,
    /// The product that is meshed in another process now, else the most detailed one that is not meshed yet: what it waits for,
    /// where it waits.
    pub waits_for: Option<&'a Named>,
}

/// Stage of the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Records and relations; one step.
    Reading,
    /// Meshes; one step per product.
    Meshing,
}
