//! Width of a door: its attribute against opening and body, and the part of it that moves.

use frames::TENTHS_PER_M;
use geometry::{OrientedBox, Point};
use ifc::{Door, DoorPanel};

/// An OverallWidth is as measured up to this much, or this share of it: frames overlap walls.
const TOLERANCE_M: f64 = 0.15;
const TOLERANCE_SHARE: f64 = 0.15;

/// Narrower than this is no door that anyone passes: its OverallWidth is in another unit, or is no width.
const MIN_WIDTH_M: f64 = 0.2;

/// Share of a door that moves beside a fixed leaf of unknown width.
const ASSUMED_MOVING_SHARE: f64 = 0.5;

/// An OverallWidth that opening and body contradict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImplausibleWidth {
    pub(crate) told_m: f64,
    pub(crate) measured_m: f64,
}

/// Width of a passage, or of the body along it where that is narrower, in metres.
pub(crate) fn measured_width_m(passage: &OrientedBox, body: &[Point]) -> f64 {
    let own = OrientedBox::around(body.iter().copied(), passage.axis).map_or(f64::INFINITY, |b| b.half[0]);
    // A handle or a sheet that stands for the whole is no measure of it.
    let own = if 2.0 * own < MIN_WIDTH_M * f64::from(TENTHS_PER_M) { f64::INFINITY } else { own };
    2.0 * passage.half[0].min(own) / f64::from(TENTHS_PER_M)
}

/// The smaller of OverallWidth and measured width, in metres; 0 without either.
///
/// # Errors
/// An OverallWidth that is too narrow for a door, or wider than measured by more than a frame.
pub(crate) fn overall_width_m(told_m: Option<f64>, measured_m: Option<f64>) -> Result<f64, ImplausibleWidth> {
    match (told_m.filter(|w| *w > 0.0), measured_m.filter(|w| *w > 0.0)) {
        (Some(told_m), Some(measured_m)) => {
            let spare_m = TOLERANCE_M.max(TOLERANCE_SHARE * measured_m);
            let is_plausible = told_m <= measured_m + spare_m && (told_m >= MIN_WIDTH_M || measured_m < MIN_WIDTH_M);
            if is_plausible { Ok(told_m.min(measured_m)) } else { Err(ImplausibleWidth { told_m, measured_m }) }
        }
        (told_m, measured_m) => Ok(told_m.or(measured_m).unwrap_or(0.0)),
    }
}

/// The share of a door's width that its moving leaves have: all of it without a fixed leaf.
pub(crate) fn moving_share(door: &Door) -> f64 {
    let is_fixed = |panel: &&DoorPanel| panel.operation.contains("FIXED");
    let operation = door.operation_type.to_ascii_uppercase();
    if !operation.contains("FIXED") && !door.panels.iter().any(|p| is_fixed(&p)) {
        return 1.0;
    }
    let shares = |fixed: bool| {
        let mut panels = door.panels.iter().filter(|p| is_fixed(p) == fixed).peekable();
        panels.peek()?;
        panels.map(|p| p.share).sum::<Option<f64>>()
    };
    let moving = shares(false).or_else(|| shares(true).map(|fixed| 1.0 - fixed));
    moving.filter(|share| 0.0 < *share && *share < 1.0).unwrap_or(ASSUMED_MOVING_SHARE)
}

/// The part of a passage at which the moving leaf hangs; `along` is the direction of the door's own x axis in plan.
pub(crate) fn moving_part(passage: &OrientedBox, along: Option<[f64; 2]>, door: &Door, share: f64) -> OrientedBox {
    let operation = door.operation_type.to_ascii_uppercase();
    let side = match (operation.contains("LEFT"), operation.contains("RIGHT")) {
        (true, false) => -1.0,
        (false, true) => 1.0,
        _ => 0.0,
    };
    let Some(along) = along.filter(|_| share < 1.0) else { return *passage };
    let turn = if along[0] * passage.axis[0] + along[1] * passage.axis[1] < 0.0 { -1.0 } else { 1.0 };
    let offset = side * turn * passage.half[0] * (1.0 - share);
    OrientedBox {
        centre: passage.at(offset, 0.0),
        half: [passage.half[0] * share, passage.half[1]],
        axis: passage.axis,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_width_that_opening_and_body_contradict_is_told_and_not_used() {
        assert_eq!(overall_width_m(Some(1.0), Some(1.05)), Ok(1.0));
        assert_eq!(overall_width_m(Some(1.0), Some(0.9)), Ok(0.9), "the smaller counts");
        assert_eq!(overall_width_m(Some(1.0), None), Ok(1.0));
        assert_eq!(overall_width_m(None, Some(0.9)), Ok(0.9));
        for told_m in [2.1, 999.0, 0.001] {
            let expected = Err(ImplausibleWidth { told_m, measured_m: 0.7 });
            assert_eq!(overall_width_m(Some(told_m), Some(0.7)), expected);
        }
    }

    #[test]
    fn a_body_narrower_than_its_opening_is_what_is_measured() {
        let passage = OrientedBox { centre: [0.0; 2], axis: [1.0, 0.0], half: [10_000.0, 1_000.0] };
        let body = |half: i32| [[-half, -500], [half, 500]];
        assert_eq!(measured_width_m(&passage, &body(5_000)), 1.0);
        assert_eq!(measured_width_m(&passage, &body(12_000)), 2.0);
        assert_eq!(measured_width_m(&passage, &body(100)), 2.0, "a handle");
        assert_eq!(measured_width_m(&passage, &[]), 2.0);
    }

    #[test]
    fn a_fixed_leaf_takes_its_share_on_its_side() {
        let panel = |operation: &str, share| DoorPanel { operation: operation.into(), share, ..Default::default() };
        let door = |operation: &str, panels| Door { operation_type: operation.into(), panels, ..Default::default() };
        let share = |operation, panels| moving_share(&door(operation, panels));
        assert_eq!(share("SINGLE_SWING_LEFT", vec![panel("SWINGING", Some(0.8))]), 1.0);
        assert_eq!(share("SWING_FIXED_LEFT", vec![]), 0.5);
        let panels = vec![panel("SWINGING", Some(0.6)), panel("FIXEDPANEL", None)];
        assert_eq!(share("SWING_FIXED_LEFT", panels), 0.6);
        assert_eq!(share("", vec![panel("SWINGING", None), panel("FIXEDPANEL", Some(0.25))]), 0.75);
        let passage = OrientedBox { centre: [0.0; 2], axis: [1.0, 0.0], half: [10_000.0, 1_000.0] };
        let centre = |operation, along| moving_part(&passage, Some(along), &door(operation, vec![]), 0.5).centre;
        assert_eq!(centre("SWING_FIXED_LEFT", [1.0, 0.0]), [-5_000.0, 0.0]);
        assert_eq!(centre("SWING_FIXED_RIGHT", [1.0, 0.0]), [5_000.0, 0.0]);
        assert_eq!(centre("SWING_FIXED_LEFT", [-1.0, 0.0]), [5_000.0, 0.0]);
    }
}
