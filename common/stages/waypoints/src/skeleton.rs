//! Skeleton of the reachable free space by thinning, traced to nodes and chains.

use crate::path_search::PathGrid;
use grid::SparseLayer;

/// A line of cells on the reachable free space.
pub(crate) struct Line {
    /// Of each cell its neighbours on the line, as bits, without those across a corner between two unreachable cells; and
    /// [`ON_LINE`] and [`TRIED`].
    cells: SparseLayer<u16>,
}

/// Set for cells on the line.
const ON_LINE: u16 = 1 << 8;
/// Set for cells that were to be taken off before, whether they could be or not.
const TRIED: u16 = 1 << 9;

impl Line {
    /// All reachable cells.
    fn of_all(path_grid: &PathGrid) -> Self {
        let bits = |cell: usize, around: u8| {
            if path_grid.open[cell] { ON_LINE | u16::from(NEAR[usize::from(around)]) } else { 0 }
        };
        Self { cells: path_grid.open_around.map(0, bits) }
    }

    /// Takes a cell off; calls `tell` with each of its neighbours that was tried before and can be taken off now.
    fn remove(&mut self, path_grid: &PathGrid, cell: usize, mut tell: impl FnMut(usize)) {
        self.cells[cell] &= !ON_LINE;
        let (bits, around) = (self.cells[cell], path_grid.neighbours(cell));
        for k in (0..8).filter(|k| bits & 1 << k != 0) {
            let neighbour = &mut self.cells[around[k]];
            *neighbour &= !(1 << ((k + 4) % 8));
            if *neighbour & TRIED != 0 && can_be_removed(*neighbour) {
                tell(around[k]);
            }
        }
    }

    /// The neighbours on the line, counter-clockwise from the right.
    fn neighbours(&self, path_grid: &PathGrid, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let bits = self.cells[cell];
        path_grid.neighbours(cell).into_iter().enumerate().filter(move |(k, _)| bits & 1 << k != 0).map(|(_, c)| c)
    }

    /// Its cells, in their order.
    fn cells(&self) -> Vec<usize> {
        self.cells.iter().filter(|(_, bits)| bits & ON_LINE != 0).map(|(cell, _)| cell).collect()
    }
}

/// True for a cell on the line without which neither connectivity nor holes are others: a simple point.
fn can_be_removed(bits: u16) -> bool {
    bits & ON_LINE != 0 && SIMPLE[usize::from(bits & 0xff)]
}

/// The skeleton cells after removing cells from the border inwards, while connectivity and holes are preserved. `anchors`
/// stay. Cells are connected along sides, and across corners that are not between two unreachable cells.
///
/// The result has lines between anchors along the middle of the free space and loops around obstacles, and nothing else.
///
/// # Source
/// Distance-ordered homotopic thinning: Pudney, "Distance-Ordered Homotopic Thinning", Computer Vision and Image
/// Understanding 72(3), 1998, with anchors in the place of end points.
pub(crate) fn skeleton(path_grid: &PathGrid, anchors: &[usize]) -> Line {
    let mut line = Line::of_all(path_grid);
    // Neighbours of cells as before, but never taken off.
    anchors.iter().for_each(|&cell| line.cells[cell] &= !ON_LINE);
    let mut waiting = Vec::new();
    for next in by_distance(path_grid) {
        let bits = &mut line.cells[next as usize];
        *bits |= TRIED;
        if can_be_removed(*bits) {
            waiting.push(next as usize);
        }
        while let Some(cell) = waiting.pop() {
            // Another one may be needed now.
            if can_be_removed(line.cells[cell]) {
                line.remove(path_grid, cell, |beside| waiting.push(beside));
            }
        }
    }
    anchors.iter().for_each(|&cell| line.cells[cell] |= ON_LINE);
    line
}

/// The reachable cells by their distance from what is not, then by number.
fn by_distance(path_grid: &PathGrid) -> Vec<u32> {
    let ranked = || path_grid.ranks().iter().filter(|(_, rank)| *rank != 0).map(|(cell, rank)| (cell, rank as usize));
    // Counted, not compared: most of many cells share a few distances.
    let mut next: Vec<u32> = Vec::new();
    ranked().for_each(|(_, rank)| {
        if rank >= next.len() {
            next.resize(rank + 1, 0);
        }
        next[rank] += 1;
    });
    let mut n_cells = 0;
    for place in &mut next {
        (*place, n_cells) = (n_cells, n_cells + *place);
    }
    let mut order = vec![0; n_cells as usize];
    ranked().for_each(|(cell, rank)| {
        let place = &mut next[rank];
        order[*place as usize] = cell as u32;
        *place += 1;
    });
    order
}

/// A chain of skeleton cells between two nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chain {
    /// Indices of the nodes at its ends.
    pub(crate) nodes: [usize; 2],
    /// Its cells, from one node to the other.
    pub(crate) cells: Vec<usize>,
    /// True if the nodes touch.
    pub(crate) is_direct: bool,
}

/// Nodes and chains of a skeleton. The nodes are the anchors, in their order, then the junctions. A loop at one node is cut
/// into three chains.
pub(crate) fn trace(path_grid: &PathGrid, line: &Line, anchors: &[usize]) -> (Vec<usize>, Vec<Chain>) {
    let (floor, on_line) = (line.cells.cells(), line.cells());
    let node = floor.layer(NO_NODE);
    let mut tracer = LineTracer { path_grid, line, node, nodes: anchors.to_vec(), chains: Vec::new() };
    anchors.iter().zip(0..).for_each(|(&cell, number)| tracer.node[cell] = number);
    tracer.find_junctions(&on_line);
    let mut walked = floor.layer(false);
    for &cell in &on_line {
        if tracer.node[cell] != NO_NODE {
            tracer.trace_from(cell, &mut walked);
        }
    }
    // Closed loops without a node.
    for &cell in &on_line {
        if tracer.node[cell] == NO_NODE && !walked[cell] {
            tracer.add_node(cell);
            tracer.trace_from(cell, &mut walked);
        }
    }
    tracer.extend_to_nodes();
    tracer.cut_loops();
    (tracer.nodes, tracer.chains)
}

/// Of cells that belong to no node.
const NO_NODE: u32 = u32::MAX;

struct LineTracer<'a> {
    path_grid: &'a PathGrid,
    line: &'a Line,
    /// Node of each cell.
    node: SparseLayer<u32>,
    nodes: Vec<usize>,
    chains: Vec<Chain>,
}

impl LineTracer<'_> {
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        self.line.neighbours(self.path_grid, cell)
    }

    fn add_node(&mut self, cell: usize) {
        self.node[cell] = self.nodes.len() as u32;
        self.nodes.push(cell);
    }

    /// Makes nodes of cells with other than two neighbours; those that touch each other or an anchor are one node.
    fn find_junctions(&mut self, on_line: &[usize]) {
        for &cell in on_line {
            let is_junction = |tracer: &Self, c: usize| tracer.node[c] == NO_NODE && tracer.neighbours(c).count() != 2;
            if !is_junction(self, cell) {
                continue;
            }
            let mut cluster = vec![cell];
            let mut k = 0;
            while let Some(&c) = cluster.get(k) {
                let others: Vec<usize> = self.neighbours(c).filter(|n| is_junction(self, *n)).collect();
                cluster.extend(others.into_iter().filter(|n| !cluster.contains(n)).collect::<Vec<_>>());
                k += 1;
            }
            // Of several anchors the last one counts.
            let beside = cluster.iter().flat_map(|&c| self.neighbours(c)).map(|n| self.node[n]);
            let anchor = beside.filter(|node| *node != NO_NODE).max();
            let number = anchor.unwrap_or(self.nodes.len() as u32);
            if anchor.is_none() {
                self.nodes.push(cell);
            }
            cluster.into_iter().for_each(|c| self.node[c] = number);
        }
    }

    fn trace_from(&mut self, start: usize, walked: &mut SparseLayer<bool>) {
        let first = self.node[start];
        for next in self.neighbours(start).collect::<Vec<_>>() {
            let mut cells = vec![start];
            let (mut before, mut at) = (start, next);
            while self.node[at] == NO_NODE && !walked[at] {
                walked[at] = true;
                cells.push(at);
                // Does not return at once to another cell of the start node.
                let onward = |&c: &usize| c != before && (cells.len() > 2 || self.node[c] != first);
                let Some(on) = self.neighbours(at).find(onward).or_else(|| self.neighbours(at).find(|c| *c != before))
                else {
                    break;
                };
                (before, at) = (at, on);
            }
            let last = self.node[at];
            // A chain already traced from its other end, or two cells of one node.
            if last == NO_NODE || (cells.len() == 1 && last <= first) {
                continue;
            }
            cells.push(at);
            let nodes = [first, last].map(|node| node as usize);
            let is_known = |c: &Chain| c.nodes == nodes && c.is_direct;
            let is_direct = cells.len() == 2;
            if !is_direct || !self.chains.iter().any(is_known) {
                self.chains.push(Chain { nodes, cells, is_direct });
            }
        }
    }

    /// Extends chains, which end in any cell of a node, to the main cell of the node.
    fn extend_to_nodes(&mut self) {
        for mut chain in std::mem::take(&mut self.chains) {
            for end in [1, 0] {
                if let Some(&last) = chain.cells.last() {
                    chain.cells.extend(self.way_inside(last, self.nodes[chain.nodes[end]]));
                }
                chain.cells.reverse();
            }
            self.chains.push(chain);
        }
    }

    /// The cells after `from` on the path to another cell of its node.
    fn way_inside(&self, from: usize, to: usize) -> Vec<usize> {
        // Searched from the end, so that every cell has its successor.
        let mut next = vec![(to, to)];
        let mut at = 0;
        while at < next.len() && next.iter().all(|n| n.0 != from) {
            let cell = next[at].0;
            at += 1;
            for other in self.neighbours(cell).filter(|&c| self.node[c] == self.node[to]) {
                if next.iter().all(|n| n.0 != other) {
                    next.push((other, cell));
                }
            }
        }
        let after = |cell: usize| next.iter().find(|n| n.0 == cell && n.0 != n.1).map(|n| n.1);
        std::iter::successors(after(from), |&cell| after(cell)).collect()
    }

    fn cut_loops(&mut self) {
        for chain in std::mem::take(&mut self.chains) {
            let n = chain.cells.len();
            if chain.nodes[0] != chain.nodes[1] {
                self.chains.push(chain);
            } else if n > 6 {
                let [a, b] = [n / 3, 2 * n / 3];
                let [i, j] = [a, b].map(|k| {
                    self.add_node(chain.cells[k]);
                    self.nodes.len() - 1
                });
                let whole = chain.nodes[0];
                for (nodes, range) in [([whole, i], 0..a + 1), ([i, j], a..b + 1), ([j, whole], b..n)] {
                    self.chains.push(Chain { nodes, cells: chain.cells[range].to_vec(), is_direct: false });
                }
            }
        }
    }
}

/// Of the reachable neighbours of a cell, as bits, those with which it is connected: along sides, and across corners that are not
/// between two unreachable cells.
static NEAR: [u8; 256] = {
    let mut table = [0; 256];
    let mut open = 0;
    while open < 256 {
        let sides = open as u8 & 0b0101_0101;
        table[open] = sides | (open as u8 & 0b1010_1010 & (sides.rotate_left(1) | sides.rotate_right(1)));
        open += 1;
    }
    table
};

static SIMPLE: [bool; 256] = simple_table();

const fn simple_table() -> [bool; 256] {
    let mut table = [false; 256];
    let mut bits = 0;
    while bits < 256 {
        // Connectivity number of Yokoi, Toriwaki, Fukumura, 1975.
        let (mut n, mut k) = (0, 0);
        while k < 8 {
            let here = bits & (1 << k) == 0;
            let next = bits & (1 << ((k + 1) % 8)) == 0;
            let after = bits & (1 << ((k + 2) % 8)) == 0;
            if here && !(next && after) {
                n += 1;
            }
            k += 2;
        }
        table[bits] = n == 1;
        bits += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::FreeSpace;
    use crate::free_space::tests::{drawn, floors};
    use messages::Grid;
    use proptest::prelude::*;

    /// The floor of a drawing, and the cells that show an anchor: capital letters, in their order.
    fn path_grid(text: &str) -> (PathGrid, Vec<usize>) {
        let buffer = drawn(text);
        let free_space = FreeSpace::of(&Grid::open(buffer.bytes()).unwrap(), 0.1);
        let path_grid = PathGrid::of(&free_space, |_| true).unwrap();
        let rows: Vec<&[u8]> = text.lines().filter(|l| !l.is_empty()).map(str::as_bytes).rev().collect();
        let mut anchors: Vec<(u8, usize)> = Vec::new();
        for cell in (0..free_space.spec.n_cells()).filter(|&c| free_space.part(c) != 0) {
            let character = rows[cell / rows[0].len()][cell % rows[0].len()];
            if character.is_ascii_uppercase() {
                anchors.push((character, path_grid.cell_at(free_space.middle(cell)).unwrap()));
            }
        }
        anchors.sort_unstable();
        (path_grid, anchors.into_iter().map(|a| a.1).collect())
    }

    fn lines_of(text: &str) -> (PathGrid, Line, Vec<usize>, Vec<Chain>) {
        let (path_grid, anchors) = path_grid(text);
        let line = skeleton(&path_grid, &anchors);
        let (nodes, chains) = trace(&path_grid, &line, &anchors);
        assert_eq!(nodes[..anchors.len()], anchors);
        chains.iter().for_each(|chain| assert_whole(&path_grid, &line, &nodes, chain));
        (path_grid, line, nodes, chains)
    }

    /// A chain leads from the cell of its one node to that of the other, from neighbour to neighbour.
    fn assert_whole(path_grid: &PathGrid, line: &Line, nodes: &[usize], chain: &Chain) {
        assert_eq!(chain.nodes.map(|n| nodes[n]), [chain.cells[0], *chain.cells.last().unwrap()]);
        for pair in chain.cells.windows(2) {
            assert!(
                line.cells[pair[0]] & ON_LINE != 0 && line.neighbours(path_grid, pair[0]).any(|c| c == pair[1]),
                "{pair:?}"
            );
        }
    }

    fn n_on(line: &Line) -> usize {
        line.cells().len()
    }

    const RING: &str = "
#############
#...........#
#...........#
#...#####...#
#...#####...#
#...#####...#
#...........#
#...........#
#############";

    #[test]
    fn a_ring_stays_a_ring() {
        let (path_grid, line, nodes, chains) = lines_of(RING);
        let on = line.cells();
        assert!(on.iter().all(|&c| line.neighbours(&path_grid, c).count() == 2), "a line without ends");
        assert!(n_on(&line) >= 20 && on.iter().all(|&c| path_grid.squared[c] >= 1));
        // Cut into three, so that no two edges join the same nodes and none joins a node with itself.
        assert_eq!((nodes.len(), chains.len()), (3, 3));
        let n_cells: usize = chains.iter().map(|c| c.cells.len() - 1).sum();
        assert_eq!(n_cells, n_on(&line), "nothing of it is left out");
        let mut pairs: Vec<[usize; 2]> =
            chains.iter().map(|c| [c.nodes[0].min(c.nodes[1]), c.nodes[0].max(c.nodes[1])]).collect();
        pairs.sort_unstable();
        assert_eq!(pairs, [[0, 1], [0, 2], [1, 2]]);
    }

    #[test]
    fn a_floor_without_anchors_and_holes_shrinks_to_one_cell() {
        let (_, line, nodes, chains) = lines_of("########\n#......#\n#......#\n#......#\n#......#\n########");
        assert_eq!((n_on(&line), nodes.len(), chains.len()), (1, 1, 0));
    }

    #[test]
    fn a_line_leads_from_anchor_to_anchor_along_the_middle() {
        let (path_grid, line, nodes, chains) = lines_of(
            "
#################
#...............#
#...............#
#.A...........B.#
#...............#
#...............#
#################",
        );
        assert_eq!((n_on(&line), nodes.len(), chains.len()), (13, 2, 1));
        assert_eq!(chains[0].nodes, [0, 1]);
        assert!(chains[0].cells.windows(2).all(|c| c[1] == c[0] + 1), "straight");
        assert!(
            chains[0].cells.iter().all(|&c| path_grid.squared[c] >= 4),
            "in the middle, anchors nearer to walls aside"
        );
    }

    #[test]
    fn an_anchor_alone_is_all_that_stays() {
        let (_, line, nodes, chains) = lines_of("#######\n#.....#\n#A....#\n#.....#\n#######");
        assert_eq!((n_on(&line), nodes.len(), chains.len()), (1, 1, 0));
    }

    #[test]
    fn a_room_with_two_doors_is_passed_by_a_line_without_branches() {
        let (_, line, nodes, chains) = lines_of(
            "
#####################
#A......#############
#.......#.......#####
#.......#...........#
#...................#
#.......#.......#..B#
#.......#.......#####
#####################",
        );
        assert_eq!((nodes.len(), chains.len()), (2, 1));
        assert_eq!(chains[0].cells.len(), n_on(&line));
    }

    #[test]
    fn three_anchors_meet_in_one_junction() {
        let (_, _, nodes, chains) = lines_of(
            "
###############
#.............#
#A...........B#
#.............#
#.............#
#.............#
#......C......#
###############",
        );
        assert_eq!((nodes.len(), chains.len()), (4, 3));
        let mut anchors: Vec<usize> = chains.iter().map(|c| c.nodes[0].min(c.nodes[1])).collect();
        anchors.sort_unstable();
        assert_eq!(anchors, [0, 1, 2]);
        assert!(chains.iter().all(|c| c.nodes[0].max(c.nodes[1]) == 3));
    }

    #[test]
    fn no_line_squeezes_between_cells_that_meet_at_a_corner() {
        // The two halves meet at a corner only.
        let (_, line, _, chains) = lines_of("#########\n#A..#####\n#...#####\n####....#\n####...B#\n#########");
        assert_eq!((n_on(&line), chains.len()), (2, 0), "each is an anchor alone");
        // A way around the pillar leads from half to half; on its other side is the corner, and no way.
        let (_, line, nodes, chains) = lines_of(
            "
#########
#.......#
#A..#...#
####....#
####...B#
#########",
        );
        assert_eq!((nodes.len(), chains.len()), (2, 1));
        assert_eq!(chains[0].cells.len(), n_on(&line));
    }

    /// Number of pieces connected along sides, and along corners if requested.
    fn n_pieces(of: &[bool], width: usize, corners: bool) -> usize {
        let mut left = of.to_vec();
        let mut n = 0;
        for start in 0..left.len() {
            n += usize::from(left[start]);
            let mut waiting = if left[start] { vec![start] } else { Vec::new() };
            while let Some(cell) = waiting.pop() {
                let at = [cell % width, cell / width];
                if !std::mem::replace(&mut left[cell], false) {
                    continue;
                }
                for (dx, dy) in [(2, 1), (1, 2), (0, 1), (1, 0), (2, 2), (0, 2), (0, 0), (2, 0)] {
                    let (x, y) = ((at[0] + dx).wrapping_sub(1), (at[1] + dy).wrapping_sub(1));
                    let is_near = corners || dx == 1 || dy == 1;
                    if is_near && x < width && y < left.len() / width && left[y * width + x] {
                        waiting.push(y * width + x);
                    }
                }
            }
        }
        n
    }

    /// Number of connected components of the nodes over chains.
    fn n_graphs(n_nodes: usize, chains: &[Chain]) -> usize {
        let mut piece: Vec<usize> = (0..n_nodes).collect();
        for chain in chains {
            let [a, b] = chain.nodes.map(|n| piece[n]);
            piece.iter_mut().filter(|p| **p == a).for_each(|p| *p = b);
        }
        piece.sort_unstable();
        piece.dedup();
        piece.len()
    }

    proptest! {
        #[test]
        fn lines_have_the_pieces_and_the_loops_of_the_floor(
            text in floors(),
            anchors in prop::collection::vec((1usize..25, 1usize..17), 0..5),
        ) {
            let mut rows: Vec<Vec<u8>> = text.lines().map(|l| l.as_bytes().to_vec()).collect();
            let mut placed: Vec<(usize, usize)> = Vec::new();
            for (letter, (x, y)) in (b'A'..).zip(anchors) {
                // Anchors that touch make a triangle with a line that ends at both.
                let is_apart = placed.iter().all(|p| p.0.abs_diff(x).max(p.1.abs_diff(y)) > 2);
                if rows[y][x] == b'.' && is_apart {
                    rows[y][x] = letter;
                    placed.push((x, y));
                }
            }
            let text = rows.iter().map(|r| String::from_utf8_lossy(r)).collect::<Vec<_>>().join("\n");
            prop_assume!(text.contains('.'));
            let (path_grid, _, nodes, chains) = lines_of(&text);
            let open: Vec<bool> = (0..path_grid.open.cells().n_cells()).map(|cell| path_grid.open[cell]).collect();
            let closed: Vec<bool> = open.iter().map(|o| !o).collect();
            let (n_parts, n_holes) = (n_pieces(&open, path_grid.width, false), n_pieces(&closed, path_grid.width, true) - 1);
            prop_assert_eq!(n_graphs(nodes.len(), &chains), n_parts, "pieces of\n{}", text);
            // Of a graph, loops are edges beyond those of a tree.
            prop_assert_eq!(chains.len() + n_parts - nodes.len(), n_holes, "loops of\n{}", text);
        }
    }
}
