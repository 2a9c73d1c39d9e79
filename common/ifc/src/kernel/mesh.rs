//! Meshes of products.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use ifc_lite_core::IfcType;
use ifc_lite_processing::{
    Batching, Features, FrameEvent, MeshData, MeshFrame, ProcessingRequest, ProcessingSink, ProductGeometryAudit,
    TessellationQuality, default_color_for_type, process,
};

use super::MeshPool;
use crate::MeshPart;
use xxhash_rust::xxh3::xxh3_128;

/// A mesh and the representation item it comes from, where the kernel knows it.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct ItemMesh {
    pub(crate) item: Option<u32>,
    pub(crate) part: MeshPart,
}

/// Meshes and complaints by product.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Meshed {
    pub(crate) meshes: BTreeMap<u32, Vec<ItemMesh>>,
    /// Complaints of the kernel about a product.
    pub(crate) complaints: BTreeMap<u32, String>,
    /// Products of which the other process made nothing, or that it was not given any more.
    pub(crate) given_up: BTreeSet<u32>,
    /// Hash of the frame in which the kernel has meshed: vertices are rounded in it.
    pub(super) frame: Option<u128>,
}

/// Called with products done, and what there is of them.
pub(super) type MeshProgress<'p> = dyn Fn(usize, &Meshed) + Sync + 'p;

/// Jobs per chunk: enough for all cores, few enough that a chunk's meshes do not fill the memory.
const CHUNK: usize = 64;

/// Meshes products in this process.
pub(super) fn mesh_here(bytes: &[u8], products: &[u32], pool: &MeshPool, progress: &MeshProgress<'_>) -> Meshed {
    if products.is_empty() {
        return Meshed::default();
    }
    let pass = |products: &[u32]| {
        let pass = AssertUnwindSafe(|| pool.install(|| pass(bytes, products, progress)));
        catch_unwind(pass).map_err(|_| "the kernel panicked".to_owned())
    };
    in_halves(products, pass)
}

impl Meshed {
    pub(crate) fn append(&mut self, mut other: Self) {
        self.meshes.append(&mut other.meshes);
        self.complaints.append(&mut other.complaints);
        self.given_up.append(&mut other.given_up);
        self.frame = self.frame.or(other.frame);
    }

    /// Puts what was made of products in a second try in the place of what the first one made. Those that failed again keep the
    /// complaint of the first.
    pub(crate) fn replace(&mut self, mut again: Self) {
        for product in again.meshes.keys() {
            self.given_up.remove(product);
            self.complaints.remove(product);
        }
        again.complaints.retain(|product, _| !again.given_up.contains(product));
        self.append(again);
    }

    /// Forgets what was made of a product.
    pub(crate) fn forget(&mut self, product: u32) {
        self.meshes.remove(&product);
        self.complaints.remove(&product);
        self.given_up.remove(&product);
    }

    pub(super) fn give_up(&mut self, product: u32, why: String) {
        self.complaints.insert(product, why);
        self.given_up.insert(product);
    }

    fn complain(&mut self, products: &[u32], audit: &ProductGeometryAudit) {
        for &product in products {
            if let Err(complaint) = audit.require_complete(product) {
                self.complaints.insert(product, complaint);
            }
        }
    }
}

/// Meshes all at once; where that fails, by halves until the products that fail stand alone.
fn in_halves(products: &[u32], pass: impl Fn(&[u32]) -> Result<Meshed, String>) -> Meshed {
    let mut meshed = Meshed::default();
    let mut waiting = vec![products];
    while let Some(products) = waiting.pop() {
        match (pass(products), products) {
            (Ok(done), _) => meshed.append(done),
            (Err(why), &[product]) => {
                meshed.complaints.insert(product, why);
            }
            (Err(_), _) => {
                let (first, second) = products.split_at(products.len() / 2);
                waiting.extend([second, first]);
            }
        }
    }
    meshed
}

fn pass(bytes: &[u8], products: &[u32], progress: &MeshProgress<'_>) -> Meshed {
    let mut sink = Sink::new(|sink: &mut Progress| progress(sink.n_jobs, &sink.meshed));
    process(bytes, &request(products, CHUNK), &mut sink);
    let Progress { mut meshed, audit, .. } = sink.progress;
    meshed.complain(products, &audit);
    meshed
}

/// Meshes products that are in the order of their records, so many at a time. What is done is given to `take` after each batch,
/// and nothing once the file is read.
pub(super) fn mesh_in_batches(
    bytes: &[u8],
    products: &[u32],
    batch: usize,
    take: &mut (dyn FnMut(&[u32], Meshed) + Send),
) {
    let (mut left, mut n_jobs) = (products, 0);
    let mut sink = Sink::new(|progress: &mut Progress| {
        let (done, rest) = left.split_at(n_done(left, progress.n_jobs - n_jobs, &progress.audit));
        (left, n_jobs) = (rest, progress.n_jobs);
        let mut meshed = std::mem::take(&mut progress.meshed);
        meshed.complain(done, &progress.audit);
        take(done, meshed);
    });
    process(bytes, &request(products, batch), &mut sink);
    let Progress { mut meshed, audit, .. } = sink.progress;
    meshed.complain(left, &audit);
    take(left, meshed);
}

/// Products that are done of those that are left, after so many more jobs: all up to the last that has been. The kernel works
/// in the order of the records, and some products are no job of it.
fn n_done(left: &[u32], n_more_jobs: usize, audit: &ProductGeometryAudit) -> usize {
    let has_been = |product: u32| audit.require_complete(product).err().is_none_or(|why| !why.contains(NO_RECEIPT));
    let jobs = left.iter().enumerate().filter(|(_, product)| has_been(**product));
    jobs.take(n_more_jobs).last().map_or(0, |(place, _)| place + 1)
}

/// Complaint of the kernel about a product that it has not tried.
const NO_RECEIPT: &str = "no completed processing receipt";

fn request(products: &[u32], batch: usize) -> ProcessingRequest {
    let features = Features::default()
        .properties(false)
        .presentation_layers(false)
        .quick_metadata_bootstrap(false)
        .finishes(false);
    let wanted: HashSet<u32> = products.iter().copied().collect();
    let mut request = ProcessingRequest::default()
        .batching(Batching::new(batch, batch))
        .retain_meshes(false)
        .features(features)
        .ids(Some(Arc::new(wanted)));
    request.quality = TessellationQuality::Medium;
    request
}

/// What a pass has done.
#[derive(Default)]
struct Progress {
    meshed: Meshed,
    n_jobs: usize,
    audit: ProductGeometryAudit,
}

/// Collects meshes, and calls `step` when the file is read and after each batch.
struct Sink<F> {
    frame: Option<MeshFrame>,
    progress: Progress,
    step: F,
}

impl<F: FnMut(&mut Progress)> Sink<F> {
    fn new(step: F) -> Self {
        Self { frame: None, progress: Progress::default(), step }
    }
}

impl<F: FnMut(&mut Progress)> ProcessingSink for Sink<F> {
    fn product_geometry_audit(&self) -> Option<ProductGeometryAudit> {
        Some(self.progress.audit.clone())
    }

    fn on_frame(&mut self, event: &FrameEvent) {
        self.frame = Some(event.frame);
        self.progress.meshed.frame = Some(hash_of(event.frame));
        (self.step)(&mut self.progress);
    }

    fn on_batch(&mut self, meshes: &[MeshData], processed: usize, _: usize) {
        let Some(frame) = self.frame else { return };
        // 1 and 2 are shapes of types, which their occurrences draw.
        let drawn = meshes.par_iter().filter(|m| !matches!(m.geometry_class, 1 | 2));
        let of = |mesh: &MeshData| (mesh.express_id, ItemMesh { item: mesh.geometry_item_id, part: part(mesh, frame) });
        let parts: Vec<(u32, ItemMesh)> = drawn.map(of).collect();
        for (product, mesh) in parts {
            self.progress.meshed.meshes.entry(product).or_default().push(mesh);
        }
        self.progress.n_jobs = processed;
        (self.step)(&mut self.progress);
    }
}

/// Triangles of all meshes: equal for equal shapes, wherever they stand.
pub(crate) fn faces(meshes: &[ItemMesh]) -> Vec<&[[u32; 3]]> {
    meshes.iter().map(|mesh| mesh.part.triangles.as_slice()).collect()
}

/// The frame in which the kernel meshes products of a file.
pub(super) fn frame_of(bytes: &[u8], pool: &MeshPool) -> Option<u128> {
    let pass = AssertUnwindSafe(|| pool.install(|| pass(bytes, &[], &|_, _| {})));
    catch_unwind(pass).ok()?.frame
}

fn hash_of(frame: MeshFrame) -> u128 {
    let (x, y, z) = frame.rtc_offset();
    let placement = frame.site_placement();
    let numbers = [x, y, z].into_iter().chain(placement.into_iter().flatten());
    let mut written = format!("{:?}", frame.coordinate_space()).into_bytes();
    numbers.for_each(|number: f64| written.extend_from_slice(&number.to_le_bytes()));
    xxh3_128(&written)
}

/// The mesh in the world. Rotations are applied in f64; the origin stays apart, so that nothing is lost far out.
fn part(mesh: &MeshData, frame: MeshFrame) -> MeshPart {
    let origin_m = frame.to_world(mesh.origin);
    let (positions, _) = mesh.positions.as_chunks::<3>();
    let (triangles, _) = mesh.indices.as_chunks::<3>();
    let (mut positions_m, triangles) = welded(positions, triangles);
    let diagonal = [1.0, 2.0, 3.0];
    if frame.rotate_out_of_frame(diagonal) != diagonal {
        for p in &mut positions_m {
            *p = frame.rotate_out_of_frame(p.map(f64::from)).map(|v| v as f32);
        }
    }
    MeshPart { origin_m, positions_m, triangles, colour: colour(mesh) }
}

/// The mesh with one vertex per position, in the order in which triangles name them: the kernel has one per face and corner,
/// for normals that nobody reads here.
fn welded(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    const NOT_MET: u32 = u32::MAX;
    let mut kept: Vec<[f32; 3]> = Vec::new();
    let mut by_position: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    let mut new_index = vec![NOT_MET; positions.len()];
    let mut index_of = |old: u32| {
        // An index that points nowhere is refused later, with the product's name.
        let Some(position) = positions.get(old as usize) else { return NOT_MET };
        let index = &mut new_index[old as usize];
        if *index == NOT_MET {
            // The zeros of both signs are one place.
            *index = *by_position.entry(position.map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                kept.push(*position);
                kept.len() as u32 - 1
            });
        }
        *index
    };
    let triangles = triangles.iter().map(|t| t.map(&mut index_of)).collect();
    kept.shrink_to_fit();
    (kept, triangles)
}

/// The colour that the file gives; where it gives none the kernel takes one for the kind of element.
fn colour(mesh: &MeshData) -> Option<[u8; 4]> {
    let stands_in = default_color_for_type(IfcType::from_str(&mesh.ifc_type)).to_array();
    (mesh.color != stands_in).then(|| mesh.color.map(|c| (c * 255.0).round() as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_at_one_place_are_one_vertex_and_what_no_triangle_names_is_left_out() {
        let a = [
            [0.0, 0.0, 0.0],
            [9.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [-0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
        ];
        let (positions, triangles) = welded(&a, &[[0, 2, 3], [4, 6, 5], [0, 2, 77]]);
        assert_eq!(positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
        assert_eq!(triangles, [[0, 1, 2], [1, 3, 2], [0, 1, u32::MAX]]);
    }

    #[test]
    fn a_product_that_makes_the_kernel_fail_is_reported_and_the_others_are_meshed() {
        let pass = |products: &[u32]| {
            let fails = products.contains(&3) || products.contains(&7);
            let meshes = products.iter().map(|&id| (id, Vec::new())).collect();
            if fails { Err("it fails".to_owned()) } else { Ok(Meshed { meshes, ..Meshed::default() }) }
        };
        let meshed = in_halves(&[1, 2, 3, 4, 5, 6, 7], pass);
        assert_eq!(meshed.meshes.into_keys().collect::<Vec<u32>>(), [1, 2, 4, 5, 6]);
        assert_eq!(meshed.complaints.into_keys().collect::<Vec<u32>>(), [3, 7]);
    }
}
