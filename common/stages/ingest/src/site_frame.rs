//! The map frame: rotation to the dominant wall direction and shift near the origin, fixed once per site.

use crate::classify::is_a;
use frames::{Map, UprightRigid3, World};
use ifc::{Diagnostic, DiagnosticCode, Element, Geometry, Model, Severity};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Walls within this angle of each other count as one direction.
const SAME_DIRECTION_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// A building farther than this from the world's origin is moved near it.
const FAR_M: f64 = 10_000.0;

/// The motion from the IFC world to the map, and how often it was changed.
#[derive(Debug, Clone, Copy)]
pub struct SiteFrame {
    /// `p_map = Rz(yaw) p_world + t`.
    pub map_from_world: UprightRigid3<Map, World>,
    /// From 1.
    pub frame_epoch: u32,
}

impl SiteFrame {
    /// The frame in which the model's dominant wall direction is axis-parallel and the building is near the origin.
    pub(crate) fn of(model: &Model, frame_epoch: u32) -> Self {
        // Adding zero turns a negative zero into a positive one: the frame comes back from its file to the last bit.
        let yaw_rad = -dominant_direction(&model.elements) + 0.0;
        let turn = UprightRigid3::<Map, World>::new([0.0; 3], yaw_rad);
        let [x, y] = shift(model, &turn).map(|shift| shift + 0.0);
        Self { map_from_world: UprightRigid3::new([x, y, 0.0], yaw_rad), frame_epoch }
    }

    /// Warning if a kept frame differs from the one that the site would get now.
    pub(crate) fn misfit(&self, own: &Self) -> Option<Diagnostic> {
        let (kept, own) = (&self.map_from_world, &own.map_from_world);
        let same =
            (kept.yaw_rad() - own.yaw_rad()).abs() <= SAME_DIRECTION_RAD && kept.translation_m() == own.translation_m();
        let message = format!(
            "the map frame is that of an earlier run (yaw {:.4} rad, shift {:?} m); this site alone would get yaw {:.4} rad, \
             shift {:?} m: if it is another site, choose another output folder",
            kept.yaw_rad(),
            kept.translation_m(),
            own.yaw_rad(),
            own.translation_m(),
        );
        (!same).then_some(Diagnostic {
            severity: Severity::Warning,
            code: DiagnosticCode::FrameKept,
            entity: None,
            source: None,
            message,
        })
    }
}

/// Direction of most wall length, from -45 to 45 degrees; 0 within 0.05 degrees of an axis.
fn dominant_direction(elements: &[Element]) -> f64 {
    let walls: Vec<(f64, f64)> =
        elements.iter().filter(|e| is_a(e, "IfcWall")).filter_map(direction_and_length).collect();
    let near = |a: f64, b: f64| {
        let d = (a - b).abs();
        d.min(FRAC_PI_2 - d) <= SAME_DIRECTION_RAD
    };
    let total = |angle: f64| walls.iter().filter(|w| near(w.0, angle)).map(|w| w.1).sum::<f64>();
    let mut angles: Vec<f64> = walls.iter().map(|w| w.0).collect();
    // Smaller turns first, of equal ones the positive yaw (the negative direction): ties keep the first.
    angles.sort_by(|a, b| a.abs().total_cmp(&b.abs()).then(a.total_cmp(b)));
    angles.dedup();
    let mut best: Option<(f64, f64)> = None;
    for angle in angles {
        let length = total(angle);
        if best.is_none_or(|b| length > b.1 * (1.0 + 1e-9)) {
            best = Some((angle, length));
        }
    }
    best.map(|b| b.0).filter(|a| a.abs() > SAME_DIRECTION_RAD).unwrap_or(0.0)
}

/// Direction of a wall's x axis modulo 90 degrees, and the extent of its body along it.
fn direction_and_length(wall: &Element) -> Option<(f64, f64)> {
    let [x, y, _] = wall.placement?.axes[0];
    let norm = libm::hypot(x, y);
    if norm < 0.5 {
        return None;
    }
    let (x, y) = (x / norm, y / norm);
    let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in wall.geometry.points_m() {
        let along = p[0] * x + p[1] * y;
        (lo, hi) = (lo.min(along), hi.max(along));
    }
    let length = hi - lo;
    let turn = libm::atan2(y, x);
    let angle = turn - libm::round(turn / FRAC_PI_2) * FRAC_PI_2;
    // An angle of exactly 45 degrees is the same as -45.
    let angle = if angle <= -FRAC_PI_4 { angle + FRAC_PI_2 } else { angle };
    (length.is_finite() && length > 0.0).then_some((angle, length))
}

/// Zero, or what brings the lower corner of a far building near the origin, in whole 100 m.
fn shift(model: &Model, turn: &UprightRigid3<Map, World>) -> [f64; 2] {
    let mut boxes: Vec<[[f64; 2]; 2]> = model.elements.iter().filter_map(|e| plan_box(&e.geometry, turn)).collect();
    if boxes.is_empty() {
        boxes = model.terrains.iter().filter_map(|t| plan_box(&t.geometry, turn)).collect();
    }
    let middle = |k: usize| {
        let mut all: Vec<f64> = boxes.iter().map(|b| (b[0][k] + b[1][k]) / 2.0).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    };
    // The median, so that one element far off does not move the building.
    let centre = [middle(0), middle(1)];
    if libm::hypot(centre[0], centre[1]) <= FAR_M {
        return [0.0; 2];
    }
    [0, 1].map(|k| {
        let near = boxes.iter().map(|b| b[0][k]).filter(|lo| (lo - centre[k]).abs() < FAR_M);
        -libm::floor(near.fold(centre[k], f64::min) / 100.0) * 100.0
    })
}

fn plan_box(geometry: &Geometry, turn: &UprightRigid3<Map, World>) -> Option<[[f64; 2]; 2]> {
    let mut range: Option<[[f64; 2]; 2]> = None;
    for p in geometry.points_m() {
        let [x, y, _] = turn.apply(p);
        let r = range.get_or_insert([[x, y], [x, y]]);
        *r = [[r[0][0].min(x), r[0][1].min(y)], [r[1][0].max(x), r[1][1].max(y)]];
    }
    range.filter(|r| r.iter().flatten().all(|c| c.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_frame_that_does_not_fit_is_not_kept_in_silence() {
        let frame = |x: f64, yaw_rad: f64| SiteFrame {
            map_from_world: UprightRigid3::new([x, 0.0, 0.0], yaw_rad),
            frame_epoch: 1,
        };
        assert!(frame(0.0, 0.3).misfit(&frame(0.0, 0.3)).is_none());
        assert!(frame(0.0, 0.3).misfit(&frame(0.0, 0.0)).is_some());
        assert!(frame(100.0, 0.0).misfit(&frame(0.0, 0.0)).is_some());
    }
}
