//! Threads with stacks that are deep enough for the kernel.

use ifc_lite_processing::geometry_pool_builder;
use rayon::ThreadPool;

use crate::ReadError;

/// Threads on which bodies can be meshed. Deep booleans need deep stacks, and a stack that overflows ends the process.
///
/// What comes after reading is best done on the same threads: it takes the memory that meshing has freed.
#[derive(Debug)]
pub struct MeshPool(ThreadPool);

impl MeshPool {
    /// So many threads; 0: as many as there are cores.
    ///
    /// # Errors
    /// The machine refuses the threads.
    pub fn new(threads: usize) -> Result<Self, ReadError> {
        let builder = geometry_pool_builder().num_threads(threads).thread_name(|k| format!("worker-{k}"));
        builder.build().map(Self).map_err(ReadError::Threads)
    }

    /// Works on one of the threads, with all of them for parallel work.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.0.install(work)
    }
}
