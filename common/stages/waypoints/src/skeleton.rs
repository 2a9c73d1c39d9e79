//! Skeleton of the free space by thinning: centre lines and junctions.

use crate::walk::Walk;

/// The cells that remain when cells are taken away from the border of the floor on, nearest to the border first, as long as
/// what hangs together still does and every hole is still gone around. `anchors` stay. Cells hang together along sides, and
/// across corners where the robot does not squeeze between two cells that it cannot get to.
///
/// So there are lines from anchor to anchor along the middle, loops around what stands in the way, and nothing else.
///
/// # Source
/// Distance-ordered homotopic thinning: Pudney, "Distance-Ordered Homotopic Thinning", Computer Vision and Image
/// Understanding 72(3), 1998, with anchors in the place of end points.
pub(crate) fn skeleton(walk: &Walk, anchors: &[usize]) -> Vec<bool> {
    let mut stays = vec![false; walk.open.len()];
    anchors.iter().for_each(|&cell| stays[cell] = true);
    let mut line = walk.open.clone();
    let mut order: Vec<u32> = (0..line.len() as u32).filter(|&c| line[c as usize]).collect();
    order.sort_by_key(|&c| (walk.squared[c as usize], c));
    let rank = |cell: usize| (walk.squared[cell], cell);
    let mut again = Vec::new();
    for cell in order {
        again.push(cell as usize);
        let now = rank(cell as usize);
        while let Some(cell) = again.pop() {
            if !line[cell] || stays[cell] || !is_simple(walk, &line, cell) {
                continue;
            }
            line[cell] = false;
            // What was needed before may be needless now.
            again.extend(neighbours(walk, &line, cell).filter(|&c| rank(c) < now));
        }
    }
    line
}

/// A way along the middle lines.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chain {
    /// Numbers of the nodes at its ends.
    pub(crate) nodes: [usize; 2],
    /// Its cells, from that of one node to that of the other.
    pub(crate) cells: Vec<usize>,
    /// True if the nodes touch.
    pub(crate) is_direct: bool,
}

/// Nodes and the ways between them: first the anchors, in their order, then the cells where lines meet. A loop that comes
/// back to its node is cut into three.
pub(crate) fn trace(walk: &Walk, line: &[bool], anchors: &[usize]) -> (Vec<usize>, Vec<Chain>) {
    let mut tracer =
        Tracer { walk, line, node: vec![usize::MAX; line.len()], nodes: anchors.to_vec(), chains: Vec::new() };
    anchors.iter().enumerate().for_each(|(number, &cell)| tracer.node[cell] = number);
    tracer.find_junctions();
    let mut walked = vec![false; line.len()];
    let on_line = || line.iter().enumerate().filter(|(_, on)| **on).map(|(cell, _)| cell);
    for cell in on_line() {
        if tracer.node[cell] != usize::MAX {
            tracer.trace_from(cell, &mut walked);
        }
    }
    // Rings without any node.
    for cell in on_line() {
        if tracer.node[cell] == usize::MAX && !walked[cell] {
            tracer.add_node(cell);
            tracer.trace_from(cell, &mut walked);
        }
    }
    tracer.lead_to_nodes();
    tracer.cut_loops();
    (tracer.nodes, tracer.chains)
}

struct Tracer<'a> {
    walk: &'a Walk,
    line: &'a [bool],
    /// Node of each cell.
    node: Vec<usize>,
    nodes: Vec<usize>,
    chains: Vec<Chain>,
}

impl Tracer<'_> {
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> {
        neighbours(self.walk, self.line, cell)
    }

    fn add_node(&mut self, cell: usize) {
        self.node[cell] = self.nodes.len();
        self.nodes.push(cell);
    }

    /// Cells with other than two neighbours; those that touch each other, or an anchor, are one node.
    fn find_junctions(&mut self) {
        for cell in 0..self.line.len() {
            let is_junction =
                |tracer: &Self, c: usize| tracer.node[c] == usize::MAX && tracer.neighbours(c).count() != 2;
            if !self.line[cell] || !is_junction(self, cell) {
                continue;
            }
            let mut cluster = vec![cell];
            let mut k = 0;
            while let Some(&c) = cluster.get(k) {
                let others: Vec<usize> = self.neighbours(c).filter(|n| is_junction(self, *n)).collect();
                cluster.extend(others.into_iter().filter(|n| !cluster.contains(n)).collect::<Vec<_>>());
                k += 1;
            }
            // Of several anchors the last one.
            let beside = cluster.iter().flat_map(|&c| self.neighbours(c)).map(|n| self.node[n]);
            let anchor = beside.filter(|node| *node != usize::MAX).max();
            let number = anchor.unwrap_or(self.nodes.len());
            if anchor.is_none() {
                self.nodes.push(cell);
            }
            cluster.into_iter().for_each(|c| self.node[c] = number);
        }
    }

    fn trace_from(&mut self, start: usize, walked: &mut [bool]) {
        let first = self.node[start];
        for next in self.neighbours(start).collect::<Vec<_>>() {
            let mut cells = vec![start];
            let (mut before, mut at) = (start, next);
            while self.node[at] == usize::MAX && !walked[at] {
                walked[at] = true;
                cells.push(at);
                // A cell beside two of the start's node does not go back to it at once.
                let onward = |&c: &usize| c != before && (cells.len() > 2 || self.node[c] != first);
                let Some(on) = self.neighbours(at).find(onward).or_else(|| self.neighbours(at).find(|c| *c != before))
                else {
                    break;
                };
                (before, at) = (at, on);
            }
            let last = self.node[at];
            // A line that was walked from its other end, or two cells of one node.
            if last == usize::MAX || (cells.len() == 1 && last <= first) {
                continue;
            }
            cells.push(at);
            let is_known = |c: &Chain| c.nodes == [first, last] && c.is_direct;
            let is_direct = cells.len() == 2;
            if !is_direct || !self.chains.iter().any(is_known) {
                self.chains.push(Chain { nodes: [first, last], cells, is_direct });
            }
        }
    }

    /// Chains end in any of the cells that are one node: on to the cell that the node is named by.
    fn lead_to_nodes(&mut self) {
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

    /// The cells after `from` on the way to another cell of its node.
    fn way_inside(&self, from: usize, to: usize) -> Vec<usize> {
        // From the end on: every cell then knows the next.
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

/// Neighbours counter-clockwise from the right.
fn around(cell: usize, width: usize) -> [usize; 8] {
    let (up, down) = (cell + width, cell - width);
    [cell + 1, up + 1, up, up - 1, cell - 1, down - 1, down, down + 1]
}

/// The neighbours on a line.
fn neighbours(walk: &Walk, line: &[bool], cell: usize) -> impl Iterator<Item = usize> {
    let bits = bits_around(walk, line, cell);
    around(cell, walk.width).into_iter().enumerate().filter(move |(k, _)| bits & (1 << k) != 0).map(|(_, c)| c)
}

/// Which neighbours are on a line, without those across a corner between two cells that the robot cannot get to.
fn bits_around(walk: &Walk, line: &[bool], cell: usize) -> u8 {
    let around = around(cell, walk.width);
    let is_near = |k: usize| k.is_multiple_of(2) || walk.open[around[k - 1]] || walk.open[around[(k + 1) % 8]];
    (0..8).fold(0, |bits, k| bits | u8::from(line[around[k]] && is_near(k)) << k)
}

/// True if what hangs together around the cell still does without it, and no hole appears.
fn is_simple(walk: &Walk, line: &[bool], cell: usize) -> bool {
    SIMPLE[bits_around(walk, line, cell) as usize]
}

static SIMPLE: [bool; 256] = simple_table();

const fn simple_table() -> [bool; 256] {
    let mut table = [false; 256];
    let mut bits = 0;
    while bits < 256 {
        // Number of ways out along sides that are separate: Yokoi, Toriwaki, Fukumura, 1975.
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
    use crate::ground::Ground;
    use crate::ground::tests::{drawn, floors};
    use messages::Grid;
    use proptest::prelude::*;

    /// The floor of a drawing, and the cells that show an anchor: capital letters, in their order.
    fn walk(text: &str) -> (Walk, Vec<usize>) {
        let buffer = drawn(text);
        let ground = Ground::of(&Grid::open(buffer.bytes()).unwrap(), 0.1);
        let walk = Walk::of(&ground, |_| true).unwrap();
        let rows: Vec<&[u8]> = text.lines().filter(|l| !l.is_empty()).map(str::as_bytes).rev().collect();
        let mut anchors: Vec<(u8, usize)> = Vec::new();
        for cell in (0..ground.spec.n_cells()).filter(|&c| ground.part(c) != 0) {
            let character = rows[cell / rows[0].len()][cell % rows[0].len()];
            if character.is_ascii_uppercase() {
                anchors.push((character, walk.cell_at(ground.middle(cell)).unwrap()));
            }
        }
        anchors.sort_unstable();
        (walk, anchors.into_iter().map(|a| a.1).collect())
    }

    fn lines_of(text: &str) -> (Walk, Vec<bool>, Vec<usize>, Vec<Chain>) {
        let (walk, anchors) = walk(text);
        let line = skeleton(&walk, &anchors);
        let (nodes, chains) = trace(&walk, &line, &anchors);
        assert_eq!(nodes[..anchors.len()], anchors);
        chains.iter().for_each(|chain| assert_whole(&walk, &line, &nodes, chain));
        (walk, line, nodes, chains)
    }

    /// A chain leads from the cell of its one node to that of the other, from neighbour to neighbour.
    fn assert_whole(walk: &Walk, line: &[bool], nodes: &[usize], chain: &Chain) {
        assert_eq!(chain.nodes.map(|n| nodes[n]), [chain.cells[0], *chain.cells.last().unwrap()]);
        for pair in chain.cells.windows(2) {
            assert!(line[pair[0]] && neighbours(walk, line, pair[0]).any(|c| c == pair[1]), "{pair:?}");
        }
    }

    fn n_on(line: &[bool]) -> usize {
        line.iter().filter(|on| **on).count()
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
        let (walk, line, nodes, chains) = lines_of(RING);
        let on = (0..line.len()).filter(|&c| line[c]);
        assert!(on.clone().all(|c| neighbours(&walk, &line, c).count() == 2), "a line without ends");
        assert!(n_on(&line) >= 20 && on.clone().all(|c| walk.squared[c] >= 1));
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
        let (walk, line, nodes, chains) = lines_of(
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
        assert!(chains[0].cells.iter().all(|&c| walk.squared[c] >= 4), "in the middle, anchors nearer to walls aside");
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

    /// Numbers of pieces that hang together along sides, and along corners if asked for.
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

    /// Number of nodes that hang together over chains, each piece counted once.
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
            let (walk, _, nodes, chains) = lines_of(&text);
            let closed: Vec<bool> = walk.open.iter().map(|o| !o).collect();
            let (n_parts, n_holes) = (n_pieces(&walk.open, walk.width, false), n_pieces(&closed, walk.width, true) - 1);
            prop_assert_eq!(n_graphs(nodes.len(), &chains), n_parts, "pieces of\n{}", text);
            // Of a graph, loops are edges beyond those of a tree.
            prop_assert_eq!(chains.len() + n_parts - nodes.len(), n_holes, "loops of\n{}", text);
        }
    }
}
