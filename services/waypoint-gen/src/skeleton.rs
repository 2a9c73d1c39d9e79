//! The middle lines of the floor: where ways run, and where they meet.

use crate::walk::Walk;

/// The cells that remain when cells are taken away from the border of the floor on, nearest to the border first, as long as
/// what hangs together still does and every hole is still gone around. `anchors` stay.
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
            if !line[cell] || stays[cell] || !is_simple(&line, cell, walk.width) {
                continue;
            }
            line[cell] = false;
            // What was needed before may be needless now.
            again.extend(around(cell, walk.width).into_iter().filter(|&c| line[c] && rank(c) < now));
        }
    }
    line
}

/// A way along the middle lines.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chain {
    /// Numbers of the nodes at its ends.
    pub(crate) nodes: [usize; 2],
    /// Its cells, those of the nodes included.
    pub(crate) cells: Vec<usize>,
    /// True if the nodes touch.
    pub(crate) is_direct: bool,
}

/// Nodes and the ways between them: first the anchors, in their order, then the cells where lines meet. A loop that comes
/// back to its node is cut into three.
pub(crate) fn trace(line: &[bool], width: usize, anchors: &[usize]) -> (Vec<usize>, Vec<Chain>) {
    let mut tracer =
        Tracer { line, width, node: vec![usize::MAX; line.len()], nodes: anchors.to_vec(), chains: Vec::new() };
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
    tracer.cut_loops();
    (tracer.nodes, tracer.chains)
}

struct Tracer<'a> {
    line: &'a [bool],
    width: usize,
    /// Node of each cell.
    node: Vec<usize>,
    nodes: Vec<usize>,
    chains: Vec<Chain>,
}

impl Tracer<'_> {
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> {
        around(cell, self.width).into_iter().filter(|&c| self.line[c])
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
                // A node of several cells is at one of them.
                let [from, to] = [first, last].map(|node| self.nodes[node]);
                if cells[0] != from {
                    cells.insert(0, from);
                }
                if at != to {
                    cells.push(to);
                }
                self.chains.push(Chain { nodes: [first, last], cells, is_direct });
            }
        }
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

/// True if what hangs together around the cell, corners included, still does without it, and no hole appears.
fn is_simple(line: &[bool], cell: usize, width: usize) -> bool {
    let bits = around(cell, width).into_iter().enumerate().fold(0u8, |bits, (k, c)| bits | u8::from(line[c]) << k);
    SIMPLE[bits as usize]
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
