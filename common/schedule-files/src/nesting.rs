//! Order of tasks in which each stands behind the one it is nested in.

/// An order of nodes with parents first, otherwise as they come, and the nodes whose parent has to be forgotten because they would
/// be nested in themselves.
///
/// # Panics
/// If a parent is not below `parents.len()`.
pub(crate) fn parents_first(parents: &[Option<usize>]) -> (Vec<usize>, Vec<usize>) {
    let mut order = Vec::with_capacity(parents.len());
    let mut cut = Vec::new();
    // On which walk a node was met; 0 for none.
    let mut met = vec![0; parents.len()];
    let mut path = Vec::new();
    for (walk, start) in (1..).zip(0..parents.len()) {
        let mut at = start;
        while met[at] == 0 {
            met[at] = walk;
            path.push(at);
            match parents[at] {
                None => break,
                Some(parent) if met[parent] == walk => cut.push(at),
                Some(parent) => at = parent,
            }
        }
        order.extend(path.drain(..).rev());
    }
    (order, cut)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_node_stands_once_and_behind_its_parent(
            parents in prop::collection::vec(prop::option::of(0..20usize), 20),
        ) {
            let (order, cut) = parents_first(&parents);
            let mut place = vec![usize::MAX; parents.len()];
            order.iter().enumerate().for_each(|(k, node)| place[*node] = k);
            prop_assert!(order.len() == parents.len() && place.iter().all(|p| *p != usize::MAX));
            for (node, parent) in parents.iter().enumerate() {
                if let Some(parent) = parent.filter(|_| !cut.contains(&node)) {
                    prop_assert!(place[parent] < place[node]);
                }
            }
        }
    }

    #[test]
    fn only_circles_are_cut() {
        assert_eq!(parents_first(&[Some(1), None, Some(0)]), (vec![1, 0, 2], vec![]));
        assert_eq!(parents_first(&[Some(1), Some(0), Some(0)]).1, [1]);
        assert_eq!(parents_first(&[Some(0)]).1, [0]);
    }
}
