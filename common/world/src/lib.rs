//! The building at the plan time as a simulation world: what stands as convex pieces, doors on joints, one frame with the
//! maps.
//!
//! ```text
//! groundplan convert house.ifc -o maps --world                                # doors on joints
//! groundplan convert house.ifc -o maps --world --doors open                   # movable, open, closed or passable
//! groundplan convert house.ifc -o maps --world --date 2024-04-15 --barriers   # thin walls close blocked rooms
//! groundplan convert house.ifc -o maps --world --usd                          # as USD, too
//! groundplan convert house.ifc -o maps --world=world.toml                     # all else, see config/world.toml
//! gz sim maps/world/world.sdf
//! ```
//!
//! | file | content |
//! |---|---|
//! | `world/world.sdf` | SDF 1.9: static models per storey and class, a model for each door, the sun, the frame `robot_spawn` |
//! | `world/meshes/*.obj`, `materials.mtl` | meshes, each once however often it stands somewhere |
//! | `world/lookup.json` | models, elements, doors, counts, by GlobalId |
//! | `world/doors.urdf` | the doors as one tree of links and joints |
//! | `world/ground.xml` | where there is ground outdoors: the same for MuJoCo, as convex plates |
//! | `world/site.glb` | the same for viewers, a node per element |
//! | `world/site.usda` | with `--usd`: the same as USD, with UsdPhysics, for Isaac Sim and others |
//!
//! Collision shapes are convex pieces, because physics engines replace other meshes by their hulls: a wall with a door is
//! two piers and a lintel, so that every doorway is open; boxes where a piece is a box. An element of more than 64 pieces,
//! such as a tree or a cabinet of boards, has fewer: neighbours become their common hull where that lies within 5 cm of them
//! (foliage 40 cm), see [`Pieces`]. Each mesh that collides is checked as it is written: it is closed, and convex but for
//! rounding. The hull of its corners stands in for one that is not, which a warning tells with the element.
//!
//! Ground outdoors (terrain, earthworks, roads) is its faces, as far as the map of the ground outdoors reaches, 30 m around whatever is
//! no terrain: one mesh in `world.sdf` that is seen and collides and is not convex, since hulls would fill valleys and pits; a solid of
//! few exact convex pieces, as a road between its edges or earth in a pit, is these. MuJoCo, which knows no mesh but its hull, has
//! plates of 2 cm behind the faces (`ground.xml`, to be included; bodies have the names of links): exact to a millimetre, also at an
//! upright edge, where a field of heights is wrong by its whole height in a cell; a site of 60 x 60 m is 692 plates, and would be
//! 1.4 million heights of 5 cm.
//!
//! World coordinates are map coordinates: a waypoint is where the robot stands in the world, and `robot_spawn` is the first.
//! Every link is named by class and GlobalId, models carry the class as label for segmentation cameras, and `lookup.json`
//! has the element, the accuracy of the pieces and the motion of each door. `scripts/check_world.py OUT` compares the rays
//! of the world with the maps, those that fall with the heights of the maps (`elevation.png`).
//!
//! `site.usda` is one layer in metres, Z up, whose default prim is `/site`: a prim for each element with its `ifc:globalId`, shapes that
//! are seen as in `site.glb` and shapes that collide as in `world.sdf` (of the purpose `guide`, so that they are not drawn), each mesh
//! once. A leaf is a rigid body beside the frame of its door, on a joint with the axis and limits of `doors.urdf`, in degrees; USD has no
//! friction of joints, and damping is a drive without stiffness. What rises is as light as its rest beside the counterweight.
//! `scripts/check_usd.py OUT` has USD's own validators, and compares it with the other files.
//!
//! # Guarantees
//!
//! - Elements are those of the effective state. Ground outdoors is there as on its map: once it is built, and not while it is removed;
//!   the shape of a site or road itself always. It ends with the faces that reach that map, but a solid of exact pieces is whole; a body
//!   that lies wholly outside is told (`not_in_world`). What is not sound as a collision shape and lies in a plane is replaced by a
//!   plate instead of a hull (`src/collision_meshes.rs`).
//! - Where the maps assume floor there is a plate (`src/stand_ins.rs`): under rooms without a slab and the openings between
//!   them, or under the cells that walls enclose. Rays in the world end where they end on the planning map:
//!   `scripts/check_world.py OUT` proves it from the files alone, at least 99.5 % within a cell on every building tried.
//! - A door moves as its operation type says, about the side and to the front that the model says; where it would cut into
//!   what stands its joint ends before. What is assumed, ended early or approximated is in `lookup.json`.
//!
//! # Where
//!
//! - world: looks of elements: `src/visuals.rs`, `src/meshes.rs`
//! - world: ground outdoors, which of it and how far: `src/ground_bodies.rs`
//! - world: ground for MuJoCo: `src/ground_plates.rs`, `src/mjcf.rs`

mod collision_meshes;
mod door_links;
mod doors;
mod element_pieces;
mod findings;
mod gltf;
mod ground_bodies;
mod ground_faces;
mod ground_plates;
mod joint_limits;
mod lookup;
mod meshes;
mod mjcf;
mod options;
mod scene;
mod sdf;
mod stand_ins;
mod static_elements;
mod triangle_fans;
mod urdf;
mod usd;
mod usda;
mod visuals;

pub use lookup::Lookup;
pub use options::{DoorMode, DoorOptions, Materials, Pieces, WorldOptions, WorldOptionsError};

use export::{ExportFile, ExportInput, json_text};
use messages::Diagnostic;
use scene::Scene;
use std::collections::{BTreeMap, BTreeSet};
use visuals::Rgba;

/// The files of a world, and what is to be told about it.
#[derive(Debug, Default)]
pub struct WorldFiles {
    /// The files, in `world/`.
    pub files: Vec<ExportFile>,
    /// Elements that are not in it, or not quite as they are cut; `lookup.json` has them, too.
    pub diagnostics: Vec<Diagnostic>,
}

/// The files of a world.
pub fn files(input: &ExportInput<'_>, options: &WorldOptions) -> WorldFiles {
    let scene = Scene::of(input, options);
    let mut files = vec![
        ExportFile::new("world/world.sdf", sdf::world(&scene)),
        ExportFile::new("world/model.config", sdf::model_config()),
        ExportFile::new("world/doors.urdf", urdf::doors(&scene)),
        ExportFile::new("world/site.glb", gltf::site(&scene)),
    ];
    files.extend(options.usd.then(|| ExportFile::new("world/site.usda", usd::site(&scene))));
    files.extend(mjcf::ground(&scene).map(|text| ExportFile::new("world/ground.xml", text)));
    let (names, materials) = material_file(&scene.materials);
    if !names.is_empty() {
        files.push(ExportFile::new("world/meshes/materials.mtl", materials));
    }
    for (k, (solid, material)) in scene.store.meshes.iter().zip(&scene.materials).enumerate() {
        let material = material.map(|m| names[&m].as_str());
        files.push(ExportFile::new(format!("world/{}", sdf::uri(k)), solid.obj(material)));
    }
    let bytes = |ends: &[&str]| -> usize {
        files.iter().filter(|f| ends.iter().any(|e| f.path.ends_with(e))).map(|f| f.bytes.len()).sum()
    };
    let sizes = [bytes(&[".sdf", ".obj", ".mtl"]), bytes(&[".glb"])];
    files.push(ExportFile::new("world/lookup.json", json_text(&Lookup::of(&scene, sizes))));
    WorldFiles { files, diagnostics: scene.diagnostics }
}

/// The world as one model for viewers: the bytes of `world/site.glb`.
pub fn model(input: &ExportInput<'_>, options: &WorldOptions) -> Vec<u8> {
    gltf::site(&Scene::of(input, options))
}

/// `materials.mtl`, and the name of each colour in it.
fn material_file(used: &[Option<Rgba>]) -> (BTreeMap<Rgba, String>, String) {
    let colours: BTreeSet<Rgba> = used.iter().flatten().copied().collect();
    let mut text = String::new();
    let mut names = BTreeMap::new();
    for colour in colours {
        let name = format!("c{:08x}", u32::from_be_bytes(colour));
        let [r, g, b, a] = colour.map(|c| meshes::number((f64::from(c) / 255.0 * 1000.0).round() / 1000.0));
        text.push_str(&format!("newmtl {name}\nKa {r} {g} {b}\nKd {r} {g} {b}\nd {a}\n"));
        names.insert(colour, name);
    }
    (names, text)
}
