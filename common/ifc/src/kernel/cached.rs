//! Meshes products of which an earlier reading made none that are the same.
//!
//! An entry is kept for a product of which the kernel says nothing bad, in the frame in which it was meshed. What may be given up
//! in another process is kept only where nothing was: how much a file may take there counts all of its products.

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

use super::content_keys::{ContentKey, ContentKeys};
use super::mesh::{ItemMesh, Meshed, faces, frame_of};
use super::request::{MeshRequest, mesh_all};
use super::{File, MeshPool};
use crate::mesh_cache::MeshCache;
use crate::{MeshPart, ReadError};

/// What the kernel made of a product.
#[derive(Serialize, Deserialize)]
struct Entry {
    frame: u128,
    /// Meshes, each with the place of its item among those of the product, if it is known.
    meshes: Vec<(Option<u32>, MeshPart)>,
}

/// Meshes the products of a request, those that an earlier reading knew from its cache.
///
/// # Errors
/// The machine has no threads to give.
pub(crate) fn mesh(file: &File<'_>, request: &MeshRequest<'_>) -> Result<Meshed, ReadError> {
    if request.products.is_empty() {
        return Ok(Meshed::default());
    }
    let own;
    let pool = match request.pool {
        Some(pool) => pool,
        None => {
            own = MeshPool::new(rayon::current_num_threads())?;
            &own
        }
    };
    Ok(match request.cache {
        Some(cache) => mesh_cached(file, request, pool, cache),
        None => mesh_all(file, request, pool),
    })
}

fn mesh_cached(file: &File<'_>, request: &MeshRequest<'_>, pool: &MeshPool, cache: &MeshCache) -> Meshed {
    let Some(keys) = pool.install(|| keys_of(file, request)) else { return mesh_all(file, request, pool) };
    let (known, mut unknown): (Vec<u32>, Vec<u32>) =
        request.products.iter().partition(|id| keys.get(id).is_some_and(|key| cache.has(key.key)));
    let mut meshed = mesh_some(file, request, &unknown, pool);
    let frame = match meshed.frame {
        None if !known.is_empty() => frame_of(&request.patch.apply(file), pool),
        frame => frame,
    };
    let take = |id: &u32| -> Option<Vec<ItemMesh>> {
        let key = keys.get(id)?;
        let entry: Entry = cache.take(key.key, |entry: &Entry| Some(entry.frame) == frame)?;
        let of = |(place, part)| Some(ItemMesh { item: place_to_item(place, &key.items)?, part });
        entry.meshes.into_iter().map(of).collect()
    };
    let found: Vec<(u32, Option<Vec<ItemMesh>>)> =
        pool.install(|| known.par_iter().map(|id| (*id, take(id))).collect());
    let mut others = Vec::new();
    for (id, meshes) in found {
        match meshes {
            Some(meshes) if meshes.is_empty() => {}
            Some(meshes) => _ = meshed.meshes.insert(id, meshes),
            None => others.push(id),
        }
    }
    if !others.is_empty() {
        meshed.append(mesh_some(file, request, &others, pool));
        unknown.append(&mut others);
    }
    let is_apart: BTreeSet<u32> = request.unbounded.iter().chain(request.costly).copied().collect();
    if !meshed.given_up.is_empty() && known.iter().any(|id| is_apart.contains(id)) {
        let again: Vec<u32> = request.products.iter().copied().filter(|id| is_apart.contains(id)).collect();
        for id in &again {
            meshed.forget(*id);
        }
        meshed.append(mesh_some(file, request, &again, pool));
        unknown.extend(again);
        unknown.sort_unstable();
        unknown.dedup();
    }
    let is_complete = meshed.given_up.is_empty();
    let doubtful = doubtful(&meshed);
    pool.install(|| {
        unknown.par_iter().for_each(|id| {
            let is_kept = !meshed.complaints.contains_key(id)
                && !meshed.given_up.contains(id)
                && (is_complete || !is_apart.contains(id))
                && !meshed.meshes.get(id).is_some_and(|meshes| doubtful.contains(&faces(meshes)));
            let entry = keys.get(id).filter(|_| is_kept).and_then(|key| {
                let meshes = meshed.meshes.get(id).map_or(&[][..], Vec::as_slice);
                Some((key.key, entry_of(meshed.frame.or(frame)?, meshes, &key.items)?))
            });
            match entry {
                Some((key, entry)) => cache.put(Some(key), &entry),
                None => cache.put::<Entry>(None, &Entry { frame: 0, meshes: Vec::new() }),
            }
        });
    });
    meshed
}

/// Keys of the products that may be kept.
fn keys_of(file: &File<'_>, request: &MeshRequest<'_>) -> Option<FxHashMap<u32, ContentKey>> {
    let keys = ContentKeys::of(file, request.patch)?;
    let costly: BTreeSet<u32> = request.costly.iter().copied().collect();
    let products = request.products.par_iter().filter(|id| !costly.contains(id));
    Some(products.filter_map(|id| Some((*id, keys.of_product(*id)?))).collect())
}

/// Meshes some of the products of a request.
fn mesh_some(file: &File<'_>, request: &MeshRequest<'_>, products: &[u32], pool: &MeshPool) -> Meshed {
    let asked: BTreeSet<u32> = products.iter().copied().collect();
    let of = |list: &[u32]| -> Vec<u32> { list.iter().copied().filter(|id| asked.contains(id)).collect() };
    let n_known = request.products.len() - products.len();
    let progress = |done: usize, _: usize, left: Option<u32>| {
        (request.progress)(n_known + done, request.products.len(), left);
    };
    let (unbounded, costly, detailed) = (of(request.unbounded), of(request.costly), of(request.detailed));
    let request = MeshRequest {
        products,
        unbounded: &unbounded,
        costly: &costly,
        detailed: &detailed,
        progress: &progress,
        ..*request
    };
    mesh_all(file, &request, pool)
}

/// Shapes of which the kernel blames one product: which one of those of a shape depends on its threads.
fn doubtful(meshed: &Meshed) -> BTreeSet<Vec<&[[u32; 3]]>> {
    meshed.complaints.keys().filter_map(|id| Some(faces(meshed.meshes.get(id)?))).collect()
}

/// `None` if the item of a mesh is not among those of the product.
fn entry_of(frame: u128, meshes: &[ItemMesh], items: &[u32]) -> Option<Entry> {
    let places: BTreeMap<u32, u32> = items.iter().copied().zip(0..).collect();
    let of = |mesh: &ItemMesh| {
        let place = match mesh.item {
            Some(item) => Some(*places.get(&item)?),
            None => None,
        };
        Some((place, mesh.part.clone()))
    };
    Some(Entry { frame, meshes: meshes.iter().map(of).collect::<Option<_>>()? })
}

/// `None` if there is no item at this place.
#[expect(clippy::option_option, reason = "the kernel does not know the item of every mesh")]
fn place_to_item(place: Option<u32>, items: &[u32]) -> Option<Option<u32>> {
    match place {
        Some(place) => items.get(place as usize).map(|item| Some(*item)),
        None => Some(None),
    }
}
