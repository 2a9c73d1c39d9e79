//! Waypoints as CSV.

use crate::input::ExportInput;
use crate::text::rounded;
use crate::waypoints::{space_id, space_name};
use std::fmt::Write;

/// One line per waypoint: pose with quaternion (x, y, z, w), space, clearance.
pub(crate) fn waypoints(input: &ExportInput<'_>) -> String {
    let mut text =
        "id,order,kind,storey,x_m,y_m,z_m,sensor_z_m,yaw_rad,qx,qy,qz,qw,space,name,clearance_m,covers_m2,overlap,leg_m\n".to_owned();
    for w in input.mission_plan.waypoints {
        let [x, y, z] = w.position_in_map_m.map(rounded);
        let [qx, qy, qz, qw] = w.attitude().quaternion();
        let space = quoted(&space_id(input, w.space).unwrap_or_default());
        let line = format!(
            "{},{},{},{},{x},{y},{z},{},{},{qx},{qy},{qz},{qw},{space},{},{},{},{},{}",
            w.id,
            w.order,
            w.purpose().kind().name(),
            w.map_storey,
            rounded(w.sensor_in_map_m[2]),
            w.yaw_rad,
            quoted(&space_name(input.site, w.space).unwrap_or_default()),
            rounded(w.clearance_m),
            rounded(w.covers_m2),
            rounded(w.overlap),
            rounded(w.leg_m),
        );
        // Writing to a string does not fail.
        let _ = writeln!(text, "{line}");
    }
    text
}

/// A field as RFC 4180 wants it.
pub(crate) fn quoted(field: &str) -> String {
    if field.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_and_quotes_are_quoted() {
        assert_eq!(quoted("Director's office"), "Director's office");
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
