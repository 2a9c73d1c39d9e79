//! Differences between what a robot saw and the plan: elements, and obstacles that are none.

use crate::circumstances::Circumstances;
use crate::named::{ElementRef, StoreyRef, optional_date_text};
use export::rounded;
use messages::{DeviationVerdict, Deviations, Observation, Site};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// What a robot saw that differs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DeviationsAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// What the robot of these maps saw; null if nothing was compared yet: see `why_none`.
    pub seen: Option<SeenDeviations>,
    /// Why nothing was compared; null if it was.
    pub why_none: Option<String>,
}

/// What a robot saw of a storey.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SeenDeviations {
    /// The storey.
    pub storey: Option<StoreyRef>,
    /// Plan time by which elements are judged; null if all are planned to stand.
    pub plan_time: Option<String>,
    /// Number of elements by what was seen of them: `observed`, `absent`, `displaced`, `unseen`.
    pub observations: BTreeMap<&'static str, usize>,
    /// Elements that are not as planned.
    pub elements: Vec<DeviatingElement>,
    /// What stands on the storey and is no element of the model.
    pub obstacles: Vec<SeenObstacle>,
}

/// An element that is not as planned.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DeviatingElement {
    /// The element.
    #[serde(flatten)]
    pub element: ElementRef,
    /// `late`, `early` or `displaced`.
    pub verdict: &'static str,
    /// `observed`, `absent`, `displaced` or `unseen`.
    pub observation: &'static str,
    /// How far it is displaced; null if it is not.
    pub offset_m: Option<f64>,
}

/// What stands on a storey and is no element of the model.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SeenObstacle {
    /// Its middle in `map`.
    pub at_m: [f64; 2],
    /// Area of its cells.
    pub area_m2: f64,
    /// Length of its longer side.
    pub length_m: f64,
}

/// What a robot saw; `None` for deviations of another site.
pub fn seen_deviations(site: &Site<'_>, found: &Deviations<'_>) -> Option<SeenDeviations> {
    found.check_site(site).ok()?;
    let mut observations: BTreeMap<&'static str, usize> = Observation::ALL.map(|o| (o.name(), 0)).into();
    for record in found.elements {
        *observations.entry(record.observation.get().name()).or_default() += 1;
    }
    let differs = found
        .elements
        .iter()
        .filter(|record| !matches!(record.verdict.get(), DeviationVerdict::OnPlan | DeviationVerdict::Unknown));
    let element = |record: &messages::ElementDeviationRecord| DeviatingElement {
        element: ElementRef::of(site, record.element as usize),
        verdict: record.verdict.get().name(),
        observation: record.observation.get().name(),
        offset_m: (record.observation == Observation::Displaced).then(|| rounded(record.offset_m.abs())),
    };
    let obstacle = |obstacle: &messages::ObstacleRecord| SeenObstacle {
        at_m: obstacle.centroid_m.map(rounded),
        area_m2: rounded(obstacle.area_m2),
        length_m: rounded(obstacle.length_m),
    };
    Some(SeenDeviations {
        storey: StoreyRef::of(site, found.head.map_storey),
        plan_time: optional_date_text(found.head.plan_time_s),
        observations,
        elements: differs.map(element).collect(),
        obstacles: found.obstacles.iter().map(obstacle).collect(),
    })
}
