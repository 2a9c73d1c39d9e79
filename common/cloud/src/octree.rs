//! An octree of cells that bodies fill, as the bytes of a binary OctoMap.
//!
//! The tree has 16 levels around the origin of `map`. It is made by recursion from the root: a cube that no surface crosses is decided
//! as a whole, others are halved along each axis. Only triangles that cross a cube are looked at in it, so that memory grows with
//! the surfaces, not with the volume.

use crate::bodies::{Effect, Filling};
use crate::cube::Cube;

/// Levels of an OctoMap: its keys have 16 bits.
const LEVELS: u32 = 16;

/// Cells from the origin to the border of an OctoMap.
pub(crate) const REACH: i64 = 1 << (LEVELS - 1);

/// Smallest cells that are looked at one by one, at most.
pub(crate) const MAX_CELLS: u64 = 1 << 26;

/// More than [`MAX_CELLS`] cells meet surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TooManyCells;

/// The tree, and how many cells there are of each kind.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Octree {
    /// Two bytes for each inner node, depth first: two bits for each child, 00 unknown, 01 free, 10 occupied, 11 inner.
    pub(crate) bytes: Vec<u8>,
    pub(crate) n_occupied: u64,
    pub(crate) n_free: u64,
}

/// What a node is, by the bits that a child has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Node {
    Unknown = 0,
    Free = 1,
    Occupied = 2,
    Inner = 3,
}

/// A triangle of a body.
type Face = (u32, u32);

/// Effects of the bodies within which a cube lies as a whole.
#[derive(Debug, Clone, Copy, Default)]
struct Within {
    occupied: bool,
    unknown: bool,
    free: bool,
}

struct Builder<'a> {
    bodies: &'a [Filling<'a>],
    cell_tenths: i64,
    volume: [[i64; 3]; 2],
    tree: Octree,
    n_looked_at: u64,
}

/// The tree of bodies in a volume of cells, its lower corner and that beyond its last cells; what lies outside of it is unknown.
///
/// A cell is occupied if a surface of a body with that effect crosses it, or if it lies within such a body; else unknown if it meets a
/// body with that effect; else free if it lies within one that makes it so. Faces of solids that lie in a face of a cell do not cross
/// it, those of sheets are in the cells on both sides. `cell_tenths` is even.
///
/// # Errors
/// Too many cells.
pub(crate) fn octree(bodies: &[Filling<'_>], cell_tenths: i64, volume: [[i64; 3]; 2]) -> Result<Octree, TooManyCells> {
    let mut builder = Builder { bodies, cell_tenths, volume, tree: Octree::default(), n_looked_at: 0 };
    let faces: Vec<Face> =
        (0..).zip(bodies).flat_map(|(body, b)| (0..b.n_triangles()).map(move |k| (body, k))).collect();
    builder.inner([-REACH; 3], LEVELS, &faces, Within::default())?;
    Ok(builder.tree)
}

impl Octree {
    /// Number of nodes: the root, and every child that is known.
    pub(crate) fn n_nodes(&self) -> usize {
        let known = |byte: &u8| (0..4).filter(|k| byte >> (2 * k) & 3 != 0).count();
        let n_children: usize = self.bytes.iter().map(known).sum();
        if n_children == 0 { 0 } else { n_children + 1 }
    }
}

impl Builder<'_> {
    /// A node with eight children; one of eight alike is a leaf, but for the root.
    fn inner(&mut self, at: [i64; 3], level: u32, faces: &[Face], within: Within) -> Result<Node, TooManyCells> {
        let place = self.tree.bytes.len();
        self.tree.bytes.extend([0; 2]);
        let half = 1 << (level - 1);
        let mut children = [Node::Unknown; 8];
        for (k, child) in children.iter_mut().enumerate() {
            let corner = [0, 1, 2].map(|axis| at[axis] + half * (k as i64 >> axis & 1));
            *child = self.node(corner, level - 1, faces, within)?;
        }
        let is_leaf = children[0] != Node::Inner && children.iter().all(|child| *child == children[0]);
        if is_leaf && level < LEVELS {
            self.tree.bytes.truncate(place);
            return Ok(children[0]);
        }
        for (k, child) in children.iter().enumerate() {
            self.tree.bytes[place + k / 4] |= (*child as u8) << (2 * (k % 4));
        }
        Ok(Node::Inner)
    }

    /// A node of `2^level` cells to a side, of which the parent crosses these faces.
    fn node(&mut self, at: [i64; 3], level: u32, faces: &[Face], mut within: Within) -> Result<Node, TooManyCells> {
        let side = 1 << level;
        let [low, high] = self.volume;
        if (0..3).any(|k| at[k] >= high[k] || at[k] + side <= low[k]) {
            return Ok(Node::Unknown);
        }
        let crossing = self.crossing(at, side, faces, &mut within);
        let crosses = |effect| crossing.iter().any(|(body, _)| self.bodies[*body as usize].effect == effect);
        let [occupied, unknown, free] = [Effect::Occupied, Effect::Unknown, Effect::Free].map(crosses);
        let decided = if within.occupied || level == 0 && occupied {
            Some(Node::Occupied)
        } else if !occupied && (within.unknown || !within.free && !free) || level == 0 && (unknown || !within.free) {
            Some(Node::Unknown)
        } else if !occupied && !unknown && within.free {
            Some(Node::Free)
        } else {
            None
        };
        self.n_looked_at += u64::from(level == 0);
        if self.n_looked_at > MAX_CELLS {
            return Err(TooManyCells);
        }
        let is_whole = (0..3).all(|k| low[k] <= at[k] && at[k] + side <= high[k]);
        match decided {
            Some(Node::Unknown) => Ok(Node::Unknown),
            Some(node) if is_whole => {
                let n = 1 << (3 * level);
                let count = if node == Node::Free { &mut self.tree.n_free } else { &mut self.tree.n_occupied };
                *count += n;
                Ok(node)
            }
            Some(_) => self.inner(at, level, &[], within),
            None => self.inner(at, level, &crossing, within),
        }
    }

    /// The faces that cross a node; what the bodies of the others do to it.
    fn crossing(&self, at: [i64; 3], side: i64, faces: &[Face], within: &mut Within) -> Vec<Face> {
        let cell = self.cell_tenths;
        let half = side * cell / 2;
        let cube = Cube { centre: at.map(|c| c * cell + half), half };
        let mut crossing = Vec::new();
        for of_body in faces.chunk_by(|a, b| a.0 == b.0) {
            let (before, body) = (crossing.len(), &self.bodies[of_body[0].0 as usize]);
            let crosses = |face: &&Face| cube.meets(&body.triangle(face.1), !body.is_solid);
            crossing.extend(of_body.iter().filter(crosses));
            if crossing.len() == before && body.contains(cube.centre) {
                match body.effect {
                    Effect::Occupied => within.occupied = true,
                    Effect::Unknown => within.unknown = true,
                    Effect::Free => within.free = true,
                }
            }
        }
        crossing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::MeshView;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    const QUADS: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

    /// A box in tenths of a millimetre: corners and triangles.
    type Block = (Vec<[i32; 3]>, Vec<[u32; 3]>);

    fn block(low: [i32; 3], high: [i32; 3]) -> Block {
        let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] });
        let triangles = QUADS.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        ((0..8).map(corner).collect(), triangles)
    }

    fn made(blocks: &[(Block, Effect)], cell_tenths: i64, volume: [[i64; 3]; 2]) -> Octree {
        let filling = |((vertices, triangles), effect): &(Block, Effect)| {
            // The vectors outlive the tree in each test.
            let closed = geometry::is_closed(vertices, triangles);
            (vertices.clone(), triangles.clone(), closed, *effect)
        };
        let owned: Vec<_> = blocks.iter().map(filling).collect();
        let fillings: Vec<Filling<'_>> = owned
            .iter()
            .map(|(vertices, triangles, closed, effect)| {
                Filling::of(MeshView { vertices, triangles, closed: *closed }, *effect)
            })
            .collect();
        octree(&fillings, cell_tenths, volume).unwrap()
    }

    /// Cells of a tree by their lower corner, as a reader of the format unfolds them.
    fn cells(tree: &Octree) -> BTreeMap<[i64; 3], bool> {
        fn read(bytes: &mut std::slice::Iter<'_, u8>, at: [i64; 3], level: u32, found: &mut BTreeMap<[i64; 3], bool>) {
            let word: Vec<u8> = bytes.by_ref().take(2).copied().collect();
            for k in 0..8 {
                let side = 1i64 << (level - 1);
                let corner = [0, 1, 2].map(|axis| at[axis] + side * (k as i64 >> axis & 1));
                match word[k / 4] >> (2 * (k % 4)) & 3 {
                    0 => {}
                    3 => read(bytes, corner, level - 1, found),
                    bits => {
                        for n in 0..side * side * side {
                            let cell = [n % side, n / side % side, n / side / side];
                            found.insert([0, 1, 2].map(|axis| corner[axis] + cell[axis]), bits == 2);
                        }
                    }
                }
            }
        }
        let mut found = BTreeMap::new();
        let mut bytes = tree.bytes.iter();
        read(&mut bytes, [-REACH; 3], LEVELS, &mut found);
        assert!(bytes.next().is_none());
        found
    }

    #[test]
    fn a_solid_on_the_lattice_is_its_cells_and_a_sheet_is_in_those_on_both_sides() {
        let solid = block([0, 0, 0], [8_000, 8_000, 8_000]);
        let tree = made(&[(solid.clone(), Effect::Occupied)], 1_000, [[-20; 3], [20; 3]]);
        assert_eq!((tree.n_occupied, tree.n_free, cells(&tree).len()), (512, 0, 512));
        // Eight cells to a side, at a corner of the tree: one leaf below a chain of inner nodes.
        assert_eq!((tree.bytes.len(), tree.n_nodes()), (2 * 13, 14));
        let sheet = (solid.0, solid.1[10..].to_vec());
        let found = cells(&made(&[(sheet, Effect::Occupied)], 1_000, [[-20; 3], [20; 3]]));
        assert!(found.keys().all(|at| at[2] == 7 || at[2] == 8) && found.len() == 200, "{}", found.len());
    }

    #[test]
    fn a_volume_that_a_body_encloses_is_occupied_and_nothing_beyond_it_is() {
        let tree = made(&[(block([-90_000; 3], [90_000; 3]), Effect::Occupied)], 1_000, [[-3, 2, 5], [4, 9, 6]]);
        assert_eq!((tree.n_occupied, cells(&tree).len()), (49, 49));
        assert_eq!(made(&[], 1_000, [[-3; 3], [3; 3]]).n_nodes(), 0);
    }

    proptest! {
        #[test]
        fn each_cell_is_what_a_look_at_all_blocks_finds(
            blocks in proptest::collection::vec(
                (proptest::array::uniform3(-60i32..60), proptest::array::uniform3(1i32..70), 0usize..3), 1..5),
            first in proptest::array::uniform3(-9i64..0),
        ) {
            const CELL: i32 = 10;
            let effects = [Effect::Occupied, Effect::Unknown, Effect::Free];
            let corners: Vec<_> = blocks.iter().map(|(low, size, effect)| {
                (*low, [0, 1, 2].map(|k| low[k] + size[k]), effects[*effect])
            }).collect();
            let meshes: Vec<(Block, Effect)> = corners.iter().map(|(low, high, effect)| (block(*low, *high), *effect)).collect();
            let last = [8, 9, 7];
            let found = cells(&made(&meshes, i64::from(CELL), [first, last]));
            for x in first[0] - 2..last[0] + 2 { for y in first[1] - 2..last[1] + 2 { for z in first[2] - 2..last[2] + 2 {
                let cell = [x, y, z];
                let low = cell.map(|c| c as i32 * CELL);
                let meets = |of: &&([i32; 3], [i32; 3], Effect)| (0..3).all(|k| of.0[k] < low[k] + CELL && low[k] < of.1[k]);
                let holds = |of: &&([i32; 3], [i32; 3], Effect)| (0..3).all(|k| of.0[k] <= low[k] && low[k] + CELL <= of.1[k]);
                let of = |effect| corners.iter().filter(move |c| c.2 == effect);
                let is_in = (0..3).all(|k| first[k] <= cell[k] && cell[k] < last[k]);
                let wanted = if !is_in {
                    None
                } else if of(Effect::Occupied).any(|c| meets(&c)) {
                    Some(true)
                } else if of(Effect::Unknown).any(|c| meets(&c)) {
                    None
                } else {
                    of(Effect::Free).any(|c| holds(&c)).then_some(false)
                };
                prop_assert_eq!(found.get(&cell).copied(), wanted, "{:?}", cell);
            }}}
        }
    }
}
