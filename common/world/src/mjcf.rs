//! `ground.xml`: the ground outdoors for MuJoCo, which fills the hull of a mesh that collides.
//!
//! Each body is named as the link of `world.sdf`, and has a geom for each convex plate under its faces. Plates are exact where a field
//! of heights is not: at the edge of a pit, on a wall, under a bridge.

use crate::meshes::{MeshStore, Solid, UNITS_PER_M, number};
use crate::scene::{Scene, StaticLink};
use crate::sdf::escaped;
use std::fmt::Write;

/// The file; `None` without ground outdoors.
pub(super) fn ground(scene: &Scene<'_>) -> Option<String> {
    let links: Vec<&StaticLink> = scene.models.iter().flat_map(|m| &m.links).filter(|l| l.plates.is_some()).collect();
    if links.is_empty() {
        return None;
    }
    let mut store = MeshStore::default();
    let mut bodies = String::new();
    for link in links {
        line(&mut bodies, 2, &format!("<body name=\"{}\">", escaped(&link.name)));
        let colour = link.visuals.first().map_or([0; 4], |(_, colour)| *colour);
        let [r, g, b, a] = colour.map(|c| number((f64::from(c) / 255.0 * 1000.0).round() / 1000.0));
        for plate in link.plates.iter().flatten() {
            let placed = store.place(Solid::of_piece(plate));
            let [x, y, z] = placed.shift_m.map(number);
            let (sin, cos) = libm::sincos(placed.yaw_rad() / 2.0);
            let turn = if placed.quarters == 0 {
                String::new()
            } else {
                format!(" quat=\"{} 0 0 {}\"", number(cos), number(sin))
            };
            let mesh = placed.mesh;
            let geom = format!(
                "<geom type=\"mesh\" mesh=\"ground_{mesh}\" pos=\"{x} {y} {z}\"{turn} rgba=\"{r} {g} {b} {a}\"/>"
            );
            line(&mut bodies, 3, &geom);
        }
        line(&mut bodies, 2, "</body>");
    }
    let mut out = String::from("<mujoco model=\"ground\">\n <asset>\n");
    for (k, solid) in store.meshes.iter().enumerate() {
        let corners: Vec<String> = solid.vertices.iter().flatten().map(|c| number(*c as f64 / UNITS_PER_M)).collect();
        // A plate has too little volume to tell its inertia, which no static shape needs.
        let mesh = format!("<mesh name=\"ground_{k}\" inertia=\"shell\" vertex=\"{}\"/>", corners.join(" "));
        line(&mut out, 2, &mesh);
    }
    out.push_str(" </asset>\n <worldbody>\n");
    out.push_str(&bodies);
    out.push_str(" </worldbody>\n</mujoco>\n");
    Some(out)
}

fn line(out: &mut String, depth: usize, text: &str) {
    writeln!(out, "{}{text}", " ".repeat(depth)).expect("memory does not fail");
}
