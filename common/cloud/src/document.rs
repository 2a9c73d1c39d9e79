//! `cloud/structure.json`: what the numbers of the points mean.

use crate::options::CloudOptions;
use crate::point::Point;
use crate::selection::LeftOut;
use export::{ExportInput, text_or_null};
use grid::Class;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// What the points of a cloud are of. Lengths in metres in `map`.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Structure {
    /// Version of this layout: 1.
    version: u32,
    /// `map`.
    frame: &'static str,
    /// Counts changes of the map frame.
    frame_epoch: u32,
    /// Plan time; null if all elements stand.
    plan_time: Option<String>,
    /// Distance between points along the two axes across which a face is seen best.
    spacing_m: f64,
    /// Number of points.
    points: usize,
    /// Classes by name, with the number that points have as `label` or `class`.
    classes: BTreeMap<&'static str, ClassOfPoints>,
    /// Elements in the order of the number that points have as `element`.
    elements: Vec<ElementOfPoints>,
    /// Elements of these classes without points, by GlobalId.
    left_out: BTreeMap<String, LeftOut>,
}

/// A class of elements.
#[derive(Debug, Serialize, JsonSchema)]
struct ClassOfPoints {
    /// Its number.
    id: u8,
    /// Number of its points.
    points: usize,
}

/// An element that has points, or would have if they were seen.
#[derive(Debug, Serialize, JsonSchema)]
struct ElementOfPoints {
    /// GlobalId.
    global_id: String,
    /// Name.
    name: Option<String>,
    /// Number of its points; 0 for one that others hide, or that no line of the lattice meets.
    points: usize,
}

impl Structure {
    /// Of points of elements.
    pub(crate) fn of(
        input: &ExportInput<'_>,
        options: &CloudOptions,
        elements: &[u32],
        points: &[Point],
        left_out: Vec<(u32, LeftOut)>,
    ) -> Self {
        let site = input.site;
        let global_id = |element: u32| site.text(site.elements[element as usize].global_id).to_owned();
        let (mut by_element, mut by_class) = (vec![0; elements.len()], [0; Class::ALL.len()]);
        for point in points {
            by_element[point.element as usize] += 1;
            by_class[usize::from(point.class)] += 1;
        }
        let has_points = |class: &&Class| by_class[usize::from(class.id())] > 0;
        let class =
            |class: &Class| (class.name(), ClassOfPoints { id: class.id(), points: by_class[usize::from(class.id())] });
        let element = |(&element, points): (&u32, usize)| ElementOfPoints {
            global_id: global_id(element),
            name: text_or_null(site.text(site.elements[element as usize].name)),
            points,
        };
        Self {
            version: 1,
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            plan_time: input.schedule_state.head.plan_time().map(|time| time.to_string()),
            spacing_m: options.spacing_m(),
            points: points.len(),
            classes: Class::ALL
                .iter()
                .filter(|c| options.selection.has_class(**c) || has_points(c))
                .map(class)
                .collect(),
            elements: elements.iter().zip(by_element).map(element).collect(),
            left_out: left_out.into_iter().map(|(element, why)| (global_id(element), why)).collect(),
        }
    }
}
