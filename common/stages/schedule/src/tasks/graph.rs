//! Topological order of tasks, dependency cycles, and what a task is called.

use messages::{NONE, SequenceRecord, Site, TaskRecord, task_flags};
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use std::collections::HashMap;

/// Tasks in groups: what a task depends on comes before it. A group of more than one is a cycle.
pub(crate) struct Order {
    groups: Vec<Vec<u32>>,
    is_cycle: Vec<bool>,
}

impl Order {
    /// Orders tasks by `(dependent, what it depends on)`.
    pub(crate) fn of(n_tasks: usize, edges: impl Iterator<Item = (u32, u32)>) -> Self {
        let mut graph = DiGraph::<(), (), u32>::with_capacity(n_tasks, n_tasks);
        for _ in 0..n_tasks {
            graph.add_node(());
        }
        let mut on_themselves = vec![false; n_tasks];
        for (dependent, on) in edges {
            on_themselves[dependent as usize] |= dependent == on;
            graph.add_edge(NodeIndex::new(dependent as usize), NodeIndex::new(on as usize), ());
        }
        let mut groups: Vec<Vec<u32>> =
            kosaraju_scc(&graph).into_iter().map(|g| g.into_iter().map(|n| n.index() as u32).collect()).collect();
        groups.iter_mut().for_each(|group| group.sort_unstable());
        let is_cycle = groups.iter().map(|g| g.len() > 1 || on_themselves[g[0] as usize]).collect();
        Self { groups, is_cycle }
    }

    /// The groups, and whether each is a cycle.
    pub(crate) fn groups(&self) -> impl DoubleEndedIterator<Item = (&[u32], bool)> {
        self.groups.iter().map(Vec::as_slice).zip(self.is_cycle.iter().copied())
    }
}

/// Summary tasks with the tasks nested in them.
pub(super) fn nesting(site: &Site<'_>) -> impl Iterator<Item = (u32, u32)> {
    site.schedule.tasks.iter().zip(0..).filter(|(t, _)| t.parent != NONE).map(|(t, k)| (t.parent, k))
}

/// All dependencies, whether dates are written or not: for cycles, delays and floats.
pub(crate) fn dependencies(site: &Site<'_>) -> Order {
    Order::of(site.schedule.tasks.len(), nesting(site).chain(edges(site)))
}

/// Tasks with those that decide their dates: by a sequence, or because they span them.
pub(super) fn edges(site: &Site<'_>) -> impl Iterator<Item = (u32, u32)> {
    let of_sequence = move |s: &SequenceRecord| match decides(site, s) {
        true => (s.successor, s.predecessor),
        false => (s.predecessor, s.successor),
    };
    site.schedule.sequences.iter().map(of_sequence).chain(beside_wbs_summaries(site))
}

/// WBS summaries with the tasks that are nested in the same task.
fn beside_wbs_summaries(site: &Site<'_>) -> Vec<(u32, u32)> {
    let is_wbs = |task: &TaskRecord| task.has(task_flags::WBS_SUMMARY) && task.parent != NONE;
    let mut summaries: HashMap<u32, Vec<u32>> = HashMap::new();
    for (k, task) in (0..).zip(site.schedule.tasks).filter(|(_, task)| is_wbs(task)) {
        summaries.entry(task.parent).or_default().push(k);
    }
    let of_task = |(k, task): (u32, &TaskRecord)| {
        let beside = summaries.get(&task.parent).filter(|_| !is_wbs(task));
        beside.into_iter().flatten().map(|summary| (*summary, k)).collect::<Vec<_>>()
    };
    (0..).zip(site.schedule.tasks).flat_map(of_task).collect()
}

/// True if the dates of a task are those of what it spans.
pub(crate) fn is_span(site: &Site<'_>, task: u32) -> bool {
    site.schedule.tasks[task as usize].has(task_flags::SPAN)
}

/// False for a sequence behind a span, which decides nothing for its successor, but when the span ends.
pub(crate) fn decides(site: &Site<'_>, sequence: &SequenceRecord) -> bool {
    !is_span(site, sequence.predecessor) || is_span(site, sequence.successor)
}

/// Name of a task for people, its GlobalId where it has none.
pub(crate) fn label(site: &Site<'_>, task: usize) -> String {
    let record = &site.schedule.tasks[task];
    let name = site.schedule.text(record.name);
    if name.is_empty() { site.schedule.text(record.global_id).to_owned() } else { format!("{name:?}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_task_depends_on_comes_first_and_cycles_are_groups() {
        let order = Order::of(6, [(0, 1), (1, 2), (3, 4), (4, 3), (5, 5), (3, 0)].into_iter());
        let groups: Vec<(Vec<u32>, bool)> = order.groups().map(|(g, c)| (g.to_vec(), c)).collect();
        let at = |task: u32| groups.iter().position(|(g, _)| g.contains(&task)).unwrap();
        assert!(at(2) < at(1) && at(1) < at(0) && at(0) < at(3));
        assert_eq!((at(3), groups[at(3)].1, groups[at(5)].1, groups[at(0)].1), (at(4), true, true, false));
    }

    #[test]
    fn a_chain_of_a_hundred_thousand_tasks_does_not_exhaust_the_stack() {
        let n = 100_000;
        let order = Order::of(n as usize, (1..n).map(|k| (k, k - 1)));
        assert_eq!(order.groups().next().map(|(g, _)| g[0]), Some(0));
    }
}
