//! The building at the plan time as a simulation world: what stands as convex pieces, doors on joints, one frame with the
//! maps.
//!
//! ```text
//! groundplan convert house.ifc -o maps --world                                # doors on joints
//! groundplan convert house.ifc -o maps --world --doors open                   # movable, open, closed or passable
//! groundplan convert house.ifc -o maps --world --date 2024-04-15 --barriers   # thin walls close blocked rooms
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
//! | `world/site.glb` | the same for viewers, a node per element |
//!
//! What collides are convex pieces, because physics engines fill the hull of everything else: a wall with a door is two
//! piers and a lintel, so that every doorway is open; boxes where a piece is a box. An element of more than 64 pieces, such
//! as a tree or a cabinet of boards, has fewer: neighbours become their common hull where that lies within 5 cm of them
//! (foliage 40 cm), see [`Pieces`].
//!
//! World coordinates are map coordinates: a waypoint is where the robot stands in the world, and `robot_spawn` is the
//! first. Every link is named by class and GlobalId, models carry the class as label for segmentation cameras, and
//! `lookup.json` says what each is, how exactly its pieces fit, and how each door moves. `scripts/check_world.py OUT`
//! compares the rays of the world with the maps.

mod bodies;
mod doors;
mod extras;
mod fans;
mod gltf;
mod leaves;
mod limits;
mod lookup;
mod meshes;
mod operations;
mod options;
mod sdf;
mod statics;
mod urdf;
mod visuals;

pub use lookup::Lookup;
pub use options::{DoorMode, Leafs, Materials, Pieces, WorldOptions, WorldOptionsError};

use convex::{ConvexBox, Made, Piece, Shape};
use doors::{WorldDoor, hangs, is_door};
use export::{ExportFile, ExportInput, json_text, rounded};
use grid::Class;
use meshes::{MeshStore, Placed, Solid};
use statics::Static;
use std::collections::{BTreeMap, BTreeSet};
use visuals::{Rgba, class_colour};

/// Exact boxes up to which an element is also shown as boxes.
const BOXES_SHOWN_MAX: usize = 8;

/// Everything that the files of a world are made from.
struct Scene<'a> {
    input: &'a ExportInput<'a>,
    options: &'a WorldOptions,
    store: MeshStore,
    /// Meshes of the elements for viewers.
    shown: MeshStore,
    /// Material of each mesh of the store; `None` for those that only collide.
    materials: Vec<Option<Rgba>>,
    models: Vec<Model>,
    doors: Vec<WorldDoor>,
    /// Doors that hang and are not in the world, and why.
    left_out: Vec<(u32, &'static str)>,
    spawn: Option<Spawn>,
    markers_m: Vec<[f64; 3]>,
}

/// A static model: a class on a storey.
struct Model {
    name: String,
    class: Class,
    storey: u32,
    links: Vec<Link>,
}

/// An element, or what stands in for one.
struct Link {
    element: Option<u32>,
    name: String,
    visuals: Vec<(Part, Rgba)>,
    /// The element's own meshes, for viewers.
    shown: Vec<(Placed, Rgba)>,
    collisions: Vec<Part>,
    pieces: Vec<Facts>,
}

/// What is told of a piece.
#[derive(Clone, Copy)]
struct Facts {
    made: Made,
    is_box: bool,
    deviation_m: f64,
}

/// A shape in `map`.
enum Part {
    Box(ConvexBox),
    Mesh(Placed),
}

/// Where a robot begins: the first waypoint.
struct Spawn {
    at_m: [f64; 3],
    yaw_rad: f64,
    waypoint: u32,
    storey: u32,
}

/// The files of a world, in `world/`.
pub fn files(input: &ExportInput<'_>, options: &WorldOptions) -> Vec<ExportFile> {
    let scene = Scene::of(input, options);
    let mut files = vec![
        ExportFile::new("world/world.sdf", sdf::world(&scene)),
        ExportFile::new("world/model.config", sdf::model_config()),
        ExportFile::new("world/doors.urdf", urdf::doors(&scene)),
        ExportFile::new("world/site.glb", gltf::site(&scene)),
    ];
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
    files
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

impl<'a> Scene<'a> {
    fn of(input: &'a ExportInput<'a>, options: &'a WorldOptions) -> Self {
        let mut barriers = if options.barriers { extras::barriers(input) } else { Vec::new() };
        let is_movable = |element: u32| is_door(input, element);
        let mut statics = statics::statics(input, options, is_movable);
        statics.extend(extras::assumed_floors(input));
        let barred: BTreeSet<u32> = barriers.iter().filter_map(|(door, _)| *door).collect();
        statics.extend(barriers.drain(..).map(|(_, wall)| wall));
        let (doors, left_out) = hung_doors(input, options, &statics, &barred);
        let mut scene = Self {
            input,
            options,
            store: MeshStore::default(),
            shown: MeshStore::default(),
            materials: Vec::new(),
            models: Vec::new(),
            doors,
            left_out,
            spawn: spawn(input),
            markers_m: Vec::new(),
        };
        if options.markers {
            scene.markers_m = input.plan.waypoints.iter().map(|w| w.position_in_map_m.map(rounded)).collect();
        }
        scene.add_models(statics);
        scene
    }

    /// A model for each class on each storey.
    fn add_models(&mut self, statics: Vec<Static>) {
        let mut groups: BTreeMap<(u32, Class), Vec<Link>> = BTreeMap::new();
        for part in statics {
            let group = (part.storey, part.class);
            let link = self.link(part);
            if !link.collisions.is_empty() {
                groups.entry(group).or_default().push(link);
            }
        }
        let model = |((storey, class), links): ((u32, Class), Vec<Link>)| Model {
            name: format!("{storey:02}_{}", class.name()),
            class,
            storey,
            links,
        };
        self.models = groups.into_iter().map(model).collect();
    }

    fn link(&mut self, part: Static) -> Link {
        let Static { element, link, class, pieces, .. } = part;
        let fact = |p: &Piece| Facts { made: p.made, is_box: sdf::is_box(&p.shape), deviation_m: p.deviation_m };
        let facts: Vec<Facts> = pieces.iter().map(fact).collect();
        let are_boxes = facts.iter().all(|f| f.is_box && f.made == Made::Exact) && facts.len() <= BOXES_SHOWN_MAX;
        let looks = match element {
            Some(k) => visuals::looks(self.input, self.options, &self.input.site.elements[k as usize]),
            None => Vec::new(),
        };
        let shown = looks.iter().map(|l| (self.shown.place(l.solid.clone()), l.colour)).collect();
        let visuals = match looks.as_slice() {
            // Boxes look like the mesh that they are, and are less to load.
            [look] if are_boxes => boxes(&pieces).map(|b| (b, look.colour)).collect(),
            [] => {
                let colour = class_colour(class);
                pieces.iter().map(|p| (self.part(p), colour)).collect()
            }
            _ => looks.into_iter().map(|l| (Part::Mesh(self.place(l.solid, Some(l.colour))), l.colour)).collect(),
        };
        let collisions = pieces.iter().map(|p| self.part(p)).collect();
        Link { element, name: link, visuals, shown, collisions, pieces: facts }
    }

    fn part(&mut self, piece: &Piece) -> Part {
        match &piece.shape {
            Shape::Box(b) => Part::Box(*b),
            Shape::Hull(hull) => Part::Mesh(self.place(Solid::of_metres(&hull.vertices_m, hull.faces.clone()), None)),
        }
    }

    fn place(&mut self, solid: Solid, colour: Option<Rgba>) -> Placed {
        let placed = self.store.place(solid);
        if placed.mesh == self.materials.len() {
            self.materials.push(colour);
        }
        placed
    }
}

fn boxes(pieces: &[Piece]) -> impl Iterator<Item = Part> {
    pieces.iter().filter_map(|p| match &p.shape {
        Shape::Box(b) => Some(Part::Box(*b)),
        Shape::Hull(_) => None,
    })
}

/// The doors of the world, and those that hang and are not in it.
fn hung_doors(
    input: &ExportInput<'_>,
    options: &WorldOptions,
    statics: &[Static],
    barred: &BTreeSet<u32>,
) -> (Vec<WorldDoor>, Vec<(u32, &'static str)>) {
    if options.doors == DoorMode::Passable {
        let hung = (0..).zip(input.site.doors).filter(|(_, d)| is_door(input, d.element) && hangs(input, d));
        return (Vec::new(), hung.map(|(k, _)| (k, "passable")).collect());
    }
    let doors = doors::doors(input, options, statics);
    let (out, doors): (Vec<_>, Vec<_>) = doors.into_iter().partition(|d| barred.contains(&d.door));
    (doors, out.into_iter().map(|d| (d.door, "barred")).collect())
}

/// The waypoint that comes first.
fn spawn(input: &ExportInput<'_>) -> Option<Spawn> {
    let first = input.plan.waypoints.iter().min_by_key(|w| w.order)?;
    Some(Spawn {
        at_m: first.position_in_map_m.map(rounded),
        yaw_rad: first.yaw_rad,
        waypoint: first.id,
        storey: first.map_storey,
    })
}
