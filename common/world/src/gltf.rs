//! `site.glb`: the world for viewers, a node per element named by its GlobalId.

use crate::door_links::pose_at;
use crate::meshes::{PlacedMesh, Solid, UNITS_PER_M};
use crate::scene::{Part, Scene};
use crate::visuals::{Rgba, class_colour, linear};
use convex::ConvexBox;
use grid::Class;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Constants of glTF 2.0.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

#[derive(Default)]
struct Builder {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    known_meshes: BTreeMap<(Solid, Rgba), usize>,
    known_geometry: BTreeMap<Solid, [usize; 3]>,
    known_materials: BTreeMap<Rgba, usize>,
}

/// The file.
pub(super) fn site(scene: &Scene<'_>) -> Vec<u8> {
    let mut builder = Builder::default();
    let mut roots = Vec::new();
    for model in &scene.models {
        let mut links = Vec::new();
        for link in &model.links {
            let id = link.body.global_id(scene.input.site);
            let extras = json!({"class": model.class.name()});
            let name = id.unwrap_or(&link.name);
            let mut node = match link.shown.as_slice() {
                // An element in one colour is one node.
                [(placed, colour)] => builder.placed(scene, *placed, *colour),
                [] => {
                    let parts: Vec<usize> = link.visuals.iter().map(|(p, c)| builder.part(scene, p, *c)).collect();
                    json!({"children": parts})
                }
                several => {
                    let parts: Vec<Value> = several.iter().map(|(p, c)| builder.placed(scene, *p, *c)).collect();
                    let parts: Vec<usize> = parts.into_iter().map(|n| builder.node(n)).collect();
                    json!({"children": parts})
                }
            };
            node["name"] = json!(name);
            node["extras"] = extras;
            links.push(builder.node(node));
        }
        roots.push(builder.node(json!({"name": model.name, "children": links})));
    }
    for door in &scene.doors {
        let values = door.values(scene.options.doors);
        let mut children = Vec::new();
        for (k, link) in door.links.iter().enumerate() {
            let (at, yaw) = pose_at(&door.links, k, &values);
            let colour = class_colour(Class::Door);
            let boards: Vec<usize> =
                link.boards.iter().map(|b| builder.part(scene, &level_box(b.centre_m, b.size_m), colour)).collect();
            let rotation = [0.0, 0.0, libm::sin(yaw / 2.0), libm::cos(yaw / 2.0)];
            children.push(
                builder.node(json!({"name": link.name, "children": boards, "translation": at, "rotation": rotation})),
            );
        }
        let (sin, cos) = (libm::sin(door.yaw_rad / 2.0), libm::cos(door.yaw_rad / 2.0));
        let id = scene.input.site.text(scene.input.site.elements[door.element as usize].global_id);
        roots.push(builder.node(json!({
            "name": id, "children": children, "translation": door.origin_m, "rotation": [0.0, 0.0, sin, cos],
            "extras": {"class": "door"},
        })));
    }
    builder.finish(roots)
}

fn level_box(centre_m: [f64; 3], size_m: [f64; 3]) -> Part {
    Part::Box(ConvexBox { centre_m, axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], size_m })
}

impl Builder {
    fn node(&mut self, mut node: Value) -> usize {
        if let Some(fields) = node.as_object_mut() {
            fields.retain(|_, v| v.as_array().is_none_or(|a| !a.is_empty()));
        }
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// A node that shows a mesh of an element.
    fn placed(&mut self, scene: &Scene<'_>, placed: PlacedMesh, colour: Rgba) -> Value {
        let mesh = self.mesh(&scene.shown.meshes[placed.mesh], colour);
        placed_node(mesh, &placed)
    }

    /// A node that shows a part.
    fn part(&mut self, scene: &Scene<'_>, part: &Part, colour: Rgba) -> usize {
        match part {
            Part::Mesh(placed) => {
                let mesh = self.mesh(&scene.store.meshes[placed.mesh], colour);
                let node = placed_node(mesh, placed);
                self.node(node)
            }
            Part::Box(b) => {
                let mesh = self.mesh(&unit_cube(), colour);
                let [x, y, z] = b.axes;
                let [sx, sy, sz] = b.size_m;
                let c = b.centre_m;
                let round = |v: f64| (v * 1e6).round() / 1e6;
                if x == [1.0, 0.0, 0.0] && z == [0.0, 0.0, 1.0] {
                    return self.node(json!({"mesh": mesh, "translation": c.map(round), "scale": b.size_m.map(round)}));
                }
                let matrix = [
                    x[0] * sx,
                    x[1] * sx,
                    x[2] * sx,
                    0.0,
                    y[0] * sy,
                    y[1] * sy,
                    y[2] * sy,
                    0.0,
                    z[0] * sz,
                    z[1] * sz,
                    z[2] * sz,
                    0.0,
                    c[0],
                    c[1],
                    c[2],
                    1.0,
                ];
                self.node(json!({"mesh": mesh, "matrix": matrix.map(round)}))
            }
        }
    }

    fn mesh(&mut self, solid: &Solid, colour: Rgba) -> usize {
        let key = (solid.clone(), colour);
        if let Some(known) = self.known_meshes.get(&key) {
            return *known;
        }
        let [positions, normals, indices] = self.geometry(solid);
        let material = self.material(colour);
        self.meshes.push(json!({"primitives": [
            {"attributes": {"POSITION": positions, "NORMAL": normals}, "indices": indices, "material": material}
        ]}));
        self.known_meshes.insert(key, self.meshes.len() - 1);
        self.meshes.len() - 1
    }

    fn material(&mut self, colour: Rgba) -> usize {
        if let Some(known) = self.known_materials.get(&colour) {
            return *known;
        }
        let [r, g, b, a] = colour;
        let alpha = (f64::from(a) / 255.0 * 1e4).round() / 1e4;
        let mut material = json!({
            "pbrMetallicRoughness": {"baseColorFactor": [linear(r), linear(g), linear(b), alpha], "metallicFactor": 0.0},
            "doubleSided": true,
        });
        if a < 255 {
            material["alphaMode"] = json!("BLEND");
        }
        self.materials.push(material);
        self.known_materials.insert(colour, self.materials.len() - 1);
        self.materials.len() - 1
    }

    /// Accessors of positions, normals and indices; corners are shared within a plane only.
    fn geometry(&mut self, solid: &Solid) -> [usize; 3] {
        if let Some(known) = self.known_geometry.get(solid) {
            return *known;
        }
        let flat = FlatShadedMesh::of(solid);
        let range = |pick: fn(f32, f32) -> f32, start: f32| {
            [0, 1, 2].map(|k| flat.positions.iter().map(|p| p[k]).fold(start, pick))
        };
        let (min, max) = (range(f32::min, f32::INFINITY), range(f32::max, f32::NEG_INFINITY));
        let bytes = |v: &[[f32; 3]]| v.iter().flatten().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>();
        let positions = self.accessor(&bytes(&flat.positions), ARRAY_BUFFER, FLOAT, flat.positions.len(), "VEC3");
        self.accessors[positions]["min"] = json!(min);
        self.accessors[positions]["max"] = json!(max);
        let normals = self.accessor(&bytes(&flat.normals), ARRAY_BUFFER, FLOAT, flat.normals.len(), "VEC3");
        let is_short = flat.positions.len() < usize::from(u16::MAX);
        let index = |k: &u32| if is_short { (*k as u16).to_le_bytes().to_vec() } else { k.to_le_bytes().to_vec() };
        let raw: Vec<u8> = flat.indices.iter().flat_map(index).collect();
        let kind = if is_short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        let indices = self.accessor(&raw, ELEMENT_ARRAY_BUFFER, kind, flat.indices.len(), "SCALAR");
        self.known_geometry.insert(solid.clone(), [positions, normals, indices]);
        [positions, normals, indices]
    }

    fn accessor(&mut self, bytes: &[u8], target: u32, component: u32, count: usize, kind: &str) -> usize {
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = self.views.len();
        self.views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "target": target}));
        self.accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    /// glTF is Y up: one node turns the map.
    fn finish(mut self, roots: Vec<usize>) -> Vec<u8> {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let map = self.node(json!({"name": "map", "children": roots, "rotation": [-half, 0.0, 0.0, half]}));
        let mut document = json!({
            "asset": {"version": "2.0", "generator": "groundplan"},
            "scene": 0, "scenes": [{"nodes": [map]}], "nodes": self.nodes,
        });
        let lists = [
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
        ];
        for (name, list) in lists.into_iter().filter(|(_, l)| !l.is_empty()) {
            document[name] = Value::Array(list);
        }
        if !self.binary.is_empty() {
            document["buffers"] = json!([{"byteLength": self.binary.len()}]);
        }
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut chunks = vec![(*b"JSON", text)];
        if !self.binary.is_empty() {
            chunks.push((*b"BIN\0", self.binary));
        }
        let length: usize = 12 + chunks.iter().map(|(_, c)| 8 + c.len()).sum::<usize>();
        let mut out = b"glTF".to_vec();
        out.extend(2u32.to_le_bytes());
        out.extend((length as u32).to_le_bytes());
        for (kind, content) in chunks {
            out.extend((content.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(content);
        }
        out
    }
}

fn placed_node(mesh: usize, placed: &PlacedMesh) -> Value {
    let mut node = json!({"mesh": mesh, "translation": placed.shift_m});
    if placed.quarters > 0 {
        let half = placed.yaw_rad() / 2.0;
        node["rotation"] = json!([0.0, 0.0, libm::sin(half), libm::cos(half)]);
    }
    node
}

/// Triangles with corners for each plane.
#[derive(Default)]
struct FlatShadedMesh {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl FlatShadedMesh {
    fn of(solid: &Solid) -> Self {
        let mut flat = Self::default();
        let mut known: BTreeMap<(u32, [i32; 3]), u32> = BTreeMap::new();
        for face in &solid.faces {
            for k in 1..face.len() - 1 {
                let corners = [face[0], face[k], face[k + 1]];
                let at = corners.map(|c| solid.vertices[c as usize].map(|v| v as f64 / UNITS_PER_M));
                let Some(normal) = normal(&at) else { continue };
                // Normals of one plane differ by rounding.
                let plane = normal.map(|c| (c * 1e3).round() as i32);
                for (corner, p) in corners.into_iter().zip(at) {
                    let index = *known.entry((corner, plane)).or_insert_with(|| {
                        flat.positions.push(p.map(|c| c as f32));
                        flat.normals.push(normal.map(|c| c as f32));
                        flat.positions.len() as u32 - 1
                    });
                    flat.indices.push(index);
                }
            }
        }
        flat
    }
}

fn normal(t: &[[f64; 3]; 3]) -> Option<[f64; 3]> {
    let side = |k: usize| [0, 1, 2].map(|i| t[k][i] - t[0][i]);
    let (u, v) = (side(1), side(2));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 1e-12).then(|| n.map(|c| c / length))
}

fn unit_cube() -> Solid {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let hull = ConvexBox { centre_m: [0.0; 3], axes, size_m: [1.0; 3] }.hull();
    Solid::of_piece(&hull)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_has_four_corners_and_a_normal_for_each_side() {
        let flat = FlatShadedMesh::of(&unit_cube());
        assert_eq!((flat.positions.len(), flat.indices.len()), (24, 36));
        assert!(flat.normals.iter().zip(&flat.positions).all(|(n, p)| (0..3).map(|k| n[k] * p[k]).sum::<f32>() > 0.4));
    }
}
