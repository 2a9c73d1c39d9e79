//! Markers of one frame and instant, with their colours and sizes.

use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::{Point, Pose, Quaternion, Vector3};
use crate::msg::std_msgs::{ColorRGBA, Header};
use crate::msg::visualization_msgs::{Marker, MarkerArray};
use geometry::OrientedBox;

/// What a robot may use.
pub(super) const OPEN: ColorRGBA = ColorRGBA { r: 0.1, g: 0.65, b: 0.3, a: 1.0 };
/// What it may use, but not for long, or what is not as it will be.
pub(super) const CHANGING: ColorRGBA = ColorRGBA { r: 0.95, g: 0.6, b: 0.1, a: 1.0 };
/// What it may not use.
pub(super) const BLOCKED: ColorRGBA = ColorRGBA { r: 0.85, g: 0.1, b: 0.1, a: 1.0 };
/// Ways.
pub(super) const WAY: ColorRGBA = ColorRGBA { r: 0.2, g: 0.35, b: 0.8, a: 1.0 };

/// Width of lines in metres: a cell of a usual map.
const LINE_M: f64 = 0.05;
/// Height of letters in metres.
const LETTER_M: f64 = 0.25;
/// Length, width and height of arrows in metres.
const ARROW_M: [f64; 3] = [0.5, 0.08, 0.08];

/// Several arrays as one, which deletes the markers of before once.
pub fn together(arrays: impl IntoIterator<Item = MarkerArray>) -> MarkerArray {
    let mut markers: Vec<Marker> = Vec::new();
    for array in arrays {
        let is_repeated = |marker: &Marker| marker.action == Marker::DELETEALL && !markers.is_empty();
        let more: Vec<Marker> = array.markers.into_iter().filter(|marker| !is_repeated(marker)).collect();
        markers.extend(more);
    }
    MarkerArray { markers }
}

/// Markers to be, behind one that deletes those of before.
pub(super) struct Drawing {
    header: Header,
    markers: Vec<Marker>,
}

impl Drawing {
    pub(super) fn new(frame_id: &str, stamp: Time) -> Self {
        let header = Header { stamp, frame_id: frame_id.to_owned() };
        let clear = Marker { header: header.clone(), action: Marker::DELETEALL, ..Marker::default() };
        Self { header, markers: vec![clear] }
    }

    pub(super) fn finish(self) -> MarkerArray {
        MarkerArray { markers: self.markers }
    }

    /// A line through points.
    pub(super) fn line_strip(&mut self, name: (&str, usize), color: ColorRGBA, points: Vec<Point>) {
        if points.len() > 1 {
            let scale = Vector3 { x: LINE_M, ..Vector3::default() };
            self.add(name, Marker::LINE_STRIP, Marker { scale, color, points, ..Marker::default() });
        }
    }

    /// A line between every two points.
    pub(super) fn line_list(&mut self, name: (&str, usize), color: ColorRGBA, points: Vec<Point>) {
        if !points.is_empty() {
            let scale = Vector3 { x: LINE_M, ..Vector3::default() };
            self.add(name, Marker::LINE_LIST, Marker { scale, color, points, ..Marker::default() });
        }
    }

    /// Balls with a diameter in metres.
    pub(super) fn spheres(&mut self, name: (&str, usize), color: ColorRGBA, diameter_m: f64, points: Vec<Point>) {
        if !points.is_empty() {
            let scale = Vector3 { x: diameter_m, y: diameter_m, z: diameter_m };
            self.add(name, Marker::SPHERE_LIST, Marker { scale, color, points, ..Marker::default() });
        }
    }

    /// An arrow from a place along the X axis of an orientation.
    pub(super) fn arrow(&mut self, name: (&str, usize), color: ColorRGBA, at_m: [f64; 2], orientation: Quaternion) {
        let pose = Pose { position: point(at_m), orientation };
        let [x, y, z] = ARROW_M;
        self.add(name, Marker::ARROW, Marker { pose, scale: Vector3 { x, y, z }, color, ..Marker::default() });
    }

    /// A text over a place.
    pub(super) fn text(&mut self, name: (&str, usize), color: ColorRGBA, at_m: [f64; 2], text: String) {
        if !text.is_empty() {
            let position = Point { z: LETTER_M, ..point(at_m) };
            let pose = Pose { position, ..Pose::default() };
            let scale = Vector3 { z: LETTER_M, ..Vector3::default() };
            self.add(name, Marker::TEXT_VIEW_FACING, Marker { pose, scale, color, text, ..Marker::default() });
        }
    }

    fn add(&mut self, (ns, id): (&str, usize), r#type: i32, marker: Marker) {
        let header = self.header.clone();
        self.markers.push(Marker { header, ns: ns.to_owned(), id: id as i32, r#type, action: Marker::ADD, ..marker });
    }
}

/// A point of the plane.
pub(super) fn point([x, y]: [f64; 2]) -> Point {
    Point { x, y, z: 0.0 }
}

/// A ring in tenths of a millimetre as a closed line.
pub(super) fn outline(ring: &[[i32; 2]]) -> Vec<Point> {
    ring.iter().chain(ring.first()).map(|corner| point(corner.map(frames::metres))).collect()
}

/// A rectangle as a closed line; nothing if it has no extent.
pub(super) fn rectangle(rectangle: &OrientedBox) -> Vec<Point> {
    if rectangle.half == [0.0; 2] { Vec::new() } else { outline(&rectangle.ring()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_together_delete_once_and_first() {
        let drawn = |ns: &str| {
            let mut drawing = Drawing::new("map", Time::default());
            drawing.text((ns, 7), OPEN, [1.0, 2.0], "a".to_owned());
            drawing.finish()
        };
        let markers = together([drawn("rooms"), drawn("doors")]).markers;
        let actions: Vec<(&str, i32)> = markers.iter().map(|m| (m.ns.as_str(), m.action)).collect();
        assert_eq!(actions, [("", Marker::DELETEALL), ("rooms", Marker::ADD), ("doors", Marker::ADD)]);
    }

    #[test]
    fn outlines_are_closed() {
        let line = outline(&[[0, 0], [10_000, 0], [0, 5_000]]);
        assert_eq!((line.len(), line[0], line[2]), (4, line[3], Point { x: 0.0, y: 0.5, z: 0.0 }));
        assert!(outline(&[]).is_empty());
    }
}
