//! The map storey that a robot is on.

/// What tells the storey, the first that does counts: the configuration, the alignment of the robot's map; else the lowest.
///
/// `n_storeys` are those that have a grid. `None` without one, or where the one that is meant is not among them.
pub(crate) fn storey_of_robot(configured: Option<u32>, aligned: Option<u32>, n_storeys: usize) -> Option<usize> {
    let storey = configured.or(aligned).unwrap_or(0) as usize;
    (storey < n_storeys).then_some(storey)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_configuration_goes_before_the_alignment() {
        assert_eq!(storey_of_robot(Some(1), Some(2), 3), Some(1));
        assert_eq!(storey_of_robot(None, Some(2), 3), Some(2));
        assert_eq!(storey_of_robot(None, None, 3), Some(0));
        assert_eq!(storey_of_robot(Some(3), None, 3), None, "another storey is never shown in its place");
        assert_eq!(storey_of_robot(None, None, 0), None);
    }
}
