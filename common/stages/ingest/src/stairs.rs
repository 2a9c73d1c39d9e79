//! Stair measures: the file's where they agree with the body, else measured on the body.

use crate::classify::is_a;
use crate::diagnostics::add_diagnostic;
use crate::merge::Merged;
use frames::{TENTHS_PER_M, metres};
use geometry::{MeshView, Tread, treads};
use ifc::{Diagnostic, DiagnosticCode, Element, PropertyValue, Severity};
use messages::{NONE, SiteBuilder, StairRecord, stair_flags};

/// Property sets with the measures of stairs and flights.
pub const SETS: [&str; 2] = ["Pset_StairCommon", "Pset_StairFlightCommon"];

/// Minimum and maximum height of a riser, in metres.
pub const RISER_HEIGHTS_M: [f64; 2] = [0.05, 0.40];

/// Shortest and longest tread that is still part of a flight, in metres.
pub const TREAD_LENGTHS_M: [f64; 2] = [0.10, 1.50];

/// Share by which a figure of the file may differ from the body: noses and rounding.
const TOLERANCE: f64 = 0.15;

/// Share of the steps of a flight that are of one height.
const REGULAR: f64 = 0.7;

/// Risers by which a count may differ: the floors at both ends are counted or not.
const COUNT_TOLERANCE: u32 = 2;

/// Writes the stairs of the site: every element with figures of the file, and every stair or flight with a body whose
/// steps can be measured.
pub(crate) fn add_stairs(builder: &mut SiteBuilder, merged: &Merged) {
    for (index, element) in merged.model.elements.iter().enumerate() {
        let is_stair = is_a(element, "IfcStair") || is_a(element, "IfcStairFlight");
        if !is_stair && element.stair.is_none() {
            continue;
        }
        let unit_m = merged.schemas[merged.element_source[index] as usize].1;
        let figures = FileFigures::of(element, unit_m);
        // The flights of a stair without a body of its own have their own measures.
        if figures == FileFigures::default() && builder.elements[index].n_parts == 0 {
            continue;
        }
        let body = body_of(builder, index);
        let Some((record, objections)) = compare(figures, body) else { continue };
        builder.elements[index].stair = builder.stairs.len() as u32;
        builder.stairs.push(StairRecord { element: index as u32, ..record });
        let source = builder.elements[index].source;
        for message in objections {
            let (entity, code) = (Some(element.id.clone()), DiagnosticCode::StairMeasureImplausible);
            add_diagnostic(
                builder,
                source,
                &Diagnostic { severity: Severity::Warning, code, entity, source: None, message },
            );
        }
    }
}

/// Measures given by the file, in metres; `None` where absent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct FileFigures {
    n_risers: Option<u32>,
    n_treads: Option<u32>,
    riser_height_m: Option<f64>,
    tread_length_m: Option<f64>,
}

impl FileFigures {
    fn of(element: &Element, unit_m: f64) -> Self {
        let own = element.stair.as_ref();
        let number = |names: [&str; 2]| {
            element.properties.iter().find_map(|p| match p.value {
                PropertyValue::Number(n) if SETS.contains(&p.set.as_str()) && names.contains(&p.name.as_str()) => {
                    Some(n)
                }
                _ => None,
            })
        };
        let count = |names| number(names).filter(|n| (0.0..=10_000.0).contains(n)).map(|n| n as u32);
        let length = |name| number([name, name]).map(|n| n * unit_m);
        Self {
            n_risers: own.and_then(|s| s.n_risers).or_else(|| count(["NumberOfRiser", "NumberOfRisers"])),
            n_treads: own.and_then(|s| s.n_treads).or_else(|| count(["NumberOfTreads", "NumberOfTread"])),
            riser_height_m: own.and_then(|s| s.riser_height_m).or_else(|| length("RiserHeight")),
            tread_length_m: own.and_then(|s| s.tread_length_m).or_else(|| length("TreadLength")),
        }
    }
}

/// Measures of the body of a stair.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StairBody {
    /// From its lowest point to its highest, in metres.
    height_m: f64,
    /// Its steps, where it has level ones of one height.
    steps: Option<StairSteps>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct StairSteps {
    n_risers: u32,
    riser_height_m: f64,
    tread_length_m: Option<f64>,
}

/// The body of an element, or of its parts if it has none of its own.
fn body_of(builder: &SiteBuilder, index: usize) -> Option<StairBody> {
    let own = &builder.elements[index];
    let parts = builder.elements.iter().filter(|e| e.whole == index as u32 && e.class == own.class);
    let bodies: Vec<_> = if own.n_parts > 0 { vec![own] } else { parts.filter(|e| e.n_parts > 0).collect() };
    let meshes: Vec<MeshView<'_>> = bodies.iter().flat_map(|e| builder.meshes(e.first_part, e.n_parts)).collect();
    let (low, high) = (bodies.iter().map(|e| e.min_tenths[2]).min()?, bodies.iter().map(|e| e.max_tenths[2]).max()?);
    Some(StairBody { height_m: metres(high - low), steps: steps(low, &treads(meshes)) })
}

/// The steps of level faces above the foot of a body; `None` if most are not of one height that can be walked.
fn steps(foot_z: i32, treads: &[Tread]) -> Option<StairSteps> {
    let mut rises: Vec<f64> = Vec::new();
    let mut lengths: Vec<f64> = Vec::new();
    let mut below: Option<&[Tread]> = None;
    for level in treads.chunk_by(|a, b| a.z == b.z) {
        let z = level[0].z;
        if let Some(below) = below {
            rises.push(metres(z - below[0].z));
            let far = |a: &Tread, b: &Tread| libm::hypot(b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]);
            let nearest = level.iter().flat_map(|b| below.iter().map(move |a| far(a, b))).reduce(f64::min);
            lengths.extend(nearest.map(|tenths| tenths / f64::from(TENTHS_PER_M)));
        }
        below = Some(level);
    }
    let riser_height_m = median(&rises).filter(|h| within(*h, RISER_HEIGHTS_M))?;
    let is_regular = |rise: &&f64| (**rise - riser_height_m).abs() <= TOLERANCE * riser_height_m;
    let n_regular = rises.iter().filter(is_regular).count();
    if n_regular < 2 || (n_regular as f64) < REGULAR * rises.len() as f64 {
        return None;
    }
    // The foot may stand on the lowest face, or a riser below it.
    let first = metres(treads.first()?.z - foot_z) / riser_height_m;
    let n_risers =
        rises.iter().map(|rise| (rise / riser_height_m).round() as u32).sum::<u32>() + u32::from(first > 0.5);
    let regular_lengths: Vec<f64> =
        rises.iter().zip(&lengths).filter(|(rise, _)| is_regular(rise)).map(|(_, length)| *length).collect();
    let tread_length_m = median(&regular_lengths).filter(|l| within(*l, TREAD_LENGTHS_M));
    Some(StairSteps { n_risers, riser_height_m, tread_length_m })
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    (low..=high).contains(&value)
}

/// The measures that count, with a sentence for every figure of the file that does not; `None` if there are none.
fn compare(figures: FileFigures, body: Option<StairBody>) -> Option<(StairRecord, Vec<String>)> {
    let steps = body.and_then(|b| b.steps);
    if figures == FileFigures::default() && steps.is_none() {
        return None;
    }
    let mut objections = Vec::new();
    let mut flags = 0;
    let n_risers = match (figures.n_risers, steps) {
        (Some(n), Some(s)) if n.abs_diff(s.n_risers) > COUNT_TOLERANCE.max(s.n_risers / 4) => {
            objections.push(format!("the file tells {n} risers, its body has {}, which count", s.n_risers));
            flags |= stair_flags::RISERS_MEASURED;
            Some(s.n_risers)
        }
        (Some(n), _) => Some(n),
        (None, Some(s)) => {
            flags |= stair_flags::RISERS_MEASURED;
            Some(s.n_risers)
        }
        (None, None) => None,
    };
    // Where no step can be measured, the height of the body over the risers is one.
    let even_m = body.zip(n_risers).map(|(b, n)| b.height_m / f64::from(n.max(1)));
    let riser_m = steps.map(|s| s.riser_height_m).or(even_m.filter(|h| within(*h, RISER_HEIGHTS_M)));
    // A body without steps may be thicker than they are high.
    let tolerance = if steps.is_some() { TOLERANCE } else { 0.5 };
    let riser = ComparedLength { told_m: figures.riser_height_m, body_m: riser_m, range_m: RISER_HEIGHTS_M, tolerance };
    let tread_m = steps.and_then(|s| s.tread_length_m);
    let tread = ComparedLength { told_m: figures.tread_length_m, body_m: tread_m, range_m: TREAD_LENGTHS_M, tolerance };
    let (riser_height_m, is_measured) = riser.compared("RiserHeight", steps.is_some(), &mut objections);
    flags |= if is_measured { stair_flags::RISER_HEIGHT_MEASURED } else { 0 };
    let (tread_length_m, is_measured) = tread.compared("TreadLength", steps.is_some(), &mut objections);
    flags |= if is_measured { stair_flags::TREAD_LENGTH_MEASURED } else { 0 };
    let n_treads = figures.n_treads.unwrap_or(NONE);
    let record =
        StairRecord { element: 0, n_risers: n_risers.unwrap_or(NONE), n_treads, flags, riser_height_m, tread_length_m };
    Some((record, objections))
}

/// A length of a stair, by the file and by its body.
struct ComparedLength {
    told_m: Option<f64>,
    body_m: Option<f64>,
    range_m: [f64; 2],
    tolerance: f64,
}

impl ComparedLength {
    /// The length that counts, 0 if there is none, and whether it is the body's. `fills` says whether the body's counts where
    /// the file tells nothing.
    fn compared(&self, name: &str, fills: bool, objections: &mut Vec<String>) -> (f64, bool) {
        let Some(told_m) = self.told_m else {
            let body_m = self.body_m.filter(|_| fills);
            return (body_m.unwrap_or(0.0), body_m.is_some());
        };
        // Tenths of a millimetre tell a wrong unit from a wrong figure.
        let shown_m = (told_m * f64::from(TENTHS_PER_M)).round() / f64::from(TENTHS_PER_M);
        let agrees = self.body_m.is_none_or(|body_m| (told_m - body_m).abs() <= self.tolerance * body_m);
        match self.body_m {
            _ if within(told_m, self.range_m) && agrees => (told_m, false),
            Some(body_m) => {
                objections.push(format!("{name} is {shown_m} m, its body has {body_m:.3} m, which counts"));
                (body_m, true)
            }
            None => {
                objections.push(format!(
                    "{name} is {shown_m} m, which cannot be, and its body shows no steps: it is left out"
                ));
                (0.0, false)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{FillRule, union};

    /// Level faces of a straight flight: `n` steps of this rise and going in metres, the first a rise above the floor.
    fn flight(n: i32, rise_m: f64, going_m: f64) -> Vec<Tread> {
        let tenths = |m: f64| (m * 10_000.0).round() as i32;
        let tread = |k: i32| {
            let [x0, x1] = [k, k + 1].map(|k| tenths(going_m * f64::from(k)));
            let plan = union(&[vec![[x0, 0], [x1, 0], [x1, 10_000], [x0, 10_000]]], FillRule::NonZero);
            Tread { z: tenths(rise_m * f64::from(k + 1)), centre: plan.centroid().unwrap(), plan }
        };
        (0..n).map(tread).collect()
    }

    fn body(n: i32, rise_m: f64, going_m: f64) -> Option<StairBody> {
        Some(StairBody { height_m: f64::from(n) * rise_m, steps: steps(0, &flight(n, rise_m, going_m)) })
    }

    fn figures(n_risers: u32, riser_height_m: f64, tread_length_m: f64) -> FileFigures {
        FileFigures {
            n_risers: Some(n_risers),
            n_treads: None,
            riser_height_m: Some(riser_height_m),
            tread_length_m: Some(tread_length_m),
        }
    }

    #[test]
    fn steps_are_measured_on_level_faces() {
        let found = steps(0, &flight(16, 0.175, 0.28)).unwrap();
        assert_eq!(found.n_risers, 16);
        assert!((found.riser_height_m - 0.175).abs() < 1e-9 && (found.tread_length_m.unwrap() - 0.28).abs() < 1e-3);
        assert_eq!(steps(0, &flight(16, 0.9, 0.28)), None, "shelves are no steps");
        assert_eq!(steps(0, &flight(2, 0.175, 0.28)), None);
    }

    #[test]
    fn figures_that_cannot_be_are_replaced_by_those_of_the_body_and_reported() {
        for (riser_m, tread_m) in [(0.0006, 0.001), (-0.175, -0.28), (0.0, 0.0), (0.35, 0.56), (175.0, 280.0)] {
            let (record, objections) = compare(figures(16, riser_m, tread_m), body(16, 0.175, 0.28)).unwrap();
            assert!((record.riser_height_m - 0.175).abs() < 1e-3 && (record.tread_length_m - 0.28).abs() < 1e-3);
            assert_eq!(record.flags, stair_flags::RISER_HEIGHT_MEASURED | stair_flags::TREAD_LENGTH_MEASURED);
            assert_eq!(objections.len(), 2);
            assert!(objections[0].contains(&format!("RiserHeight is {riser_m} m")), "{objections:?}");
        }
    }

    #[test]
    fn lengths_are_told_to_tenths_of_a_millimetre() {
        // 25 inches are 0.635 m, and so much in US survey feet.
        let riser_m = 0.635_001_270_002_54;
        let (_, objections) = compare(figures(16, riser_m, 0.28), body(16, 0.175, 0.28)).unwrap();
        assert_eq!(objections, ["RiserHeight is 0.635 m, its body has 0.175 m, which counts"]);
        let (_, objections) = compare(figures(16, 0.28, 0.000_62 / 1.000_2), None).unwrap();
        let expected = "TreadLength is 0.0006 m, which cannot be, and its body shows no steps: it is left out";
        assert_eq!(objections, [expected]);
    }

    #[test]
    fn figures_that_agree_with_the_body_stay() {
        let (record, objections) = compare(figures(17, 0.176, 0.27), body(16, 0.175, 0.28)).unwrap();
        assert_eq!((record.n_risers, record.riser_height_m, record.tread_length_m), (17, 0.176, 0.27));
        assert_eq!((record.flags, objections), (0, Vec::new()));
    }

    #[test]
    fn a_count_far_from_the_body_is_replaced() {
        let (record, objections) = compare(figures(160, 0.175, 0.28), body(16, 0.175, 0.28)).unwrap();
        assert_eq!((record.n_risers, objections.len()), (16, 1));
    }

    #[test]
    fn without_level_faces_risers_share_the_height_of_the_body() {
        let plain = Some(StairBody { height_m: 2.8, steps: None });
        let (record, objections) = compare(figures(16, 0.0006, 0.28), plain).unwrap();
        assert_eq!((record.riser_height_m, record.tread_length_m, objections.len()), (2.8 / 16.0, 0.28, 1));
        let (record, objections) = compare(figures(16, 0.0006, -1.0), None).unwrap();
        assert_eq!((record.riser_height_m, record.tread_length_m, objections.len()), (0.0, 0.0, 2));
    }

    #[test]
    fn a_stair_without_figures_has_those_of_its_body() {
        let (record, objections) = compare(FileFigures::default(), body(16, 0.175, 0.28)).unwrap();
        assert_eq!((record.n_risers, objections.len()), (16, 0));
        assert_eq!(compare(FileFigures::default(), Some(StairBody { height_m: 3.0, steps: None })), None);
    }
}
