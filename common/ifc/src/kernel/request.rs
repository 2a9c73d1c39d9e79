//! Meshes the products of a file, in this process and in another one.

use rustc_hash::FxHashSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::mesh::{Meshed, in_halves, mesh_here};
use super::{File, MeshPool, Patch, task};
use crate::{Isolation, ReadError};

/// Request of meshes.
pub(crate) struct MeshRequest<'r> {
    /// STEP ids of the products.
    pub(crate) products: &'r [u32],
    /// Those of them that are meshed in another process, where there is one.
    pub(crate) unbounded: &'r [u32],
    /// Starts the other process.
    pub(crate) isolation: Option<&'r Isolation<'r>>,
    pub(crate) patch: &'r Patch,
    /// Where this process meshes; without one a pool of its own is made.
    pub(crate) pool: Option<&'r MeshPool>,
    /// The products again, the most detailed first.
    pub(crate) detailed: &'r [u32],
    /// Called with products done and in total, and the first of the detailed ones that is not done.
    pub(crate) progress: &'r (dyn Fn(usize, usize, Option<u32>) + Sync),
}

/// Meshes the products. The result does not depend on the number of threads.
pub(crate) fn mesh(file: &File<'_>, request: &MeshRequest<'_>) -> Result<Meshed, ReadError> {
    if request.products.is_empty() {
        return Ok(Meshed::default());
    }
    Ok(match request.pool {
        Some(pool) => mesh_on(pool, file, request),
        None => mesh_on(&MeshPool::new(rayon::current_num_threads())?, file, request),
    })
}

fn mesh_on(pool: &MeshPool, file: &File<'_>, request: &MeshRequest<'_>) -> Meshed {
    let bytes = request.patch.apply(file);
    // What is meshed stays so: the next search goes on where this one ends.
    let n_meshed = AtomicUsize::new(0);
    let progress = |done: usize, meshed: &Meshed| {
        let detailed = request.detailed.iter().enumerate().skip(n_meshed.load(Ordering::Relaxed));
        let left = detailed.into_iter().find(|(_, id)| !meshed.meshes.contains_key(id));
        n_meshed.store(left.map_or(request.detailed.len(), |(place, _)| place), Ordering::Relaxed);
        (request.progress)(done, request.products.len(), left.map(|(_, id)| *id));
    };
    progress(0, &Meshed::default());
    let here = |products: &[u32]| mesh_here(&bytes, products, pool, &progress);
    let Some(isolation) = request.isolation.filter(|_| !request.unbounded.is_empty()) else {
        return here(request.products);
    };
    let there: FxHashSet<u32> = request.unbounded.iter().copied().collect();
    let bounded: Vec<u32> = request.products.iter().copied().filter(|product| !there.contains(product)).collect();
    let mut meshed = here(&bounded);
    progress(bounded.len(), &meshed);
    meshed.append(in_halves(request.unbounded, |products| task::mesh_there(&bytes, products, isolation)));
    meshed
}
