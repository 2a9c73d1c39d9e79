//! Errors of rasterisation, and the check for blank maps.

use diagnostics::counted;
use frames::metres;
use grid::{Class, GridSpecError};
use messages::{Grid, MapGrids, MapStoreyRecord, Site, element_flags};

/// Errors of rasterisation.
#[derive(Debug, thiserror::Error)]
pub enum RasterizeError {
    /// The grid of a storey is impossible; the outermost elements are listed, because they are usually misplaced.
    #[error("storey {storey:?} has no grid{}", outermost_text(outermost))]
    Spec {
        /// Name of the storey.
        storey: String,
        /// Entities and GlobalIds of the elements at its bounds; none where spaces alone reach them.
        outermost: Vec<String>,
        /// Why.
        source: GridSpecError,
    },
    /// A margin of more than [`grid::MAX_REACH_CELLS`] cells.
    #[error("a margin of {margin_m} m is more than {max_cells} cells of {resolution_m} m: take a coarser resolution")]
    Margin {
        /// Margin of the robot profile.
        margin_m: f64,
        /// Maximum number of cells.
        max_cells: f64,
        /// Requested resolution.
        resolution_m: f64,
    },
    /// All storeys would be blank.
    #[error("the map would be blank: {}; --allow-empty writes it all the same", reasons.join("; "))]
    Blank {
        /// Reasons of the model, then of each storey, as phrases.
        reasons: Vec<String>,
    },
    /// A storey with spaces but without obstacles.
    #[error("storey {storey:?} has {} and no obstacle; --allow-empty writes it all the same", counted(*n_spaces, "space"))]
    NoObstacle {
        /// Name of the storey.
        storey: String,
        /// Number of its spaces.
        n_spaces: usize,
    },
}

/// Checks that the map of a complete model is not blank.
///
/// # Errors
/// All storeys blank or none at all, or a storey with spaces and without any obstacle.
pub fn check_not_blank(site: &Site<'_>, grids: &dyn MapGrids) -> Result<(), RasterizeError> {
    let has_obstacle = |g: &Grid<'_>| g.class.iter().any(|&c| c != Class::None.id());
    // Of each storey, whether it has an obstacle, and whether it has floor.
    let holds: Vec<[bool; 2]> = grids.each(|g| [has_obstacle(g), g.floor.iter().any(|&f| f != 0)]).collect();
    if !holds.iter().flatten().any(|&holds| holds) {
        return Err(RasterizeError::Blank { reasons: blank_reasons(site) });
    }
    for (head, _) in grids.heads().zip(&holds).filter(|(_, [has_obstacle, _])| !has_obstacle) {
        let n_spaces = site.spaces.iter().filter(|s| s.map_storey == head.map_storey).count();
        if n_spaces > 0 {
            let storey = site.text(site.map_storeys[head.map_storey as usize].name).to_owned();
            return Err(RasterizeError::NoObstacle { storey, n_spaces });
        }
    }
    Ok(())
}

/// Maximum number of storeys whose reasons are listed.
const MAX_REASONS: usize = 12;

/// Reasons for a blank map: what the model lacks, then what each storey lacks.
fn blank_reasons(site: &Site<'_>) -> Vec<String> {
    let mut reasons = vec![elements_reason(site)];
    if site.storeys.is_empty() {
        reasons.push("the model has no storeys and nothing that a storey could be made from".to_owned());
    }
    let unmapped = site.storeys.iter().filter(|s| s.map_storey == messages::NONE && s.why.length > 0);
    let of_storeys = unmapped.map(|s| storey_reason(site.text(s.name), site.text(s.why)));
    let of_maps = site.map_storeys.iter().map(|s| storey_reason(site.text(s.name), &empty_reason(site, s)));
    let mut all: Vec<String> = of_maps.chain(of_storeys).collect();
    let n_left_out = all.len().saturating_sub(MAX_REASONS);
    all.truncate(MAX_REASONS);
    reasons.extend(all);
    if n_left_out > 0 {
        reasons.push(format!("and {}", counted(n_left_out, "other storey")));
    }
    reasons
}

fn storey_reason(name: &str, why: &str) -> String {
    if name.is_empty() { format!("a storey without a name: {why}") } else { format!("storey {name:?}: {why}") }
}

/// Reason from the number of elements with bodies.
fn elements_reason(site: &Site<'_>) -> String {
    let n = site.elements.len();
    let has = |flag: u32| site.elements.iter().filter(|e| e.has(flag)).count();
    let n_failed = has(element_flags::FAILED);
    match site.elements.iter().filter(|e| e.n_parts > 0).count() {
        _ if n == 0 => "the model has no elements".to_owned(),
        0 if n_failed > 0 => {
            format!("of {} none has a body, and {n_failed} of the bodies could not be made", counted(n, "element"))
        }
        0 => format!("of {} none has a body", counted(n, "element")),
        n_bodies => {
            let n_boxes = has(element_flags::BOUNDING_BOX);
            format!("of {} {n_bodies} have a body, {n_boxes} of them a bounding box only", counted(n, "element"))
        }
    }
}

/// Reason why the map of a storey is empty.
fn empty_reason(site: &Site<'_>, storey: &MapStoreyRecord) -> String {
    let floor_z = storey.floor_z_tenths;
    let bodies = || site.elements.iter().filter(|e| e.n_parts > 0);
    let n_above = bodies().filter(|e| e.min_tenths[2] > floor_z).count();
    let n_below = bodies().filter(|e| e.max_tenths[2] < floor_z).count();
    format!(
        "no floor, and no element reaches into the robot's height above {:.2} m ({n_above} of the bodies lie higher, {n_below} lower)",
        metres(floor_z)
    )
}

/// The elements at the bounds, as the end of a sentence.
fn outermost_text(outermost: &[String]) -> String {
    if outermost.is_empty() {
        return ", and no element reaches its bounds: look at its spaces".to_owned();
    }
    format!("; its outermost elements are {}", outermost.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_storey_without_a_grid_names_what_is_outermost_or_where_to_look() {
        let text = |outermost: &[&str]| {
            let outermost = outermost.iter().map(|t| (*t).to_owned()).collect();
            let source = GridSpecError::Resolution { resolution_m: 2.0 };
            RasterizeError::Spec { storey: "Ground".to_owned(), outermost, source }.to_string()
        };
        assert!(text(&["IfcWall a", "IfcWall b"]).ends_with("its outermost elements are IfcWall a, IfcWall b"));
        assert!(text(&[]).ends_with("look at its spaces"));
    }
}
