//! Meshes of products.

use std::collections::{BTreeMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use ifc_lite_core::IfcType;
use ifc_lite_processing::{
    Batching, Features, FrameEvent, MeshData, MeshFrame, ProcessingRequest, ProcessingSink, ProductGeometryAudit,
    TessellationQuality, default_color_for_type, process,
};

use super::MeshPool;
use crate::MeshPart;

/// A mesh and the representation item it comes from, where the kernel knows it.
#[derive(Serialize, Deserialize)]
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
    }
}

/// Meshes all at once; where that fails, by halves until the products that fail stand alone.
pub(super) fn in_halves(products: &[u32], pass: impl Fn(&[u32]) -> Result<Meshed, String>) -> Meshed {
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
    let features = Features::default()
        .properties(false)
        .presentation_layers(false)
        .quick_metadata_bootstrap(false)
        .finishes(false);
    let wanted: HashSet<u32> = products.iter().copied().collect();
    let mut request = ProcessingRequest::default()
        .batching(Batching::new(CHUNK, CHUNK))
        .retain_meshes(false)
        .features(features)
        .ids(Some(Arc::new(wanted)));
    request.quality = TessellationQuality::Medium;
    let audit = ProductGeometryAudit::default();
    let mut sink = Sink { frame: None, meshed: Meshed::default(), audit: audit.clone(), progress };
    process(bytes, &request, &mut sink);
    let mut meshed = sink.meshed;
    for &product in products {
        if let Err(complaint) = audit.require_complete(product) {
            meshed.complaints.insert(product, complaint);
        }
    }
    meshed
}

struct Sink<'p> {
    frame: Option<MeshFrame>,
    meshed: Meshed,
    audit: ProductGeometryAudit,
    progress: &'p MeshProgress<'p>,
}

impl ProcessingSink for Sink<'_> {
    fn product_geometry_audit(&self) -> Option<ProductGeometryAudit> {
        Some(self.audit.clone())
    }

    fn on_frame(&mut self, event: &FrameEvent) {
        self.frame = Some(event.frame);
    }

    fn on_batch(&mut self, meshes: &[MeshData], processed: usize, _: usize) {
        let Some(frame) = self.frame else { return };
        // 1 and 2 are shapes of types, which their occurrences draw.
        for mesh in meshes.iter().filter(|m| !matches!(m.geometry_class, 1 | 2)) {
            let item_mesh = ItemMesh { item: mesh.geometry_item_id, part: part(mesh, frame) };
            self.meshed.meshes.entry(mesh.express_id).or_default().push(item_mesh);
        }
        (self.progress)(processed, &self.meshed);
    }
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
            if fails { Err("it fails".to_owned()) } else { Ok(Meshed { meshes, complaints: BTreeMap::new() }) }
        };
        let meshed = in_halves(&[1, 2, 3, 4, 5, 6, 7], pass);
        assert_eq!(meshed.meshes.into_keys().collect::<Vec<u32>>(), [1, 2, 4, 5, 6]);
        assert_eq!(meshed.complaints.into_keys().collect::<Vec<u32>>(), [3, 7]);
    }
}
