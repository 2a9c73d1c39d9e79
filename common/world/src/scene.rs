//! The content of a world: static models by class and storey, doors, meshes, start of the robot.

use crate::collision_meshes::{CollisionMesh, Replacement};
use crate::doors::{self, WorldDoor, is_door, is_hung};
use crate::findings;
use crate::ground_bodies::ground_bodies;
use crate::ground_faces::GroundFaces;
use crate::meshes::{MeshStore, PlacedMesh, Solid};
use crate::options::{DoorMode, WorldOptions};
use crate::stand_ins;
use crate::static_elements::{self, Body, StaticElement};
use crate::visuals::{self, Rgba, class_colour};
use convex::{ConvexBox, Hull, LATTICE_PER_M, Made, Piece, Shape};
use export::{ExportInput, rounded};
use grid::Class;
use messages::Diagnostic;
use std::collections::{BTreeMap, BTreeSet};

/// Exact boxes up to which an element is also shown as boxes.
const BOXES_SHOWN_MAX: usize = 8;

/// The content of a world.
pub(crate) struct Scene<'a> {
    pub(crate) input: &'a ExportInput<'a>,
    pub(crate) options: &'a WorldOptions,
    pub(crate) store: MeshStore,
    /// Meshes of the elements for viewers.
    pub(crate) shown: MeshStore,
    /// Material of each mesh of the store; `None` for those that only collide.
    pub(crate) materials: Vec<Option<Rgba>>,
    pub(crate) models: Vec<Model>,
    pub(crate) doors: Vec<WorldDoor>,
    /// Doors that hang and are not in the world, and why.
    pub(crate) left_out: Vec<(u32, &'static str)>,
    /// Elements that are not, or not quite, in the world as they are cut.
    pub(crate) diagnostics: Vec<Diagnostic>,
    pub(crate) spawn: Option<SpawnPose>,
    pub(crate) markers_m: Vec<[f64; 3]>,
}

/// A static model: a class on a storey.
pub(crate) struct Model {
    pub(crate) name: String,
    pub(crate) class: Class,
    pub(crate) storey: u32,
    pub(crate) links: Vec<StaticLink>,
}

/// The link of an element, terrain or a stand-in.
pub(crate) struct StaticLink {
    pub(crate) body: Body,
    pub(crate) name: String,
    pub(crate) visuals: Vec<(Part, Rgba)>,
    /// The element's own meshes, for viewers.
    pub(crate) shown: Vec<(PlacedMesh, Rgba)>,
    pub(crate) collisions: Vec<Part>,
    pub(crate) pieces: Vec<PieceInfo>,
    /// Convex plates under the faces of ground, which collides as one mesh that is not convex; `None` for all else.
    pub(crate) plates: Option<Vec<Hull>>,
}

/// Accuracy of a piece, for `lookup.json`.
#[derive(Clone, Copy)]
pub(crate) struct PieceInfo {
    pub(crate) made: Made,
    pub(crate) is_box: bool,
    pub(crate) deviation_m: f64,
}

/// A shape in `map`.
#[derive(Clone, Copy)]
pub(crate) enum Part {
    Box(ConvexBox),
    Mesh(PlacedMesh),
}

/// Start of the robot: the first waypoint.
pub(crate) struct SpawnPose {
    pub(crate) at_m: [f64; 3],
    pub(crate) yaw_rad: f64,
    pub(crate) waypoint: u32,
    pub(crate) storey: u32,
}

impl<'a> Scene<'a> {
    /// The scene of these archives.
    pub(crate) fn of(input: &'a ExportInput<'a>, options: &'a WorldOptions) -> Self {
        let mut barriers = if options.barriers { stand_ins::barriers(input) } else { Vec::new() };
        let is_movable = |element: u32| is_door(input, element);
        let mut statics = static_elements::statics(input, options, is_movable);
        statics.extend(ground_bodies(input, options));
        statics.sort_by_key(|part| part.body);
        statics.extend(stand_ins::assumed_floors(input));
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
            diagnostics: Vec::new(),
            spawn: spawn(input),
            markers_m: Vec::new(),
        };
        if options.markers {
            scene.markers_m = input.mission_plan.waypoints.iter().map(|w| w.position_in_map_m.map(rounded)).collect();
        }
        scene.add_models(statics);
        scene
    }

    /// A model for each class on each storey.
    fn add_models(&mut self, statics: Vec<StaticElement>) {
        let mut groups: BTreeMap<(u32, Class), Vec<StaticLink>> = BTreeMap::new();
        for part in statics {
            let group = (part.storey, part.class);
            let link = self.link(part);
            if !link.collisions.is_empty() {
                groups.entry(group).or_default().push(link);
            }
        }
        let model = |((storey, class), links): ((u32, Class), Vec<StaticLink>)| Model {
            name: format!("{storey:02}_{}", class.name()),
            class,
            storey,
            links,
        };
        self.models = groups.into_iter().map(model).collect();
    }

    /// The link of ground: one mesh that is seen and collides, whose faces are those of the body.
    fn ground_link(&mut self, body: Body, name: String, ground: &GroundFaces, pieces: Vec<Piece>) -> StaticLink {
        let looks = visuals::coloured_ground(self.options, ground);
        let shown = looks.iter().map(|l| (self.shown.place(l.solid.clone()), l.colour)).collect();
        let visuals = looks.into_iter().map(|l| (Part::Mesh(self.place(l.solid, Some(l.colour))), l.colour)).collect();
        let solid = visuals::exact(ground.faces());
        let is_there = !solid.faces.is_empty();
        let collisions = if is_there { vec![Part::Mesh(self.place(solid, None))] } else { Vec::new() };
        let plates = Some(pieces.into_iter().map(|p| p.shape.hull()).collect());
        self.diagnostics.extend((!is_there).then(|| findings::of_far_ground(self.input, body)));
        StaticLink { body, name, visuals, shown, collisions, pieces: Vec::new(), plates }
    }

    fn link(&mut self, part: StaticElement) -> StaticLink {
        let StaticElement { body, link, class, pieces, ground, .. } = part;
        if let Some(ground) = ground {
            return self.ground_link(body, link, &ground, pieces);
        }
        let info = |p: &Piece| PieceInfo { made: p.made, is_box: p.shape.is_box(), deviation_m: p.deviation_m };
        let mut infos: Vec<PieceInfo> = pieces.iter().map(info).collect();
        let are_boxes = infos.iter().all(|f| f.is_box && f.made == Made::Exact) && infos.len() <= BOXES_SHOWN_MAX;
        let coloured_meshes = match body {
            Body::Element(k) => {
                visuals::coloured_meshes(self.input, self.options, &self.input.site.elements[k as usize])
            }
            Body::Terrain(_) | Body::StandIn => Vec::new(),
        };
        let shown = coloured_meshes.iter().map(|l| (self.shown.place(l.solid.clone()), l.colour)).collect();
        let looks_like_mesh = !coloured_meshes.is_empty();
        let mut visuals: Vec<(Part, Rgba)> = match coloured_meshes.as_slice() {
            // Boxes look like the mesh that they are, and are less to load.
            [look] if are_boxes => boxes(&pieces).map(|b| (b, look.colour)).collect(),
            _ => coloured_meshes
                .into_iter()
                .map(|l| (Part::Mesh(self.place(l.solid, Some(l.colour))), l.colour))
                .collect(),
        };
        let mut replaced = BTreeMap::new();
        let shapes = pieces.iter().zip(&mut infos);
        let collisions: Vec<Part> = shapes.filter_map(|(p, info)| self.part(p, info, &mut replaced)).collect();
        if !looks_like_mesh {
            visuals = collisions.iter().map(|part| (*part, class_colour(class))).collect();
        }
        self.diagnostics.extend(findings::of_link(self.input, body, &link, pieces.len(), &replaced));
        StaticLink { body, name: link, visuals, shown, collisions, pieces: infos, plates: None }
    }

    /// The shape of a piece that collides; what stands in for it is counted.
    fn part(
        &mut self,
        piece: &Piece,
        info: &mut PieceInfo,
        replaced: &mut BTreeMap<Replacement, usize>,
    ) -> Option<Part> {
        let hull = match &piece.shape {
            // A side that the lattice does not hold would be a side of nothing.
            Shape::Box(b) if b.size_m.iter().all(|side| *side >= 1.0 / LATTICE_PER_M) => return Some(Part::Box(*b)),
            Shape::Box(b) => b.hull(),
            Shape::Hull(hull) => hull.clone(),
        };
        let mesh = CollisionMesh::of(&hull)?;
        info.is_box = false;
        info.deviation_m += mesh.more_deviation_m;
        if let Some(replacement) = mesh.replaced {
            *replaced.entry(replacement).or_default() += 1;
        }
        Some(Part::Mesh(self.place(mesh.solid, None)))
    }

    fn place(&mut self, solid: Solid, colour: Option<Rgba>) -> PlacedMesh {
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
    statics: &[StaticElement],
    barred: &BTreeSet<u32>,
) -> (Vec<WorldDoor>, Vec<(u32, &'static str)>) {
    if options.doors == DoorMode::Passable {
        let hung = (0..).zip(input.site.doors).filter(|(_, d)| is_door(input, d.element) && is_hung(input, d));
        return (Vec::new(), hung.map(|(k, _)| (k, "passable")).collect());
    }
    let doors = doors::doors(input, options, statics);
    let (out, doors): (Vec<_>, Vec<_>) = doors.into_iter().partition(|d| barred.contains(&d.door));
    (doors, out.into_iter().map(|d| (d.door, "barred")).collect())
}

/// The waypoint that comes first.
fn spawn(input: &ExportInput<'_>) -> Option<SpawnPose> {
    let first = input.mission_plan.waypoints.iter().min_by_key(|w| w.order)?;
    Some(SpawnPose {
        at_m: first.position_in_map_m.map(rounded),
        yaw_rad: first.yaw_rad,
        waypoint: first.id,
        storey: first.map_storey,
    })
}
