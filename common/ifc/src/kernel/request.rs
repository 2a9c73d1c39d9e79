//! Meshes the products of a file, in this process and in another one.

use std::collections::HashSet;

use super::mesh::{Meshed, in_halves, mesh_here};
use super::{File, Patch, task};
use crate::{Isolation, ReadError};

/// Request of meshes.
pub(crate) struct MeshRequest<'r> {
    /// STEP ids of the products.
    pub(crate) products: &'r [u32],
    pub(crate) patch: &'r Patch,
    /// Those of them that are meshed in another process, where there is one.
    pub(crate) unbounded: &'r [u32],
    /// Starts the other process.
    pub(crate) isolation: Option<&'r Isolation<'r>>,
    /// 0: as many as there are cores.
    pub(crate) threads: usize,
    /// Called with products done and in total.
    pub(crate) progress: &'r (dyn Fn(usize, usize) + Sync),
}

/// Meshes the products. The result does not depend on the number of threads.
pub(crate) fn mesh(file: &File<'_>, request: &MeshRequest<'_>) -> Result<Meshed, ReadError> {
    if request.products.is_empty() {
        return Ok(Meshed::default());
    }
    let (bytes, index) = request.patch.apply(file);
    let here = |products: &[u32]| mesh_here(&bytes, &index, products, request.threads, request.progress);
    let Some(isolation) = request.isolation.filter(|_| !request.unbounded.is_empty()) else {
        return here(request.products);
    };
    let there: HashSet<u32> = request.unbounded.iter().copied().collect();
    let bounded: Vec<u32> = request.products.iter().copied().filter(|product| !there.contains(product)).collect();
    let mut meshed = here(&bounded)?;
    meshed.append(in_halves(request.unbounded, |products| task::mesh_there(&bytes, products, isolation)));
    Ok(meshed)
}
