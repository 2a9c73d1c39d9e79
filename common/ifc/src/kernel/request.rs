//! Meshes the products of a file, in this process and in another one.

use rustc_hash::FxHashSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::mesh::{Meshed, mesh_here};
use super::task::{Answer, mesh_there};
use super::{File, MeshPool, Patch};
use crate::Isolation;
use crate::mesh_cache::MeshCache;

/// Products that the other process meshes at a time, until one of them ends it: then one by one.
const BATCH: usize = 8;

/// Products of a list that may end the other process. Each takes it the time that it is allowed, so the others of the list are
/// given up.
const GIVEN_UP_MAX: usize = 6;

/// CPU time for all costly products of a file.
const COSTLY_CPU_S: f64 = 60.0;

/// Request of meshes.
pub(crate) struct MeshRequest<'r> {
    /// STEP ids of the products.
    pub(crate) products: &'r [u32],
    /// Those of them of which nothing bounds what they need; they are meshed in another process, where there is one.
    pub(crate) unbounded: &'r [u32],
    /// Others that may take long; they are meshed there as well.
    pub(crate) costly: &'r [u32],
    /// Starts the other process.
    pub(crate) isolation: Option<&'r Isolation<'r>>,
    pub(crate) patch: &'r Patch,
    /// Where this process meshes; without one a pool of its own is made.
    pub(crate) pool: Option<&'r MeshPool>,
    /// Meshes of an earlier reading.
    pub(crate) cache: Option<&'r MeshCache>,
    /// The products again, the most detailed first.
    pub(crate) detailed: &'r [u32],
    /// Called with products done and in total, and the product that is meshed apart, or the first of the detailed ones that is
    /// not done.
    pub(crate) progress: &'r (dyn Fn(usize, usize, Option<u32>) + Sync),
}

/// Meshes the products without a cache. The result does not depend on the number of threads.
pub(super) fn mesh_all(file: &File<'_>, request: &MeshRequest<'_>, pool: &MeshPool) -> Meshed {
    if request.products.is_empty() {
        return Meshed::default();
    }
    let bytes = request.patch.apply(file);
    let total = request.products.len();
    // What is meshed stays so: the next search goes on where this one ends.
    let n_meshed = AtomicUsize::new(0);
    let progress = |done: usize, meshed: &Meshed| {
        let detailed = request.detailed.iter().enumerate().skip(n_meshed.load(Ordering::Relaxed));
        let left = detailed.into_iter().find(|(_, id)| !meshed.meshes.contains_key(id));
        n_meshed.store(left.map_or(request.detailed.len(), |(place, _)| place), Ordering::Relaxed);
        (request.progress)(done, total, left.map(|(_, id)| *id));
    };
    progress(0, &Meshed::default());
    let Some(isolation) = request.isolation else { return mesh_here(&bytes, request.products, pool, &progress) };
    let lists = [(request.unbounded, None), (request.costly, Some(COSTLY_CPU_S))];
    let apart: FxHashSet<u32> = lists.into_iter().flat_map(|(list, _)| list).copied().collect();
    let here: Vec<u32> = request.products.iter().copied().filter(|product| !apart.contains(product)).collect();
    let mut meshed = mesh_here(&bytes, &here, pool, &progress);
    let mut n_done = here.len();
    for (list, max_cpu_s) in lists {
        let mut in_order = list.to_vec();
        in_order.sort_unstable_by_key(|product| file.index.range_of(*product));
        let progress = |n_apart: usize, next: Option<u32>| (request.progress)(n_done + n_apart, total, next);
        meshed.append(mesh_apart(&bytes, in_order, max_cpu_s, isolation, &progress));
        n_done += list.len();
    }
    meshed
}

/// Meshes products, which are in the order of their records, in the other process. One that ends it is found by meshing one by
/// one, and is given up; so are all that are left when there were too many of them, or the CPU time is spent. `progress` is
/// called with the number of those that are done and the one that is next.
fn mesh_apart(
    bytes: &[u8],
    mut left: Vec<u32>,
    max_cpu_s: Option<f64>,
    isolation: &Isolation<'_>,
    progress: &dyn Fn(usize, Option<u32>),
) -> Meshed {
    let (total, mut meshed, mut batch, mut spent_s) = (left.len(), Meshed::default(), BATCH, 0.0);
    while let Some(&first) = left.first() {
        progress(total - left.len(), Some(first));
        // What ended the process is in the batch that was not answered.
        let asked: Vec<u32> = if batch == 1 { left.iter().copied().take(BATCH).collect() } else { left.clone() };
        let mut n_done = 0;
        let allowed_s = max_cpu_s.map(|max_cpu_s| max_cpu_s - spent_s);
        let (cpu_s, end) =
            mesh_there(bytes, &asked, batch, allowed_s, isolation, |Answer { products, meshed: done }| {
                n_done += products.len();
                meshed.append(done);
                progress(total - left.len() + n_done, asked.get(n_done).copied());
            });
        left.drain(..n_done.min(left.len()));
        spent_s += cpu_s;
        if n_done >= asked.len() {
            batch = BATCH;
        } else if batch > 1 && asked.len() > n_done + 1 {
            batch = 1;
        } else {
            let why = end.err().unwrap_or_else(|| "its process does not answer".to_owned());
            meshed.give_up(left.remove(0), why);
        }
        let is_spent = max_cpu_s.filter(|max_cpu_s| spent_s >= *max_cpu_s);
        let why =
            is_spent.map(|max_cpu_s| format!("such elements of the file have taken {max_cpu_s:.0} s of CPU time"));
        let too_many = || format!("{GIVEN_UP_MAX} others of the file have ended the kernel's process before");
        if let Some(why) = why.or_else(|| (meshed.given_up.len() >= GIVEN_UP_MAX).then(too_many)) {
            left.drain(..).for_each(|product| meshed.give_up(product, why.clone()));
        }
    }
    progress(total, None);
    meshed
}
