//! Cuts bodies by their openings where all of them are closed, however the openings overlap; the kernel cuts the rest.
//!
//! Bodies and openings are meshed by the kernel as if nothing cut them. What an opening takes away is a difference of solids,
//! which `geometry` computes in the planes of their faces. Its work grows with pairs of faces alone, so that nothing has to be
//! left out that takes a few seconds.

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

use crate::kernel::{File, ItemMesh, Meshed, Patch};
use crate::mesh_parts::{is_finite, merged};
use crate::product_body::ProductBody;
use crate::{MeshCache, MeshPart, MeshPool, ReadOptions};
use geometry::{Solid, difference_of_solids};
use nalgebra::{Point3, Vector3};
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

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

    /// Cuts the bodies that were meshed whole, each shape with its openings once. Those that it cannot cut are left as they are,
    /// and returned.
    pub(crate) fn cut(&self, meshed: &mut Meshed, options: &ReadOptions<'_>) -> Vec<u32> {
        let all: Vec<(u32, Option<Vec<PartCut>>)> = {
            let hosts = self.openings.keys().filter(|host| !meshed.given_up.contains(host));
            let hosts = hosts.filter(|host| meshed.meshes.contains_key(host) || meshed.complaints.contains_key(host));
            let hosts: Vec<u32> = hosts.copied().collect();
            let meshed = &*meshed;
            on_pool(options.pool, || hosts.into_par_iter().map(|host| (host, self.parts(meshed, host))).collect())
        };
        let parts = all.iter().filter_map(|(_, parts)| parts.as_ref()).flatten();
        let shapes: BTreeMap<u128, &PartCut> = parts.map(|part| (part.shape, part)).collect();
        let differences: BTreeMap<u128, Option<Difference>> = on_pool(options.pool, || {
            shapes.into_par_iter().map(|(shape, part)| (shape, part.difference(options.cache))).collect()
        });
        let mut left = Vec::new();
        for (host, parts) in all {
            let cut = parts.and_then(|parts| parts.into_iter().map(|part| part.cut(&differences)).collect());
            let Some(cut): Option<Vec<Option<ItemMesh>>> = cut else {
                left.push(host);
                continue;
            };
            meshed.meshes.insert(host, cut.into_iter().flatten().collect());
        }
        left
    }

    /// The parts of a body with what cuts them; `None` if they or their openings are not all known.
    fn parts(&self, meshed: &Meshed, host: u32) -> Option<Vec<PartCut>> {
        let of = |id: u32| -> Option<Vec<ItemMesh>> {
            let is_complete = !meshed.complaints.contains_key(&id) && !meshed.given_up.contains(&id);
            let meshes = merged(meshed.meshes.get(&id).filter(|_| is_complete)?.clone());
            meshes.iter().all(|mesh| is_finite(&mesh.part)).then_some(meshes)
        };
        let openings = self.openings_of(host);
        let mut cutters = Vec::new();
        for opening in openings.iter().filter(|opening| self.bodied.contains(opening)) {
            cutters.extend(of(*opening)?);
        }
        let is_known = !openings.iter().any(|opening| self.unknown.contains(opening));
        is_known.then(|| of(host))?.map(|parts| parts.into_iter().map(|mesh| PartCut::new(mesh, &cutters)).collect())
    }
}

fn on_pool<T: Send>(pool: Option<&MeshPool>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// Offsets between bodies are multiples of this power of two, so that copies of a shape with its openings are equal.
const OFFSETS_PER_M: f64 = 1_048_576.0;

/// Vertices and triangles of a part that is cut.
type Difference = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A part of a body and what cuts it, in coordinates of the part.
struct PartCut {
    mesh: ItemMesh,
    solid: Solid,
    cutters: Vec<Solid>,
    /// Hash of both.
    shape: u128,
}

impl PartCut {
    fn new(mesh: ItemMesh, cutters: &[ItemMesh]) -> Self {
        let origin = Point3::from(mesh.part.origin_m);
        let solid = |part: &MeshPart| {
            let offset: Vector3<f64> = Point3::from(part.origin_m) - origin;
            let offset = offset.map(|c| (c * OFFSETS_PER_M).round() / OFFSETS_PER_M);
            let positions = part.positions_m.iter().map(|p| Point3::from(p.map(f64::from)) + offset).collect();
            Solid { positions, triangles: part.triangles.clone() }
        };
        let (solid, cutters): (Solid, Vec<Solid>) =
            (solid(&mesh.part), cutters.iter().map(|cutter| solid(&cutter.part)).collect());
        let mut hash = Xxh3::new();
        for Solid { positions, triangles } in std::iter::once(&solid).chain(&cutters) {
            hash.update(&(positions.len() as u64).to_le_bytes());
            positions.iter().flat_map(|p| p.iter()).for_each(|c| hash.update(&c.to_le_bytes()));
            hash.update(&(triangles.len() as u64).to_le_bytes());
            triangles.as_flattened().iter().for_each(|k| hash.update(&k.to_le_bytes()));
        }
        Self { mesh, solid, cutters, shape: hash.digest128() }
    }

    /// What is left of the part, as it is drawn; `None` if it cannot be cut.
    fn difference(&self, cache: Option<&MeshCache>) -> Option<Difference> {
        let key = xxh3_128(&[b"difference".as_slice(), &self.shape.to_le_bytes()].concat());
        if let Some(known) = cache.and_then(|cache| cache.take(key, |_: &Option<Difference>| true)) {
            return known;
        }
        let difference = difference_of_solids(&self.solid, &self.cutters).map(|Solid { positions, triangles }| {
            (positions.iter().map(|p| [p.x, p.y, p.z].map(|c| c as f32)).collect(), triangles)
        });
        if let Some(cache) = cache {
            cache.put(Some(key), &difference);
        }
        difference
    }

    /// The part without its openings: `Some(None)` if nothing is left of it, `None` if it cannot be cut.
    fn cut(self, differences: &BTreeMap<u128, Option<Difference>>) -> Option<Option<ItemMesh>> {
        let (positions_m, triangles) = differences.get(&self.shape)?.as_ref()?;
        let part = MeshPart { positions_m: positions_m.clone(), triangles: triangles.clone(), ..self.mesh.part };
        Some((!part.triangles.is_empty()).then_some(ItemMesh { item: self.mesh.item, part }))
    }
}

/// Removes the relations by which openings cut.
pub(crate) fn remove_voids(file: &File<'_>, openings: &FxHashSet<u32>, patch: &mut Patch) {
    let voids = if openings.is_empty() { Vec::new() } else { file.all("IfcRelVoidsElement") };
    for (span, _) in voids {
        let opening = file.record(span.id).and_then(|record| record.at(5).reference());
        if opening.is_some_and(|opening| openings.contains(&opening)) {
            patch.remove(span);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{BASICS, file, read, volume_m3};
    use crate::{CutPath, Model};
    use std::fmt::Write as _;

    /// Rings of x and z in the wall of 2 x 1 x 3 m around the origin: an outline and its holes.
    type Rings<'r> = &'r [&'r [[f64; 2]]];

    const UNIT: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    /// A faceted BRep along y over rings, from y to y, with this id; ids up to `id + 999` are used.
    fn prism(id: usize, rings: Rings<'_>, y: [f64; 2]) -> String {
        let (mut text, mut next, mut faces) = (String::new(), id + 1, Vec::new());
        let mut add = |text: &mut String, record: String| {
            next += 1;
            write!(text, "#{next}={record};").unwrap();
            next
        };
        let list = |ids: &[usize]| ids.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
        let mut points: Vec<Vec<Vec<usize>>> = Vec::new();
        for y in y {
            let mut at = |[x, z]: &[f64; 2]| add(&mut text, format!("IFCCARTESIANPOINT(({x:?},{y:?},{z:?}))"));
            points.push(rings.iter().map(|ring| ring.iter().map(&mut at).collect()).collect());
        }
        let mut face = |text: &mut String, outlines: &[Vec<usize>]| {
            let mut bounds = Vec::new();
            for (k, outline) in outlines.iter().enumerate() {
                let outline = add(text, format!("IFCPOLYLOOP(({}))", list(outline)));
                let kind = if k == 0 { "IFCFACEOUTERBOUND" } else { "IFCFACEBOUND" };
                bounds.push(add(text, format!("{kind}(#{outline},.T.)")));
            }
            add(text, format!("IFCFACE(({}))", list(&bounds)))
        };
        faces.push(face(&mut text, &points[0]));
        let back: Vec<Vec<usize>> = points[1].iter().map(|ring| ring.iter().rev().copied().collect()).collect();
        faces.push(face(&mut text, &back));
        for (near, far) in std::iter::zip(&points[0], &points[1]) {
            for k in 0..near.len() {
                let next = (k + 1) % near.len();
                faces.push(face(&mut text, &[vec![near[k], far[k], far[next], near[next]]]));
            }
        }
        write!(text, "#{}=IFCCLOSEDSHELL(({}));#{id}=IFCFACETEDBREP(#{});", id + 1, list(&faces), id + 1).unwrap();
        text
    }

    /// A wall whose items are bodies, with an opening for each of the others.
    fn walled(bodies: &[(Rings<'_>, [f64; 2])], openings: &[(Rings<'_>, [f64; 2])]) -> Model {
        let mut text = String::new();
        let mut items = String::from("#110");
        for (k, (rings, y)) in bodies.iter().enumerate() {
            let id = 1_000 * (k + 1);
            items = if k == 0 { format!("#{id}") } else { format!("{items},#{id}") };
            text += &prism(id, rings, *y);
        }
        write!(
            text,
            "#1=IFCWALL('wall',$,'W',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
             #3=IFCSHAPEREPRESENTATION(#101,'Body','Brep',({items}));"
        )
        .unwrap();
        for (k, (rings, y)) in openings.iter().enumerate() {
            let id = 100_000 + 1_000 * k;
            text += &prism(id, rings, *y);
            write!(
                text,
                "#{}=IFCOPENINGELEMENT('o{k}',$,$,$,$,#103,#{},$,$);#{}=IFCPRODUCTDEFINITIONSHAPE($,$,(#{}));
                 #{}=IFCSHAPEREPRESENTATION(#101,'Body','Brep',(#{id}));#{}=IFCRELVOIDSELEMENT('v{k}',$,$,$,#1,#{});",
                id + 996,
                id + 997,
                id + 997,
                id + 998,
                id + 998,
                id + 999,
                id + 996
            )
            .unwrap();
        }
        let (model, diagnostics) = read(&file(&format!("{BASICS}{text}"))).unwrap();
        assert_eq!(diagnostics.iter().map(|d| d.code.name()).collect::<Vec<_>>(), Vec::<&str>::new());
        model
    }

    fn rectangle(x: [f64; 2], z: [f64; 2]) -> [[f64; 2]; 4] {
        UNIT.map(|[u, v]| [x[0] + u * (x[1] - x[0]), z[0] + v * (z[1] - z[0])])
    }

    fn reversed(mut ring: [[f64; 2]; 4]) -> [[f64; 2]; 4] {
        ring.reverse();
        ring
    }

    fn check(model: &Model, expected_m3: f64) {
        let geometry = &model.elements[0].geometry;
        assert_eq!(geometry.cut, CutPath::Polygons);
        let volume: f32 = geometry.parts.iter().map(volume_m3).sum();
        assert!((f64::from(volume) - expected_m3).abs() < 1e-4, "{volume} instead of {expected_m3}");
    }

    const THROUGH: [f64; 2] = [-0.5, 0.5];

    #[test]
    fn many_openings_that_overlap_and_share_planes_with_the_wall_are_all_cut() {
        // Steps of 5 cm, each half a metre wide and from the foot of the wall on: 1.45 x 1 x 2 m in all.
        let rings: Vec<[[f64; 2]; 4]> =
            (0..20).map(|k| 0.05 * f64::from(k)).map(|x| rectangle([x - 0.9, x - 0.4], [0.0, 2.0])).collect();
        let outlines: Vec<[&[[f64; 2]]; 1]> = rings.iter().map(|ring| [ring.as_slice()]).collect();
        let openings: Vec<(Rings<'_>, [f64; 2])> = outlines.iter().map(|rings| (rings.as_slice(), THROUGH)).collect();
        check(&walled(&[], &openings), 6.0 - 1.45 * 2.0);
    }

    #[test]
    fn inner_bounds_of_openings_stay_and_those_of_the_wall_are_no_material() {
        let (outer, inner) = (rectangle([-0.5, 0.5], [1.0, 2.0]), reversed(rectangle([-0.25, 0.25], [1.25, 1.75])));
        check(&walled(&[], &[(&[&outer, &inner], THROUGH)]), 6.0 - 0.75);
        let (wall, gap) = (rectangle([-1.0, 1.0], [0.0, 3.0]), reversed(rectangle([0.0, 0.9], [0.5, 2.5])));
        // Half of the opening, and a quarter of its hole, lies in the gap of the wall.
        check(&walled(&[(&[&wall, &gap], THROUGH)], &[(&[&outer, &inner], [-1.0, 1.0])]), 6.0 - 1.8 - 0.5 + 0.125);
    }

    #[test]
    fn each_layer_of_a_wall_is_cut() {
        let (layer, opening) = (rectangle([-1.0, 1.0], [0.0, 3.0]), rectangle([-0.5, 0.5], [0.0, 2.0]));
        let layers: [(Rings<'_>, [f64; 2]); 2] = [(&[&layer], [-0.5, 0.0]), (&[&layer], [0.0, 0.5])];
        let model = walled(&layers, &[(&[&opening], THROUGH)]);
        assert_eq!(model.elements[0].geometry.parts.len(), 2);
        check(&model, 6.0 - 2.0);
    }
}
