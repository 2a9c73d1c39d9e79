//! `site.usda`: the world as USD, a prim per element, with bodies that collide and doors on joints of UsdPhysics.
//!
//! Each mesh is there once, in `/site/meshes`, and referred to; what is seen is that of `site.glb`, what collides that of `world.sdf`,
//! joints are those of `doors.urdf`.

use crate::door_links::{Board, JointKind, Link, pose_at};
use crate::doors::WorldDoor;
use crate::meshes::{PlacedMesh, Solid, UNITS_PER_M, number};
use crate::options::DoorMode;
use crate::scene::{Model, Part, Scene, StaticLink};
use crate::sdf::{angles, mass_of};
use crate::usda::{Names, Usda, quoted, tuple};
use crate::visuals::{Rgba, class_colour, linear};
use convex::ConvexBox;
use grid::Class;
use std::collections::{BTreeMap, BTreeSet};

/// Name of the default prim.
const SITE: &str = "site";

/// The file.
pub(crate) fn site(scene: &Scene<'_>) -> String {
    let mut writer = Writer { usda: Usda::new(SITE), meshes: MeshNumbers::of(scene) };
    let mut names = Names::default();
    writer.usda.open("def Xform", &names.take(SITE), "kind = \"assembly\"");
    writer.usda.open("def PhysicsScene", &names.take("physics"), "");
    writer.usda.line("vector3f physics:gravityDirection = (0, 0, -1)");
    writer.usda.line("float physics:gravityMagnitude = 9.81");
    writer.usda.close();
    writer.materials(scene, &names.take("materials"));
    writer.meshes(&names.take("meshes"));
    if let Some(spawn) = &scene.spawn {
        writer.usda.open("def Xform", &names.take("robot_spawn"), "");
        writer.usda.pose(spawn.at_m, spawn.yaw_rad);
        writer.usda.close();
    }
    for model in &scene.models {
        writer.model(scene, model, &names.take(&model.name));
    }
    for door in &scene.doors {
        writer.door(scene, door, &names.take(&door.name));
    }
    if !scene.markers_m.is_empty() {
        writer.markers(&scene.markers_m, &names.take("waypoints"));
    }
    writer.usda.close();
    writer.usda.out
}

/// All meshes that are seen or collide, each with a number.
struct MeshNumbers<'a>(BTreeMap<&'a Solid, usize>);

impl<'a> MeshNumbers<'a> {
    fn of(scene: &'a Scene<'_>) -> Self {
        let all: BTreeSet<&Solid> = scene.shown.meshes.iter().chain(&scene.store.meshes).collect();
        Self(all.into_iter().zip(0..).collect())
    }
}

struct Writer<'a> {
    usda: Usda,
    meshes: MeshNumbers<'a>,
}

/// What a shape is there for.
#[derive(Clone, Copy)]
enum Use {
    Seen(Rgba),
    /// Collides as its convex hull, which it is.
    Convex,
    /// Collides with its faces.
    Faces,
}

impl Writer<'_> {
    fn materials(&mut self, scene: &Scene<'_>, name: &str) {
        let links = scene.models.iter().flat_map(|model| &model.links);
        let seen =
            links.flat_map(|link| link.shown.iter().map(|(_, c)| *c).chain(link.visuals.iter().map(|(_, c)| *c)));
        let colours: BTreeSet<Rgba> = seen.chain([class_colour(Class::Door), MARKER]).collect();
        self.usda.open("def Scope", name, "");
        for colour in colours {
            let material = material_name(colour);
            let [r, g, b, a] = colour;
            self.usda.open("def Material", &material, "");
            self.usda
                .line(&format!("token outputs:surface.connect = </{SITE}/{name}/{material}/surface.outputs:surface>"));
            self.usda.open("def Shader", "surface", "");
            self.usda.line("uniform token info:id = \"UsdPreviewSurface\"");
            self.usda.line(&format!("color3f inputs:diffuseColor = {}", tuple([r, g, b].map(linear))));
            self.usda.line(&format!("float inputs:opacity = {}", number((f64::from(a) / 255.0 * 1e4).round() / 1e4)));
            self.usda.line("float inputs:roughness = 0.8");
            self.usda.line("token outputs:surface");
            self.usda.close();
            self.usda.close();
        }
        self.usda.close();
    }

    fn meshes(&mut self, name: &str) {
        self.usda.open("class Scope", name, "");
        let meshes: Vec<(&Solid, usize)> = self.meshes.0.iter().map(|(solid, number)| (*solid, *number)).collect();
        for (solid, number) in meshes {
            self.usda.open("def Mesh", &format!("m{number}"), "");
            self.mesh(solid);
            self.usda.close();
        }
        self.usda.close();
    }

    fn mesh(&mut self, solid: &Solid) {
        let points: Vec<[f64; 3]> = solid.vertices.iter().map(|v| v.map(|c| c as f64 / UNITS_PER_M)).collect();
        let bound = |pick: fn(f64, f64) -> f64| {
            points.iter().copied().reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))).unwrap_or_default()
        };
        let list = |items: Vec<String>| items.join(", ");
        let counts = solid.faces.iter().map(|face| face.len().to_string()).collect();
        let corners = solid.faces.iter().flatten().map(ToString::to_string).collect();
        self.usda.line(&format!("float3[] extent = [{}, {}]", tuple(bound(f64::min)), tuple(bound(f64::max))));
        self.usda.line(&format!("int[] faceVertexCounts = [{}]", list(counts)));
        self.usda.line(&format!("int[] faceVertexIndices = [{}]", list(corners)));
        self.usda.line(&format!("point3f[] points = [{}]", list(points.into_iter().map(tuple).collect())));
        self.usda.line("uniform token subdivisionScheme = \"none\"");
        self.usda.line("uniform bool doubleSided = 1");
    }

    fn model(&mut self, scene: &Scene<'_>, model: &Model, name: &str) {
        self.usda.open("def Xform", name, "kind = \"group\"");
        let mut names = Names::default();
        for link in &model.links {
            self.element(scene, model.class, link, &names.take(&link.name));
        }
        self.usda.close();
    }

    fn element(&mut self, scene: &Scene<'_>, class: Class, link: &StaticLink, name: &str) {
        self.usda.open("def Xform", name, LABELLED);
        self.identity(link.body.global_id(scene.input.site), class);
        for (k, (placed, colour)) in link.shown.iter().enumerate() {
            let solid = &scene.shown.meshes[placed.mesh];
            self.placed(solid, *placed, &format!("seen_{k}"), Use::Seen(*colour));
        }
        let visuals = if link.shown.is_empty() { link.visuals.as_slice() } else { &[] };
        for (k, (part, colour)) in visuals.iter().enumerate() {
            self.part(scene, part, &format!("seen_{k}"), Use::Seen(*colour));
        }
        let collides = if link.plates.is_some() { Use::Faces } else { Use::Convex };
        for (k, part) in link.collisions.iter().enumerate() {
            self.part(scene, part, &format!("collides_{k}"), collides);
        }
        self.usda.close();
    }

    /// What an element is, for whoever looks at the prim.
    fn identity(&mut self, global_id: Option<&str>, class: Class) {
        if let Some(id) = global_id {
            self.usda.line(&format!("custom string ifc:globalId = {}", quoted(id)));
        }
        self.usda.line(&format!("token[] semantics:labels:class = [{}]", quoted(class.name())));
    }

    fn part(&mut self, scene: &Scene<'_>, part: &Part, name: &str, purpose: Use) {
        match part {
            Part::Mesh(placed) => self.placed(&scene.store.meshes[placed.mesh], *placed, name, purpose),
            Part::Box(b) => self.cube(b, name, purpose),
        }
    }

    fn placed(&mut self, solid: &Solid, placed: PlacedMesh, name: &str, purpose: Use) {
        let number = self.meshes.0[solid];
        let reference = format!("prepend references = </{SITE}/meshes/m{number}>");
        let (schemas, approximation) = match purpose {
            Use::Seen(_) => ("MaterialBindingAPI", None),
            Use::Convex => ("PhysicsCollisionAPI\", \"PhysicsMeshCollisionAPI", Some("convexHull")),
            Use::Faces => ("PhysicsCollisionAPI\", \"PhysicsMeshCollisionAPI", Some("none")),
        };
        self.usda.open("def Mesh", name, &format!("prepend apiSchemas = [\"{schemas}\"]; {reference}"));
        self.purpose(purpose);
        if let Some(approximation) = approximation {
            self.usda.line(&format!("uniform token physics:approximation = \"{approximation}\""));
        }
        self.usda.pose(placed.shift_m, placed.yaw_rad());
        self.usda.close();
    }

    /// A box: a cube with sides of a metre, scaled.
    fn cube(&mut self, b: &ConvexBox, name: &str, purpose: Use) {
        let schema = if matches!(purpose, Use::Seen(_)) { "MaterialBindingAPI" } else { "PhysicsCollisionAPI" };
        self.usda.open("def Cube", name, &format!("prepend apiSchemas = [\"{schema}\"]"));
        self.purpose(purpose);
        self.usda.line("double size = 1");
        self.usda.line("float3[] extent = [(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)]");
        match purpose {
            // As in site.glb.
            Use::Seen(_) => {
                let axis = |k: usize| [b.axes[k][0], b.axes[k][1], b.axes[k][2], 0.0].map(|c| c * b.size_m[k]);
                let [x, y, z] = b.centre_m;
                let rows = [axis(0), axis(1), axis(2), [x, y, z, 1.0]].map(tuple).join(", ");
                self.usda.line(&format!("matrix4d xformOp:transform = ({rows})"));
                self.usda.line("uniform token[] xformOpOrder = [\"xformOp:transform\"]");
            }
            // As in world.sdf: engines take no box whose sides lean by the rounding of its corners.
            Use::Convex | Use::Faces => {
                self.usda.line(&format!("double3 xformOp:translate = {}", tuple(b.centre_m)));
                self.usda.line(&format!("double3 xformOp:rotateXYZ = {}", tuple(angles(b).map(f64::to_degrees))));
                self.usda.line(&format!("double3 xformOp:scale = {}", tuple(b.size_m)));
                let order = ["translate", "rotateXYZ", "scale"].map(|op| format!("\"xformOp:{op}\"")).join(", ");
                self.usda.line(&format!("uniform token[] xformOpOrder = [{order}]"));
            }
        }
        self.usda.close();
    }

    fn purpose(&mut self, purpose: Use) {
        match purpose {
            Use::Seen(colour) => {
                self.usda.line(&format!("rel material:binding = </{SITE}/materials/{}>", material_name(colour)));
                let [r, g, b, _] = colour;
                self.usda.line(&format!("color3f[] primvars:displayColor = [{}]", tuple([r, g, b].map(linear))));
            }
            Use::Convex | Use::Faces => self.usda.line("uniform token purpose = \"guide\""),
        }
    }

    /// A door: its lining, and its leaves as bodies beside each other, joined as they hang.
    fn door(&mut self, scene: &Scene<'_>, door: &WorldDoor, name: &str) {
        let is_movable = scene.options.doors == DoorMode::Movable;
        let values = door.values(scene.options.doors);
        let site = scene.input.site;
        self.usda.open("def Xform", name, LABELLED);
        self.identity(Some(site.text(site.elements[door.element as usize].global_id)), Class::Door);
        self.usda.pose(door.origin_m, door.yaw_rad);
        self.usda.open("def Xform", "frame", "");
        self.boards(&door.lining);
        self.usda.close();
        for (k, link) in door.links.iter().enumerate() {
            let (at, yaw) = pose_at(&door.links, k, &values);
            let schemas = "prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"]";
            self.usda.open("def Xform", &link.name, if is_movable { schemas } else { "" });
            if is_movable {
                self.mass(scene, link);
            }
            self.usda.pose(at, yaw);
            self.boards(&link.boards);
            self.usda.close();
            if is_movable {
                self.joint(scene, door, link, &format!("/{SITE}/{name}"));
            }
        }
        self.usda.close();
    }

    fn boards(&mut self, boards: &[Board]) {
        for (kind, purpose) in [("seen", Use::Seen(class_colour(Class::Door))), ("collides", Use::Convex)] {
            for (k, board) in boards.iter().enumerate() {
                let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                let level = ConvexBox { centre_m: board.centre_m, axes, size_m: board.size_m };
                self.cube(&level, &format!("{kind}_{k}"), purpose);
            }
        }
    }

    fn mass(&mut self, scene: &Scene<'_>, link: &Link) {
        let (mass_kg, centre_m, moments) = mass_of(link, scene.options.door.density_kg_m3);
        self.usda.line(&format!("float physics:mass = {}", number(mass_kg)));
        self.usda.line(&format!("point3f physics:centerOfMass = {}", tuple(centre_m)));
        self.usda.line(&format!("float3 physics:diagonalInertia = {}", tuple(moments)));
        self.usda.line("quatf physics:principalAxes = (1, 0, 0, 0)");
    }

    /// USD has joints along and about axes that point in positive directions: both ends are turned where ours does not.
    fn joint(&mut self, scene: &Scene<'_>, door: &WorldDoor, link: &Link, path: &str) {
        let (parent, from) = match link.parent {
            Some(parent) => (door.links[parent].name.as_str(), door.links[parent].at_m),
            None => ("frame", [0.0; 3]),
        };
        let is_along_z = link.axis[2] != 0.0;
        let turn = match (link.axis.iter().sum::<f64>() < 0.0, is_along_z) {
            (false, _) => "(1, 0, 0, 0)",
            (true, true) => "(0, 1, 0, 0)",
            (true, false) => "(0, 0, 0, 1)",
        };
        let (kind, drive) = match link.kind {
            JointKind::Revolute => ("PhysicsRevoluteJoint", "angular"),
            JointKind::Prismatic => ("PhysicsPrismaticJoint", "linear"),
            JointKind::Fixed => ("PhysicsFixedJoint", ""),
        };
        let schemas = format!("prepend apiSchemas = [\"PhysicsDriveAPI:{drive}\"]");
        let name = format!("{}_joint", link.name);
        self.usda.open(&format!("def {kind}"), &name, if drive.is_empty() { "" } else { &schemas });
        self.usda.line(&format!("rel physics:body0 = <{path}/{parent}>"));
        self.usda.line(&format!("rel physics:body1 = <{path}/{}>", link.name));
        self.usda.line(&format!("point3f physics:localPos0 = {}", tuple([0, 1, 2].map(|k| link.at_m[k] - from[k]))));
        self.usda.line("point3f physics:localPos1 = (0, 0, 0)");
        self.usda.line(&format!("quatf physics:localRot0 = {turn}"));
        self.usda.line(&format!("quatf physics:localRot1 = {turn}"));
        if !drive.is_empty() {
            let is_revolute = link.kind == JointKind::Revolute;
            let in_unit = |value: f64| if is_revolute { value.to_degrees() } else { value };
            let damping = scene.options.door.damping;
            // Torque for each degree in a second.
            let damping = if is_revolute { damping.to_radians() } else { damping };
            self.usda.line(&format!("uniform token physics:axis = \"{}\"", if is_along_z { "Z" } else { "X" }));
            self.usda.line(&format!("float physics:lowerLimit = {}", number(in_unit(link.limits[0]))));
            self.usda.line(&format!("float physics:upperLimit = {}", number(in_unit(link.limits[1]))));
            self.usda.line(&format!("float drive:{drive}:physics:damping = {}", number(damping)));
        }
        self.usda.close();
    }

    /// Waypoints as discs: they are seen and not met.
    fn markers(&mut self, places_m: &[[f64; 3]], name: &str) {
        self.usda.open("def Xform", name, "");
        for (k, [x, y, z]) in places_m.iter().enumerate() {
            self.usda.open("def Cylinder", &format!("w{k}"), "prepend apiSchemas = [\"MaterialBindingAPI\"]");
            self.purpose(Use::Seen(MARKER));
            self.usda.line("uniform token axis = \"Z\"");
            self.usda.line("double height = 0.02");
            self.usda.line("double radius = 0.1");
            self.usda.line("float3[] extent = [(-0.1, -0.1, -0.01), (0.1, 0.1, 0.01)]");
            self.usda.pose([*x, *y, z + 0.01], 0.0);
            self.usda.close();
        }
        self.usda.close();
    }
}

const MARKER: Rgba = [220, 40, 40, 255];

/// What cameras that segment read.
const LABELLED: &str = "kind = \"component\"; prepend apiSchemas = [\"SemanticsLabelsAPI:class\"]";

fn material_name(colour: Rgba) -> String {
    format!("c{:08x}", u32::from_be_bytes(colour))
}
