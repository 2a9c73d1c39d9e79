//! Dependencies that go in circles.

use crate::nesting::parents_first;
use crate::plan::{Dependency, Finding, FindingKind, PlanTask};

/// Tasks of a circle that a finding names.
const MAX_NAMED: usize = 8;

/// Findings about tasks that wait for themselves through others: one for each circle, about one of its tasks. What is behind a circle
/// is not in it.
pub(crate) fn find_circles(tasks: &[PlanTask], dependencies: &[Dependency], findings: &mut Vec<Finding>) {
    let is_left = left_over(tasks.len(), dependencies);
    // Every task that is left waits for another that is left: going back along one of them ends in a circle.
    let mut waits_for = vec![None; tasks.len()];
    for &Dependency { predecessor, successor, .. } in dependencies {
        if is_left[successor] && is_left[predecessor] {
            waits_for[successor].get_or_insert(predecessor);
        }
    }
    for task in parents_first(&waits_for).1 {
        let mut circle = vec![name(&tasks[task])];
        let mut at = waits_for[task];
        while let Some(next) = at.filter(|next| *next != task && circle.len() < MAX_NAMED) {
            circle.push(name(&tasks[next]));
            at = waits_for[next];
        }
        let more = if at == Some(task) { "" } else { " and others" };
        let message = format!("it waits for itself: {}{more}", circle.join(", which waits for "));
        findings.push(Finding { task: Some(task), kind: FindingKind::Circle, message });
    }
}

fn name(task: &PlanTask) -> &str {
    [&task.code, &task.name].into_iter().find(|name| !name.is_empty()).unwrap_or(&task.uid)
}

/// Tasks in circles and behind them: what is left when tasks that wait for none are taken away again and again.
fn left_over(n: usize, dependencies: &[Dependency]) -> Vec<bool> {
    let mut sorted: Vec<_> = dependencies.iter().map(|link| (link.predecessor, link.successor)).collect();
    sorted.sort_unstable();
    let mut n_waited_for = vec![0_usize; n];
    for (_, successor) in &sorted {
        n_waited_for[*successor] += 1;
    }
    let mut free: Vec<_> = (0..n).filter(|task| n_waited_for[*task] == 0).collect();
    while let Some(task) = free.pop() {
        let first = sorted.partition_point(|(predecessor, _)| *predecessor < task);
        for (_, successor) in sorted[first..].iter().take_while(|(predecessor, _)| *predecessor == task) {
            n_waited_for[*successor] -= 1;
            if n_waited_for[*successor] == 0 {
                free.push(*successor);
            }
        }
    }
    n_waited_for.iter().map(|n| *n > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::DependencyKind;

    fn messages(links: &[(usize, usize)]) -> Vec<(usize, String)> {
        let tasks: Vec<_> = (0..20).map(|k| PlanTask { code: format!("A{k}"), ..Default::default() }).collect();
        let dependency = |&(predecessor, successor): &(usize, usize)| {
            let kind = DependencyKind::StartStart;
            Dependency { predecessor, successor, kind, lag: None }
        };
        let mut findings = Vec::new();
        find_circles(&tasks, &links.iter().map(dependency).collect::<Vec<_>>(), &mut findings);
        findings.into_iter().map(|finding| (finding.task.unwrap(), finding.message)).collect()
    }

    #[test]
    fn circles_are_found_once_and_what_is_around_them_is_not() {
        assert_eq!(messages(&[(0, 1), (1, 2), (0, 2), (0, 2), (3, 2)]), []);
        let found = messages(&[(0, 1), (1, 2), (2, 3), (3, 1), (3, 4), (4, 5), (7, 8), (8, 7)]);
        let expected = [
            (2, "it waits for itself: A2, which waits for A1, which waits for A3".to_owned()),
            (8, "it waits for itself: A8, which waits for A7".to_owned()),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_long_circle_is_cut_short() {
        let links: Vec<_> = (0..20).map(|k| (k, (k + 1) % 20)).collect();
        let found = messages(&links);
        assert!(found.len() == 1 && found[0].1.ends_with(" and others"), "{found:?}");
    }
}
