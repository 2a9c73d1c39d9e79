//! A tree of boxes around triangles: finds those that may meet a box.

use crate::plane::Triangle;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Lower and upper corner, tenths of a millimetre.
pub(crate) type Corners = [[i32; 3]; 2];

/// Boxes of triangles, halved along the longer side in plan until few are left.
#[derive(Debug, Default)]
pub(crate) struct BoxTree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    corners: Corners,
    /// Children, or the part of the order.
    from: u32,
    to: u32,
    is_leaf: bool,
}

impl BoxTree {
    pub(crate) fn of<'a>(triangles: impl Iterator<Item = &'a Triangle>) -> Self {
        let boxes: Vec<Corners> = triangles.map(corners_of).collect();
        let order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut tree = Self { nodes: Vec::new(), order };
        if !boxes.is_empty() {
            tree.nodes.push(Node { corners: boxes[0], from: 0, to: 0, is_leaf: true });
            tree.build(&boxes);
        }
        tree
    }

    fn build(&mut self, boxes: &[Corners]) {
        let mut waiting = vec![(0usize, 0usize, boxes.len())];
        while let Some((node, from, to)) = waiting.pop() {
            let part = &mut self.order[from..to];
            let corners = part.iter().map(|&k| boxes[k as usize]).reduce(joined).unwrap_or_default();
            if part.len() <= LEAF {
                self.nodes[node] = Node { corners, from: from as u32, to: to as u32, is_leaf: true };
                continue;
            }
            let side = |k: usize| i64::from(corners[1][k]) - i64::from(corners[0][k]);
            let axis = usize::from(side(1) > side(0));
            let middle = |k: u32| i64::from(boxes[k as usize][0][axis]) + i64::from(boxes[k as usize][1][axis]);
            let half = part.len() / 2;
            part.select_nth_unstable_by_key(half, |&k| (middle(k), k));
            let child = self.nodes.len();
            self.nodes.extend([self.nodes[0]; 2]);
            self.nodes[node] = Node { corners, from: child as u32, to: child as u32 + 1, is_leaf: false };
            waiting.extend([(child, from, from + half), (child + 1, from + half, to)]);
        }
    }

    /// Gives the number of every triangle whose box meets this one; not in any order.
    pub(crate) fn each(&self, wanted: &Corners, mut found: impl FnMut(usize)) {
        let mut waiting: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(node) = waiting.pop() {
            let node = self.nodes[node as usize];
            if !meets(&node.corners, wanted) {
                continue;
            }
            if node.is_leaf {
                self.order[node.from as usize..node.to as usize].iter().for_each(|&k| found(k as usize));
            } else {
                waiting.extend([node.from, node.to]);
            }
        }
    }
}

/// The box of a triangle.
pub(crate) fn corners_of(t: &Triangle) -> Corners {
    [0, 1].map(|end| {
        [0, 1, 2].map(|k| {
            let all = t.map(|v| v[k]);
            if end == 0 { all[0].min(all[1]).min(all[2]) } else { all[0].max(all[1]).max(all[2]) }
        })
    })
}

/// The box around both.
pub(crate) fn joined(a: Corners, b: Corners) -> Corners {
    [[0, 1, 2].map(|k| a[0][k].min(b[0][k])), [0, 1, 2].map(|k| a[1][k].max(b[1][k]))]
}

fn meets(a: &Corners, b: &Corners) -> bool {
    (0..3).all(|k| a[0][k] <= b[1][k] && b[0][k] <= a[1][k])
}
