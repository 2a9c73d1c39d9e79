//! Cuts bodies by their openings where all of them are closed, however the openings overlap; the kernel cuts the rest.
//!
//! Bodies and openings are meshed by the kernel as if nothing cut them. What an opening takes away is a difference of solids,
//! which `geometry` computes in the planes of their faces. Its work grows with pairs of faces alone, so that nothing has to be
//! left out that takes a few seconds.

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

use crate::geometry::remove_voids;
use crate::kernel::{File, ItemMesh, Meshed, Patch};
use crate::mesh_parts::{is_finite, merged};
use crate::product_body::ProductBody;
use crate::{MeshPart, MeshPool};
use geometry::{Solid, difference_of_solids};
use nalgebra::{Point3, Vector3};

/// The openings that cut each element.
pub(crate) struct OwnCuts {
    /// Element -> openings of it and of what it is a part of.
    openings: BTreeMap<u32, Vec<u32>>,
    /// Openings with a body.
    bodied: FxHashSet<u32>,
    /// Features that take something away and are no openings, or that have no body.
    unknown: FxHashSet<u32>,
}

impl OwnCuts {
    /// An opening cuts all parts of an element as well.
    pub(crate) fn of(file: &File<'_>, products: &[ProductBody<'_, '_>]) -> Self {
        let mut openings: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let is_cut = |product: &&ProductBody<'_, '_>| !product.openings.is_empty();
        for product in products.iter().filter(is_cut) {
            openings.insert(product.record.id, product.openings.to_vec());
        }
        let mut parts: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        let aggregates = if openings.is_empty() { Vec::new() } else { file.all("IfcRelAggregates") };
        for record in aggregates.into_iter().filter_map(|(span, _)| file.record(span.id)) {
            if let Some(whole) = record.at(4).reference() {
                parts.entry(whole).or_default().extend(record.at(5).references());
            }
        }
        for product in products.iter().filter(is_cut) {
            let (mut waiting, mut met) = (vec![product.record.id], FxHashSet::default());
            while let Some(whole) = waiting.pop() {
                for &part in parts.get(&whole).into_iter().flatten().filter(|part| **part != product.record.id) {
                    if met.insert(part) {
                        let of_part = openings.entry(part).or_default();
                        of_part.extend(
                            product.openings.iter().filter(|opening| !of_part.contains(opening)).collect::<Vec<_>>(),
                        );
                        waiting.push(part);
                    }
                }
            }
        }
        let cutting = || products.iter().filter(|product| product.cuts);
        let known: FxHashSet<u32> = cutting().map(|product| product.record.id).collect();
        let bodied =
            cutting().filter(|product| !product.body.items.is_empty()).map(|product| product.record.id).collect();
        let unknown = openings.values().flatten().filter(|opening| !known.contains(opening)).copied().collect();
        Self { openings, bodied, unknown }
    }

    /// The openings that cut an element.
    pub(crate) fn openings_of(&self, host: u32) -> &[u32] {
        self.openings.get(&host).map_or(&[], Vec::as_slice)
    }

    /// The patch without the relations by which openings cut.
    pub(crate) fn without_voids(&self, file: &File<'_>, patch: &Patch) -> Patch {
        let mut whole = patch.clone();
        remove_voids(file, &self.openings.values().flatten().copied().collect(), &mut whole);
        whole
    }

    /// Cuts the bodies that were meshed whole. Those that it cannot cut are left as they are, and returned.
    pub(crate) fn cut(&self, meshed: &mut Meshed, pool: Option<&MeshPool>) -> Vec<u32> {
        let is_given_up = |host: u32| meshed.given_up.contains(&host);
        let hosts: Vec<(&u32, &Vec<u32>)> = self.openings.iter().filter(|(host, _)| !is_given_up(**host)).collect();
        let work =
            || hosts.par_iter().map(|(host, openings)| (**host, self.cut_host(meshed, **host, openings))).collect();
        let found: Vec<(u32, Outcome)> = match pool {
            Some(pool) => pool.install(work),
            None => work(),
        };
        let mut left = Vec::new();
        for (host, outcome) in found {
            match outcome {
                Outcome::Untouched => {}
                Outcome::Left => left.push(host),
                Outcome::Cut(meshes) => _ = meshed.meshes.insert(host, meshes),
            }
        }
        left
    }

    fn cut_host(&self, meshed: &Meshed, host: u32, openings: &[u32]) -> Outcome {
        let is_complete = |id: &u32| !meshed.complaints.contains_key(id) && !meshed.given_up.contains(id);
        let Some(meshes) = meshed.meshes.get(&host) else {
            return if is_complete(&host) { Outcome::Untouched } else { Outcome::Left };
        };
        if !is_complete(&host) || openings.iter().any(|opening| self.unknown.contains(opening)) {
            return Outcome::Left;
        }
        let mut cutters = Vec::new();
        for opening in openings.iter().filter(|opening| self.bodied.contains(opening)) {
            let Some(parts) = meshed.meshes.get(opening).filter(|_| is_complete(opening)) else { return Outcome::Left };
            cutters.extend(merged(parts.clone()));
        }
        let parts = merged(meshes.clone());
        if !parts.iter().chain(&cutters).all(|mesh| is_finite(&mesh.part)) {
            return Outcome::Left;
        }
        let cut: Option<Vec<Option<ItemMesh>>> = parts.into_iter().map(|mesh| cut_part(mesh, &cutters)).collect();
        cut.map_or(Outcome::Left, |cut| Outcome::Cut(cut.into_iter().flatten().collect()))
    }
}

/// What became of an element.
enum Outcome {
    /// It has no body.
    Untouched,
    /// It cannot be cut here.
    Left,
    /// What is left of it.
    Cut(Vec<ItemMesh>),
}

/// A part without its openings: `Some(None)` if nothing is left of it.
fn cut_part(mesh: ItemMesh, cutters: &[ItemMesh]) -> Option<Option<ItemMesh>> {
    let origin = Point3::from(mesh.part.origin_m);
    let solid = |part: &MeshPart| {
        let offset: Vector3<f64> = Point3::from(part.origin_m) - origin;
        let positions = part.positions_m.iter().map(|p| Point3::from(p.map(f64::from)) + offset).collect();
        Solid { positions, triangles: part.triangles.clone() }
    };
    let cutters: Vec<Solid> = cutters.iter().map(|cutter| solid(&cutter.part)).collect();
    let Solid { positions, triangles } = difference_of_solids(&solid(&mesh.part), &cutters)?;
    let positions_m = positions.iter().map(|p| [p.x, p.y, p.z].map(|c| c as f32)).collect();
    let part = MeshPart { positions_m, triangles, ..mesh.part };
    Some((!part.triangles.is_empty()).then_some(ItemMesh { item: mesh.item, part }))
}
