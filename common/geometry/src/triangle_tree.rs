//! Triangles of many bodies in a tree of boxes: the nearest to a place, whether a segment keeps a distance from all of them, and which
//! bodies a place lies within.

use crate::triangle_distance::{Vec3, difference, dot, point_to_triangle, segment_to_triangle};

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Corners of a triangle, tenths of a millimetre.
type Triangle = [[i32; 3]; 3];

/// Lower and upper corner, tenths of a millimetre.
type Corners = [[i32; 3]; 2];

/// Triangles with the body of each. Lengths in tenths of a millimetre.
///
/// Coordinates are whole numbers, and their differences exact: distances are right but for the rounding of a double.
#[derive(Debug, Default)]
pub struct TriangleTree {
    nodes: Vec<Node>,
    /// In the order of the leaves.
    triangles: Vec<(Triangle, u32)>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    corners: Corners,
    /// Children, or the part of the triangles.
    from: u32,
    to: u32,
    is_leaf: bool,
}

/// The nearest body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestBody {
    /// How far it is.
    pub distance: f64,
    /// Its number.
    pub body: u32,
}

impl TriangleTree {
    /// Of triangles, each with the number of its body.
    pub fn of(triangles: Vec<(Triangle, u32)>) -> Self {
        let mut tree = Self { nodes: Vec::new(), triangles };
        let n = tree.triangles.len();
        if n == 0 {
            return tree;
        }
        tree.nodes.push(Node { corners: [[0; 3]; 2], from: 0, to: 0, is_leaf: true });
        let mut waiting = vec![(0, 0, n)];
        while let Some((node, from, to)) = waiting.pop() {
            let part = &mut tree.triangles[from..to];
            let corners = part.iter().map(|(t, _)| corners_of(t)).reduce(joined).unwrap_or_default();
            if part.len() <= LEAF {
                tree.nodes[node] = Node { corners, from: from as u32, to: to as u32, is_leaf: true };
                continue;
            }
            let side = |k: usize| i64::from(corners[1][k]) - i64::from(corners[0][k]);
            let axis = (0..3).max_by_key(|&k| side(k)).unwrap_or(0);
            let middle = |t: &Triangle| t.iter().map(|corner| i64::from(corner[axis])).sum::<i64>();
            let half = part.len() / 2;
            part.select_nth_unstable_by_key(half, |of| (middle(&of.0), *of));
            let child = tree.nodes.len();
            tree.nodes.extend([tree.nodes[0]; 2]);
            tree.nodes[node] = Node { corners, from: child as u32, to: child as u32 + 1, is_leaf: false };
            waiting.extend([(child, from, from + half), (child + 1, from + half, to)]);
        }
        tree
    }

    /// The body nearest to a place, if any is nearer than `reach`. Of bodies that are equally far it is the first.
    pub fn nearest(&self, place: [i32; 3], reach: f64) -> Option<NearestBody> {
        let mut found: Option<(f64, u32)> = None;
        let mut most = reach * reach;
        let mut waiting = Vec::with_capacity(64);
        waiting.extend(self.nodes.first().map(|root| (distance_to_box(place, &root.corners), 0)));
        while let Some((distance, node)) = waiting.pop() {
            if distance > most {
                continue;
            }
            let node = self.nodes[node as usize];
            if node.is_leaf {
                for (triangle, body) in &self.triangles[node.from as usize..node.to as usize] {
                    let distance = point_to_triangle([0.0; 3], &triangle.map(|corner| from_place(corner, place)));
                    let is_nearer = found.map_or(distance < most, |nearest| (distance, *body) < nearest);
                    if is_nearer {
                        found = Some((distance, *body));
                        most = distance;
                    }
                }
                continue;
            }
            let of = |child: u32| (distance_to_box(place, &self.nodes[child as usize].corners), child);
            let (first, second) = (of(node.from), of(node.to));
            // The nearer one is looked at first.
            waiting.extend(if first.0 <= second.0 { [second, first] } else { [first, second] });
        }
        found.map(|(squared, body)| NearestBody { distance: squared.sqrt(), body })
    }

    /// True if all places of a segment are at least as far as `distance` from all triangles.
    pub fn is_clear(&self, ends: [[i32; 3]; 2], distance: f64) -> bool {
        let origin = ends[0];
        let local = ends.map(|end| from_place(end, origin));
        let around = corners_around(ends, distance);
        let mut waiting: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(node) = waiting.pop() {
            let node = self.nodes[node as usize];
            if !meets(&node.corners, &around) {
                continue;
            }
            if !node.is_leaf {
                waiting.extend([node.from, node.to]);
                continue;
            }
            for (triangle, _) in &self.triangles[node.from as usize..node.to as usize] {
                let is_near = meets(&corners_of(triangle), &around);
                if is_near && segment_to_triangle(local, &triangle.map(|c| from_place(c, origin))) < distance * distance
                {
                    return false;
                }
            }
        }
        true
    }

    /// Gives the body of each triangle that the line from a place upwards meets, 1 if the triangle looks up, -1 if it looks down, and how
    /// high above the place that is. Of triangles that share a side the line meets one, so that of a closed body the sum tells whether the
    /// place lies within it.
    pub fn each_above(&self, place: [i32; 3], mut found: impl FnMut(u32, i32, f64)) {
        let mut waiting: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(node) = waiting.pop() {
            let node = self.nodes[node as usize];
            let [low, high] = node.corners;
            if (0..2).any(|k| place[k] < low[k] || place[k] > high[k]) || high[2] <= place[2] {
                continue;
            }
            if !node.is_leaf {
                waiting.extend([node.from, node.to]);
                continue;
            }
            for (triangle, body) in &self.triangles[node.from as usize..node.to as usize] {
                if let Some((turn, height)) = turn_above(triangle, place) {
                    found(*body, turn, height);
                }
            }
        }
    }
}

/// 1 if a triangle lies over a place and looks up, -1 if it looks down, and how high it lies; `None` if it does not lie over it.
fn turn_above(triangle: &Triangle, place: [i32; 3]) -> Option<(i32, f64)> {
    let plan = |p: [i32; 3]| [0, 1].map(|k| i128::from(p[k]) - i128::from(place[k]));
    let turn = |a: [i128; 2], b: [i128; 2]| a[0] * b[1] - a[1] * b[0];
    let [a, b, c] = triangle.map(plan);
    let area = turn([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let sign = area.signum() as i32;
    let corners = match sign {
        1 => [a, b, c],
        -1 => [a, c, b],
        _ => return None,
    };
    // A line through a side belongs to the triangle on one side of it.
    let is_inward = |k: usize| {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let side = turn(from, to);
        side > 0 || side == 0 && (to[1] < from[1] || to[1] == from[1] && to[0] < from[0])
    };
    if !(0..3).all(is_inward) {
        return None;
    }
    let local = triangle.map(|corner| from_place(corner, place));
    let [u, v] = [1, 2].map(|k| difference(local[k], local[0]));
    let normal = crate::triangle_distance::cross(u, v);
    let height = dot(normal, local[0]) / normal[2];
    (height > 0.0).then_some((sign, height))
}

/// A corner as seen from a place.
fn from_place(corner: [i32; 3], place: [i32; 3]) -> Vec3 {
    [0, 1, 2].map(|k| (i64::from(corner[k]) - i64::from(place[k])) as f64)
}

/// Squared distance of a place from a box.
fn distance_to_box(place: [i32; 3], [low, high]: &Corners) -> f64 {
    let off = [0, 1, 2].map(|k| {
        let (p, low, high) = (i64::from(place[k]), i64::from(low[k]), i64::from(high[k]));
        (low - p).max(p - high).max(0) as f64
    });
    dot(off, off)
}

fn corners_of(t: &Triangle) -> Corners {
    let of = |pick: fn(i32, i32) -> i32| [0, 1, 2].map(|k| pick(pick(t[0][k], t[1][k]), t[2][k]));
    [of(i32::min), of(i32::max)]
}

/// The box around both ends of a segment, and a distance around it.
fn corners_around(ends: [[i32; 3]; 2], distance: f64) -> Corners {
    let margin = distance.ceil() as i32;
    [
        [0, 1, 2].map(|k| ends[0][k].min(ends[1][k]).saturating_sub(margin)),
        [0, 1, 2].map(|k| ends[0][k].max(ends[1][k]).saturating_add(margin)),
    ]
}

fn joined(a: Corners, b: Corners) -> Corners {
    [[0, 1, 2].map(|k| a[0][k].min(b[0][k])), [0, 1, 2].map(|k| a[1][k].max(b[1][k]))]
}

fn meets(a: &Corners, b: &Corners) -> bool {
    (0..3).all(|k| a[0][k] <= b[1][k] && b[0][k] <= a[1][k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::tests::cuboid;
    use proptest::prelude::*;

    /// Lower corner and size.
    type Block = ([i32; 3], [i32; 3]);

    fn upper((low, size): &Block) -> [i32; 3] {
        [0, 1, 2].map(|k| low[k] + size[k])
    }

    fn tree_of(blocks: &[Block]) -> TriangleTree {
        let of = |(body, block): (u32, &Block)| {
            let (vertices, triangles) = cuboid(block.0, upper(block));
            triangles.into_iter().map(move |t| (t.map(|corner| vertices[corner as usize]), body)).collect::<Vec<_>>()
        };
        TriangleTree::of((0..).zip(blocks).flat_map(of).collect())
    }

    /// Distance of a place from the surface of a block.
    fn distance(block: &Block, place: Vec3) -> f64 {
        let (low, high) = (block.0.map(f64::from), upper(block).map(f64::from));
        let outside = [0, 1, 2].map(|k| f64::max(low[k] - place[k], place[k] - high[k]));
        if outside.iter().all(|off| *off < 0.0) {
            return -outside.into_iter().fold(f64::NEG_INFINITY, f64::max);
        }
        outside.map(|off| off.max(0.0)).into_iter().map(|off| off * off).sum::<f64>().sqrt()
    }

    fn contains(block: &Block, place: [i32; 3]) -> bool {
        (0..3).all(|k| block.0[k] < place[k] && place[k] < upper(block)[k])
    }

    #[test]
    fn a_tree_of_nothing_is_far_from_everything() {
        let tree = TriangleTree::of(Vec::new());
        assert!(tree.nearest([0; 3], 1e9).is_none() && tree.is_clear([[0; 3], [9; 3]], 1e6));
    }

    #[test]
    fn a_distance_that_is_kept_exactly_is_kept() {
        let tree = tree_of(&[([0, 0, -100], [90_000, 90_000, 100])]);
        assert!(tree.is_clear([[1_000, 1_000, 8_000], [9_000, 1_000, 8_000]], 8_000.0));
        assert!(!tree.is_clear([[1_000, 1_000, 8_000], [9_000, 1_000, 7_999]], 8_000.0));
        assert_eq!(tree.nearest([1_000, 1_000, 8_000], 8_001.0), Some(NearestBody { distance: 8_000.0, body: 0 }));
        assert_eq!(tree.nearest([1_000, 1_000, 8_000], 8_000.0), None);
    }

    proptest! {
        #[test]
        fn the_nearest_body_and_those_around_a_place_are_what_a_look_at_all_blocks_finds(
            blocks in proptest::collection::vec(
                (proptest::array::uniform3(-300i32..300), proptest::array::uniform3(1i32..200)), 1..12),
            places in proptest::collection::vec(proptest::array::uniform3(-400i32..400), 1..20),
            reach in 1.0f64..500.0,
        ) {
            let tree = tree_of(&blocks);
            for place in places {
                let at = place.map(f64::from);
                let least = blocks.iter().map(|block| distance(block, at)).fold(f64::INFINITY, f64::min);
                match tree.nearest(place, reach) {
                    Some(nearest) => {
                        prop_assert!((nearest.distance - least).abs() < 1e-6 && least < reach + 1e-6);
                        prop_assert!((distance(&blocks[nearest.body as usize], at) - least).abs() < 1e-6);
                    }
                    None => prop_assert!(least >= reach - 1e-6, "{least} {reach}"),
                }
                let mut sums = vec![0; blocks.len()];
                tree.each_above(place, |body, turn, height| {
                    sums[body as usize] += turn;
                    let top = f64::from(upper(&blocks[body as usize])[2] - place[2]);
                    let bottom = f64::from(blocks[body as usize].0[2] - place[2]);
                    assert!((height - if turn > 0 { top } else { bottom }).abs() < 1e-6);
                });
                for (block, sum) in blocks.iter().zip(sums) {
                    // A place on a surface may be told either way.
                    if distance(block, at) > 0.0 {
                        prop_assert_eq!(sum != 0, contains(block, place), "{:?} {:?}", block, place);
                    }
                }
            }
        }

        #[test]
        fn a_segment_is_clear_if_all_places_on_it_are(
            blocks in proptest::collection::vec(
                (proptest::array::uniform3(-300i32..300), proptest::array::uniform3(1i32..200)), 1..12),
            ends in proptest::array::uniform2(proptest::array::uniform3(-400i32..400)),
            clearance in 1.0f64..120.0,
        ) {
            const N: usize = 400;
            let is_clear = tree_of(&blocks).is_clear(ends, clearance);
            let at = |k: usize| {
                let share = k as f64 / N as f64;
                [0, 1, 2].map(|axis| f64::from(ends[0][axis]) * (1.0 - share) + f64::from(ends[1][axis]) * share)
            };
            let least = (0..=N)
                .flat_map(|k| blocks.iter().map(move |block| distance(block, at(k))))
                .fold(f64::INFINITY, f64::min);
            let length = dot(from_place(ends[1], ends[0]), from_place(ends[1], ends[0])).sqrt();
            // Between samples the distance falls by half their spacing at most.
            let between = length / (2.0 * N as f64);
            if is_clear {
                prop_assert!(least >= clearance - 1e-6, "{least}");
            } else {
                prop_assert!(least < clearance + between + 1e-6, "{least}");
            }
        }
    }
}
