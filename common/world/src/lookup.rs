//! `world/lookup.json`: models and links of the world by GlobalId.

use crate::door_links::{JointKind, Link as Leaf};
use crate::doors::WorldDoor;
use crate::scene::{Model, Part, Scene, StaticLink};
use crate::static_elements::Body;
use convex::Made;
use export::{rounded, text_or_null};
use messages::Diagnostic;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// What the models and links of a world are, by GlobalId. Lengths in metres in `map`, whose coordinates are those of the world.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Lookup {
    /// Version of this layout: 2.
    version: u32,
    /// `map`: the frame of the maps is that of the world.
    frame: &'static str,
    /// Counts changes of the map frame.
    frame_epoch: u32,
    /// Plan time; null if all elements stand.
    plan_time: Option<String>,
    /// `movable`, `open`, `closed` or `passable`.
    doors_are: &'static str,
    /// Where a robot begins: the first waypoint; null if there is none.
    spawn: Option<Spawn>,
    /// What there is, and how large the files are.
    counts: Counts,
    /// Static models by name.
    models: BTreeMap<String, ModelEntry>,
    /// Elements, sites and roads with a shape of their own by GlobalId; a door that moves is a model of its own.
    elements: BTreeMap<String, Element>,
    /// Links that are no element: floors that maps assume, walls that close blocked spaces.
    stand_ins: Vec<StandIn>,
    /// Doors that hang, by GlobalId.
    doors: BTreeMap<String, Door>,
    /// Doors that hang and are not in the world, by GlobalId: `passable` or `barred`.
    doors_left_out: BTreeMap<String, &'static str>,
    /// Elements that are not in the world, and pieces for which others stand in.
    diagnostics: Vec<Finding>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Finding {
    /// `collision_replaced` or `not_in_world`.
    code: &'static str,
    /// GlobalId of the element; null for a stand-in.
    global_id: Option<String>,
    /// Its name; of a stand-in that of its link.
    name: Option<String>,
    /// One sentence for people.
    message: String,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Spawn {
    /// Index of the map storey.
    storey: u32,
    /// Id of the waypoint.
    waypoint: u32,
    x_m: f64,
    y_m: f64,
    /// Height of the floor.
    z_m: f64,
    yaw_rad: f64,
}

#[derive(Debug, Default, Serialize, JsonSchema)]
struct Counts {
    models: usize,
    links: usize,
    /// Convex pieces that collide, leaves not counted.
    collisions: usize,
    /// Those of them that are boxes.
    boxes: usize,
    /// Those that are exactly that part of the body but for rounding.
    exact: usize,
    /// Surfaces without thickness that got 2 mm.
    sheets: usize,
    /// Hulls of what is nearly convex.
    hulls: usize,
    /// Pieces of approximate decompositions.
    decomposed: usize,
    /// Farthest that a piece's surface lies from that of its body, in metres.
    worst_deviation_m: f64,
    /// GlobalId of the element with that piece.
    worst_element: Option<String>,
    /// Joints that move.
    moving_joints: usize,
    /// Files with a mesh.
    meshes: usize,
    /// Triangles of these files.
    triangles_in_files: usize,
    /// Triangles that are shown and that collide, repeated meshes counted each time, boxes as twelve.
    triangles_shown: usize,
    triangles_colliding: usize,
    /// Bytes of SDF, OBJ and MTL files.
    world_bytes: usize,
    /// Bytes of the GLB file.
    glb_bytes: usize,
}

#[derive(Debug, Serialize, JsonSchema)]
struct ModelEntry {
    /// Class of its links.
    class: &'static str,
    /// Number of the class: the label of segmentation cameras, and the pixel in `classes.png`.
    label: u8,
    /// Index of the map storey.
    storey: u32,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Element {
    /// Entity name, e.g. `IfcWall`.
    r#type: String,
    /// Name; null if it has none.
    name: Option<String>,
    class: &'static str,
    model: String,
    /// Its link in the model; null for a door, which is a whole model.
    link: Option<String>,
    /// Index of the map storey.
    storey: u32,
    /// How many convex pieces of each kind it is: `exact`, `sheet`, `hull`, `decomposed`; ground outdoors is 1 `mesh` that is not
    /// convex.
    pieces: BTreeMap<&'static str, usize>,
    /// Farthest that a piece's surface lies from that of its body.
    deviation_m: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct StandIn {
    model: String,
    link: String,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Door {
    model: String,
    /// The operation type that it follows; `fixed` if it stays.
    operation: String,
    /// Who says so: `model`, `panels` or `assumed`.
    operation_from: &'static str,
    /// True if the model does not say which side is left and which is the front.
    sides_assumed: bool,
    width_m: f64,
    height_m: f64,
    /// What leaves were drawn in at each side, so as not to cut into what stands beside the opening.
    inset_m: f64,
    leaves: Vec<LeafEntry>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct LeafEntry {
    link: String,
    joint: String,
    /// `revolute`, `prismatic` or `fixed`.
    kind: &'static str,
    /// Axis in the door's frame.
    axis: [f64; 3],
    /// Lower and upper limit of a joint that turns, 0 being closed; null for the others.
    limits_rad: Option<[f64; 2]>,
    /// Lower and upper limit of a joint that slides, 0 being closed; null for the others.
    limits_m: Option<[f64; 2]>,
    /// Names of what ends the motion early, at the lower and the upper limit; null where nothing does.
    ended_by: [Option<String>; 2],
    /// True if the true motion is another one.
    approximate: bool,
}

impl Lookup {
    pub(super) fn of(scene: &Scene<'_>, [world_bytes, glb_bytes]: [usize; 2]) -> Self {
        let (site, schedule_state) = (scene.input.site, scene.input.schedule_state);
        let id = |element: u32| site.text(site.elements[element as usize].global_id).to_owned();
        let mut elements = BTreeMap::new();
        let mut stand_ins = Vec::new();
        for (model, link) in scene.models.iter().flat_map(|m| m.links.iter().map(move |l| (m, l))) {
            match link.body.global_id(site) {
                Some(id) => drop(elements.insert(id.to_owned(), Element::of(scene, model, link))),
                None => stand_ins.push(StandIn { model: model.name.clone(), link: link.name.clone() }),
            }
        }
        for door in &scene.doors {
            elements.insert(id(door.element), Element::of_door(scene, door));
        }
        let model =
            |m: &Model| (m.name.clone(), ModelEntry { class: m.class.name(), label: m.class.id(), storey: m.storey });
        let left_out = scene.left_out.iter().map(|(door, why)| (id(site.doors[*door as usize].element), *why));
        Self {
            version: 2,
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            plan_time: schedule_state.head.plan_time().map(|t| t.to_string()),
            doors_are: scene.options.doors.name(),
            spawn: scene.spawn.as_ref().map(|s| Spawn {
                storey: s.storey,
                waypoint: s.waypoint,
                x_m: s.at_m[0],
                y_m: s.at_m[1],
                z_m: s.at_m[2],
                yaw_rad: rounded(s.yaw_rad),
            }),
            counts: Counts { world_bytes, glb_bytes, ..Counts::of(scene) },
            models: scene.models.iter().map(model).collect(),
            elements,
            stand_ins,
            doors: scene.doors.iter().map(|d| (id(d.element), Door::of(d))).collect(),
            doors_left_out: left_out.collect(),
            diagnostics: scene.diagnostics.iter().map(Finding::of).collect(),
        }
    }
}

impl Finding {
    fn of(diagnostic: &Diagnostic) -> Self {
        let entity = diagnostic.entity.as_ref();
        Self {
            code: diagnostic.code.name(),
            global_id: entity.and_then(|e| text_or_null(&e.global_id)),
            name: entity.and_then(|e| text_or_null(&e.name)),
            message: diagnostic.message.clone(),
        }
    }
}

impl Element {
    fn of(scene: &Scene<'_>, model: &Model, link: &StaticLink) -> Self {
        let mut pieces = BTreeMap::new();
        for piece in &link.pieces {
            *pieces.entry(made_word(piece.made)).or_insert(0) += 1;
        }
        if link.plates.is_some() {
            pieces.insert("mesh", link.collisions.len());
        }
        let worst = link.pieces.iter().map(|p| p.deviation_m).fold(0.0, f64::max);
        Self {
            link: Some(link.name.clone()),
            pieces,
            deviation_m: rounded(worst),
            ..Self::plain(scene, link.body, model.name.clone(), model.storey)
        }
    }

    fn of_door(scene: &Scene<'_>, door: &WorldDoor) -> Self {
        Self::plain(scene, Body::Element(door.element), door.name.clone(), door.storey)
    }

    fn plain(scene: &Scene<'_>, body: Body, model: String, storey: u32) -> Self {
        let site = scene.input.site;
        let [_, name, ifc_type] = body.texts(site).unwrap_or_default();
        Self {
            r#type: site.text(ifc_type).to_owned(),
            name: text_or_null(site.text(name)),
            class: body.class(site).name(),
            model,
            link: None,
            storey,
            pieces: BTreeMap::new(),
            deviation_m: 0.0,
        }
    }
}

fn made_word(made: Made) -> &'static str {
    match made {
        Made::Exact => "exact",
        Made::Sheet => "sheet",
        Made::Hull => "hull",
        Made::Decomposed => "decomposed",
    }
}

impl Door {
    fn of(door: &WorldDoor) -> Self {
        let leaf = |(leaf, stopped_by): (&Leaf, &[Option<String>; 2])| LeafEntry {
            link: leaf.name.clone(),
            joint: format!("{}_joint", leaf.name),
            kind: leaf.kind.name(),
            axis: leaf.axis.map(rounded),
            limits_rad: (leaf.kind == JointKind::Revolute).then(|| leaf.limits.map(rounded)),
            limits_m: (leaf.kind == JointKind::Prismatic).then(|| leaf.limits.map(rounded)),
            ended_by: stopped_by.clone(),
            approximate: leaf.approximate,
        };
        Self {
            model: door.name.clone(),
            operation: door.operation.clone(),
            operation_from: door.source.name(),
            sides_assumed: door.sides_assumed,
            width_m: rounded(door.opening.width_m),
            height_m: rounded(door.opening.z_m[1]),
            inset_m: door.inset_m,
            leaves: door.links.iter().zip(&door.stopped_by).map(leaf).collect(),
        }
    }
}

impl Counts {
    fn of(scene: &Scene<'_>) -> Self {
        let links: Vec<&StaticLink> = scene.models.iter().flat_map(|m| &m.links).collect();
        let pieces = || links.iter().flat_map(|l| &l.pieces);
        let made = |made: Made| pieces().filter(|p| p.made == made).count();
        let worst = links.iter().flat_map(|l| l.pieces.iter().map(move |p| (p.deviation_m, l.body)));
        let worst = worst.fold((0.0, Body::StandIn), |a, b| if b.0 > a.0 { b } else { a });
        let site = scene.input.site;
        let leaves = || scene.doors.iter().flat_map(|d| &d.links);
        let leaf_triangles: usize = leaves().map(|l| 12 * l.boards.len()).sum();
        let triangles = |part: &Part| match part {
            Part::Box(_) => 12,
            Part::Mesh(placed) => scene.store.meshes[placed.mesh].n_triangles(),
        };
        Self {
            models: scene.models.len() + scene.doors.len(),
            links: links.len() + scene.doors.iter().map(|d| 1 + d.links.len()).sum::<usize>(),
            collisions: pieces().count(),
            boxes: pieces().filter(|p| p.is_box).count(),
            exact: made(Made::Exact),
            sheets: made(Made::Sheet),
            hulls: made(Made::Hull),
            decomposed: made(Made::Decomposed),
            worst_deviation_m: rounded(worst.0),
            worst_element: worst.1.global_id(site).map(str::to_owned),
            moving_joints: leaves().filter(|l| l.kind != JointKind::Fixed).count(),
            meshes: scene.store.meshes.len(),
            triangles_in_files: scene.store.meshes.iter().map(|m| m.n_triangles()).sum(),
            triangles_shown: links.iter().flat_map(|l| &l.visuals).map(|(p, _)| triangles(p)).sum::<usize>()
                + leaf_triangles,
            triangles_colliding: links.iter().flat_map(|l| &l.collisions).map(triangles).sum::<usize>()
                + leaf_triangles,
            world_bytes: 0,
            glb_bytes: 0,
        }
    }
}
