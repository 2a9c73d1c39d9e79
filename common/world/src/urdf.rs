//! `doors.urdf`: the doors as one tree of links, for programs that read URDF.

use crate::door_links::{Board, JointKind, Link};
use crate::doors::WorldDoor;
use crate::meshes::number;
use crate::scene::Scene;
use crate::sdf::{escaped, mass_of};
use std::fmt::Write;

/// The file.
pub(super) fn doors(scene: &Scene<'_>) -> String {
    let mut out = String::from("<?xml version=\"1.0\"?>\n<robot name=\"doors\">\n <link name=\"map\"/>\n");
    for door in &scene.doors {
        let name = escaped(&door.name);
        link(&mut out, &name, &door.lining, "");
        let origin = origin(door.origin_m, door.yaw_rad);
        line(
            &mut out,
            &format!(
                "<joint name=\"{name}_anchor\" type=\"fixed\"><parent link=\"map\"/><child link=\"{name}\"/>{origin}</joint>"
            ),
        );
        for leaf in &door.links {
            add_leaf(&mut out, scene, door, &name, leaf);
        }
    }
    out.push_str("</robot>\n");
    out
}

fn add_leaf(out: &mut String, scene: &Scene<'_>, door: &WorldDoor, name: &str, leaf: &Link) {
    let door_options = &scene.options.door;
    let (mass, centre, [ixx, iyy, izz]) = mass_of(leaf, door_options.density_kg_m3);
    let [mass, ixx, iyy, izz] = [mass, ixx, iyy, izz].map(number);
    let at = origin(centre, 0.0);
    let inertial = format!(
        "<inertial>{at}<mass value=\"{mass}\"/><inertia ixx=\"{ixx}\" iyy=\"{iyy}\" izz=\"{izz}\" ixy=\"0\" ixz=\"0\" \
         iyz=\"0\"/></inertial>"
    );
    let own = format!("{name}_{}", leaf.name);
    link(out, &own, &leaf.boards, &inertial);
    let (parent, from) = match leaf.parent {
        Some(p) => (format!("{name}_{}", door.links[p].name), door.links[p].at_m),
        None => (name.to_owned(), [0.0; 3]),
    };
    let origin = origin([0, 1, 2].map(|k| leaf.at_m[k] - from[k]), 0.0);
    let mut joint = format!(
        "<joint name=\"{own}_joint\" type=\"{}\"><parent link=\"{parent}\"/><child link=\"{own}\"/>{origin}",
        leaf.kind.name()
    );
    if leaf.kind != JointKind::Fixed {
        let [x, y, z] = leaf.axis.map(number);
        let [lower, upper, damping, friction] =
            [leaf.limits[0], leaf.limits[1], door_options.damping, door_options.friction].map(number);
        write!(
            joint,
            "<axis xyz=\"{x} {y} {z}\"/><limit lower=\"{lower}\" upper=\"{upper}\" effort=\"200\" velocity=\"2\"/>\
             <dynamics damping=\"{damping}\" friction=\"{friction}\"/>"
        )
        .expect("memory does not fail");
    }
    line(out, &format!("{joint}</joint>"));
}

fn link(out: &mut String, name: &str, boards: &[Board], inertial: &str) {
    let shapes: String = boards
        .iter()
        .map(|b| {
            let [x, y, z] = b.size_m.map(number);
            let shape = format!("{}<geometry><box size=\"{x} {y} {z}\"/></geometry>", origin(b.centre_m, 0.0));
            format!("<visual>{shape}</visual><collision>{shape}</collision>")
        })
        .collect();
    line(out, &format!("<link name=\"{name}\">{inertial}{shapes}</link>"));
}

fn origin(at_m: [f64; 3], yaw_rad: f64) -> String {
    let [x, y, z] = at_m.map(number);
    format!("<origin xyz=\"{x} {y} {z}\" rpy=\"0 0 {}\"/>", number(yaw_rad))
}

fn line(out: &mut String, text: &str) {
    writeln!(out, " {text}").expect("memory does not fail");
}
