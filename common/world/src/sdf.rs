//! The world as SDF.

use crate::door_links::{Board, JointKind, Link, pose_at};
use crate::meshes::{PlacedMesh, number};
use crate::options::{DoorMode, DoorOptions};
use crate::scene::{Model, Part, Scene, SpawnPose};
use crate::visuals::{Rgba, class_colour};
use convex::ConvexBox;
use grid::Class;
use std::fmt::Write;

/// Mass of the door frame, which never moves.
const FRAME_KG: f64 = 5.0;

/// Mass of rising leaves without their counterweight.
const BALANCED_KG: f64 = 2.0;

/// Most that a joint can be pushed: N m, N; and its speed: rad/s, m/s.
const EFFORT: f64 = 200.0;
const VELOCITY: f64 = 2.0;

/// Text of SDF, an element a line.
struct Xml {
    out: String,
    depth: usize,
}

impl Xml {
    fn line(&mut self, text: &str) {
        for _ in 0..self.depth {
            self.out.push(' ');
        }
        self.out.push_str(text);
        self.out.push('\n');
    }

    fn open(&mut self, text: &str) {
        self.line(text);
        self.depth += 1;
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(&format!("</{name}>"));
    }
}

/// The text without what XML reserves.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// `world.sdf`.
pub(crate) fn world(scene: &Scene<'_>) -> String {
    let mut xml = Xml { out: String::new(), depth: 0 };
    xml.line("<?xml version=\"1.0\"?>");
    xml.open("<sdf version=\"1.9\">");
    xml.open("<world name=\"groundplan\">");
    xml.line(
        "<light name=\"sun\" type=\"directional\"><pose>0 0 50 0 0 0</pose><cast_shadows>true</cast_shadows>\
         <diffuse>0.8 0.8 0.8 1</diffuse><specular>0.2 0.2 0.2 1</specular><direction>-0.4 0.3 -0.9</direction></light>",
    );
    if let Some(SpawnPose { at_m: [x, y, z], yaw_rad, .. }) = &scene.spawn {
        let pose = pose([*x, *y, *z], [0.0, 0.0, *yaw_rad]);
        xml.line(&format!("<frame name=\"robot_spawn\">{pose}</frame>"));
    }
    scene.models.iter().for_each(|m| static_model(&mut xml, m));
    scene.doors.iter().for_each(|d| door(&mut xml, scene, d));
    if !scene.markers_m.is_empty() {
        markers(&mut xml, &scene.markers_m);
    }
    xml.close("world");
    xml.close("sdf");
    xml.out
}

fn label(xml: &mut Xml, class: Class) {
    let id = class.id();
    xml.line(&format!(
        "<plugin filename=\"gz-sim-label-system\" name=\"gz::sim::systems::Label\"><label>{id}</label></plugin>"
    ));
}

fn static_model(xml: &mut Xml, model: &Model) {
    xml.open(&format!("<model name=\"{}\">", escaped(&model.name)));
    xml.line("<static>true</static>");
    label(xml, model.class);
    for link in &model.links {
        xml.open(&format!("<link name=\"{}\">", escaped(&link.name)));
        for (k, (part, colour)) in link.visuals.iter().enumerate() {
            shape(xml, "visual", k, part, Some(*colour));
        }
        for (k, part) in link.collisions.iter().enumerate() {
            shape(xml, "collision", k, part, None);
        }
        xml.close("link");
    }
    xml.close("model");
}

fn shape(xml: &mut Xml, kind: &str, k: usize, part: &Part, colour: Option<Rgba>) {
    let (pose, geometry) = match part {
        Part::Box(b) => (pose(b.centre_m, angles(b)), box_of(b.size_m)),
        Part::Mesh(placed) => (pose(placed.shift_m, [0.0, 0.0, placed.yaw_rad()]), mesh_of(placed)),
    };
    let material = colour.map(material).unwrap_or_default();
    let letter = &kind[..1];
    xml.line(&format!("<{kind} name=\"{letter}{k}\">{pose}{geometry}{material}</{kind}>"));
}

fn box_of([x, y, z]: [f64; 3]) -> String {
    let [x, y, z] = [x, y, z].map(number);
    format!("<geometry><box><size>{x} {y} {z}</size></box></geometry>")
}

fn mesh_of(placed: &PlacedMesh) -> String {
    format!("<geometry><mesh><uri>{}</uri></mesh></geometry>", uri(placed.mesh))
}

/// Path of a mesh beside the world.
pub(crate) fn uri(mesh: usize) -> String {
    format!("meshes/{mesh}.obj")
}

fn pose([x, y, z]: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> String {
    let [x, y, z, roll, pitch, yaw] = [x, y, z, roll, pitch, yaw].map(number);
    if [&x, &y, &z, &roll, &pitch, &yaw].iter().all(|n| *n == "0") {
        return String::new();
    }
    format!("<pose>{x} {y} {z} {roll} {pitch} {yaw}</pose>")
}

/// Roll, pitch and yaw about the fixed axes of the world, in this order.
pub(crate) fn angles(b: &ConvexBox) -> [f64; 3] {
    let [x, y, z] = b.axes;
    let pitch = libm::asin((-x[2]).clamp(-1.0, 1.0));
    [libm::atan2(y[2], z[2]), pitch, libm::atan2(x[1], x[0])]
}

fn material(colour: Rgba) -> String {
    let [r, g, b, a] = colour.map(|c| number((f64::from(c) / 255.0 * 1000.0).round() / 1000.0));
    let transparency = if colour[3] < 255 {
        format!("<transparency>{}</transparency>", number((1000.0 - f64::from(colour[3]) / 0.255).round() / 1000.0))
    } else {
        String::new()
    };
    let rgba = format!("{r} {g} {b} {a}");
    format!("<material><ambient>{rgba}</ambient><diffuse>{rgba}</diffuse></material>{transparency}")
}

/// A door, as a model of its own: static models with joints do not move.
fn door(xml: &mut Xml, scene: &Scene<'_>, door: &crate::doors::WorldDoor) {
    let movable = scene.options.doors == DoorMode::Movable;
    let values = door.values(scene.options.doors);
    xml.open(&format!("<model name=\"{}\">", escaped(&door.name)));
    if !movable {
        xml.line("<static>true</static>");
    }
    xml.line(&pose(door.origin_m, [0.0, 0.0, door.yaw_rad]));
    label(xml, Class::Door);
    xml.open("<link name=\"frame\">");
    if movable {
        xml.line(&inertial([0.0; 3], FRAME_KG, [0.1, 0.1, 0.1]));
    }
    boards(xml, &door.lining);
    xml.close("link");
    if movable {
        xml.line("<joint name=\"anchor\" type=\"fixed\"><parent>world</parent><child>frame</child></joint>");
    }
    for (k, link) in door.links.iter().enumerate() {
        let (at, yaw) = pose_at(&door.links, k, &values);
        xml.open(&format!("<link name=\"{}\">", link.name));
        xml.line(&pose(at, [0.0, 0.0, yaw]));
        if movable {
            if link.axis[2] != 0.0 && link.kind == JointKind::Prismatic {
                xml.line("<gravity>false</gravity>");
            }
            leaf_inertial(xml, link, &scene.options.door);
        }
        boards(xml, &link.boards);
        xml.close("link");
        if movable {
            joint(xml, door, link, &scene.options.door);
        }
    }
    xml.close("model");
}

fn boards(xml: &mut Xml, boards: &[Board]) {
    for (kind, colour) in [("visual", Some(class_colour(Class::Door))), ("collision", None)] {
        for (k, b) in boards.iter().enumerate() {
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let part = Part::Box(ConvexBox { centre_m: b.centre_m, axes, size_m: b.size_m });
            shape(xml, kind, k, &part, colour);
        }
    }
}

/// Mass, centre and moments of inertia (about the centre, level axes) of a link's boards.
pub(crate) fn mass_of(link: &Link, density_kg_m3: f64) -> (f64, [f64; 3], [f64; 3]) {
    let mass = |b: &Board| b.size_m.iter().product::<f64>() * density_kg_m3;
    let total: f64 = link.boards.iter().map(mass).sum();
    let centre = [0, 1, 2].map(|k| link.boards.iter().map(|b| mass(b) * b.centre_m[k]).sum::<f64>() / total);
    // What rises has a counterweight: only the rest is moved.
    let is_balanced = link.kind == JointKind::Prismatic && link.axis[2] != 0.0;
    let scale = if is_balanced { (BALANCED_KG / total).min(1.0) } else { 1.0 };
    // All boards of a link have one middle.
    let moment = |k: usize| -> f64 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        link.boards
            .iter()
            .map(|b| scale * mass(b) * (b.size_m[i] * b.size_m[i] + b.size_m[j] * b.size_m[j]) / 12.0)
            .sum()
    };
    (scale * total, centre, [0, 1, 2].map(moment))
}

fn leaf_inertial(xml: &mut Xml, link: &Link, door_options: &DoorOptions) {
    let (mass, centre, moments) = mass_of(link, door_options.density_kg_m3);
    xml.line(&inertial(centre, mass, moments));
}

fn inertial(centre_m: [f64; 3], mass_kg: f64, [ixx, iyy, izz]: [f64; 3]) -> String {
    let [ixx, iyy, izz, mass] = [ixx, iyy, izz, mass_kg].map(number);
    let pose = pose(centre_m, [0.0; 3]);
    format!(
        "<inertial>{pose}<mass>{mass}</mass><inertia><ixx>{ixx}</ixx><iyy>{iyy}</iyy><izz>{izz}</izz>\
         <ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
    )
}

fn joint(xml: &mut Xml, door: &crate::doors::WorldDoor, link: &Link, door_options: &DoorOptions) {
    let parent = link.parent.map_or("frame", |p| door.links[p].name.as_str());
    let (name, kind) = (format!("{}_joint", link.name), link.kind.name());
    let ends = format!("<parent>{parent}</parent><child>{}</child>", link.name);
    if link.kind == JointKind::Fixed {
        xml.line(&format!("<joint name=\"{name}\" type=\"fixed\">{ends}</joint>"));
        return;
    }
    let mut text = format!("<joint name=\"{name}\" type=\"{kind}\">{ends}<axis>");
    let [x, y, z] = link.axis.map(number);
    let [lower, upper] = link.limits.map(number);
    let [effort, velocity, damping, friction] =
        [EFFORT, VELOCITY, door_options.damping, door_options.friction].map(number);
    write!(
        text,
        "<xyz>{x} {y} {z}</xyz><limit><lower>{lower}</lower><upper>{upper}</upper><effort>{effort}</effort>\
         <velocity>{velocity}</velocity></limit><dynamics><damping>{damping}</damping><friction>{friction}</friction>\
         </dynamics></axis></joint>"
    )
    .expect("memory does not fail");
    xml.line(&text);
}

/// Waypoints as discs: they are seen and not met.
fn markers(xml: &mut Xml, places_m: &[[f64; 3]]) {
    xml.open("<model name=\"waypoints\">");
    xml.line("<static>true</static>");
    xml.open("<link name=\"waypoints\">");
    for (k, [x, y, z]) in places_m.iter().enumerate() {
        let pose = pose([*x, *y, z + 0.01], [0.0; 3]);
        let material = material([220, 40, 40, 255]);
        xml.line(&format!(
            "<visual name=\"w{k}\">{pose}<geometry><cylinder><radius>0.1</radius><length>0.02</length></cylinder></geometry>\
             {material}</visual>"
        ));
    }
    xml.close("link");
    xml.close("model");
}

/// `model.config`, by which simulators find the world and its meshes.
pub(crate) fn model_config() -> String {
    "<?xml version=\"1.0\"?>\n<model>\n <name>groundplan world</name>\n <version>1.0</version>\n \
     <sdf version=\"1.9\">world.sdf</sdf>\n <description>The building at the plan time, in map coordinates</description>\n</model>\n"
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_turn_the_axes_of_a_box_back() {
        let (roll, pitch, yaw): (f64, f64, f64) = (0.3, -0.4, 1.1);
        let (cr, sr, cp, sp, cy, sy) =
            (libm::cos(roll), libm::sin(roll), libm::cos(pitch), libm::sin(pitch), libm::cos(yaw), libm::sin(yaw));
        let axes = [
            [cy * cp, sy * cp, -sp],
            [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
            [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
        ];
        let found = angles(&ConvexBox { centre_m: [0.0; 3], axes, size_m: [1.0; 3] });
        assert!([roll, pitch, yaw].iter().zip(found).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn names_are_escaped() {
        assert_eq!(escaped("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
