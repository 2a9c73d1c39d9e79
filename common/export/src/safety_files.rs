//! `speed.{pgm,yaml}`, `speed_filter.yaml`, `costs.{pgm,yaml}` and `safety.json`: limits of speed and costs near elements, and
//! which element each cell has them from.

use crate::input::{ExportFile, ExportInput};
use crate::json;
use crate::probability_layer::pixel_of_percent;
use crate::text::{rounded, text_or_null};
use grid::{MapMode, MapYaml, encode_pgm};
use messages::{Grid, SafetyRuleRecord, SafetyRules, SafetySubject, Site};
use safety::{NO_SOURCE, SafetyInput, SafetyLayer, speed_step_m_s};
use schemars::JsonSchema;
use serde::Serialize;

/// Pixel of an unknown cell in the mode `raw`.
const RAW_UNKNOWN: u8 = 255;

/// `safety.json`: why the speed is limited and driving costs near elements of a map storey.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SafetyDocument {
    /// Of this document's form.
    version: u32,
    /// Metres per second of one step of `speed.pgm`: the multiplier of Nav2's speed filter of type 2 (absolute), whose base is 0.
    speed_step_m_s: f64,
    /// The rules of the robot, in the order of its profile; for a robot that drives on stairs one near `stair` after them, which says
    /// that these have the cost of the profile.
    rules: Vec<SafetyRule>,
    /// Elements that rules are about on this storey.
    sources: Vec<SafetySourceEntry>,
    /// Cells with a limit of speed, as stretches of a row: row from the bottom, first column, first column behind it, and the
    /// source.
    speed_cells: Vec<[u32; 4]>,
    /// Cells with a cost, in the same form.
    cost_cells: Vec<[u32; 4]>,
}

/// A rule.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
struct SafetyRule {
    /// `glass`, `stair_edge`, `door_swing`, `work`, `material`, `class` or `stair`.
    near: &'static str,
    /// Words of the material's name; null for other rules.
    material: Option<String>,
    /// Name of the class; null for other rules.
    class: Option<&'static str>,
    /// Distance that the robot's centre keeps; 0 where the rule is about the elements' own cells.
    distance_m: f64,
    /// Limit of speed within it; null if there is none.
    speed_m_s: Option<f64>,
}

/// An element that a rule is about.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
struct SafetySourceEntry {
    /// Place of its rule among the rules, from 0.
    rule: u32,
    /// GlobalId of the element.
    global_id: String,
    /// Its name; null if it has none.
    name: Option<String>,
}

/// The files of a storey; none for a robot without rules that does not drive on stairs.
pub(crate) fn files(folder: &str, input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<ExportFile> {
    let of = SafetyInput { site: input.site, schedule_state: input.schedule_state, index: input.index };
    let Some(layer) = SafetyLayer::of(of, grid) else { return Vec::new() };
    let mut files = Vec::new();
    if layer.limits_speed() {
        let pixels = layer.speed_mask().into_iter().map(|steps| pixel_of_percent(steps.unsigned_abs()));
        files.extend(map(folder, "speed", &layer, MapMode::Scale, pixels.collect()));
        files.push(ExportFile::new(format!("{folder}/speed_filter.yaml"), filter_info(&layer)));
    }
    if layer.has_costs() {
        let pixel = |cost: i8| u8::try_from(cost).unwrap_or(RAW_UNKNOWN);
        files.extend(map(folder, "costs", &layer, MapMode::Raw, layer.cost_mask().into_iter().map(pixel).collect()));
    }
    let document = SafetyDocument::of(input.site, &layer);
    files.push(ExportFile::new(format!("{folder}/safety.json"), json::text(&document)));
    files
}

fn map(folder: &str, name: &str, layer: &SafetyLayer, mode: MapMode, pixels: Vec<u8>) -> [ExportFile; 2] {
    let image = format!("{name}.pgm");
    let yaml = MapYaml { image: &image, spec: &layer.spec, mode }.to_string();
    let pgm = encode_pgm(layer.spec.width as usize, &pixels);
    [ExportFile::new(format!("{folder}/{image}"), pgm), ExportFile::new(format!("{folder}/{name}.yaml"), yaml)]
}

/// Parameters of Nav2's costmap_filter_info_server for the mask.
fn filter_info(layer: &SafetyLayer) -> String {
    let multiplier = speed_step_m_s(layer.rules.records());
    format!(
        "speed_costmap_filter_info_server:\n  ros__parameters:\n    type: 2\n    filter_info_topic: \
         speed_costmap_filter_info\n    mask_topic: speed_filter_mask\n    base: 0.0\n    multiplier: {multiplier:?}\n"
    )
}

impl SafetyDocument {
    fn of(site: &Site<'_>, layer: &SafetyLayer) -> Self {
        let source = |source: &safety::SafetySource| {
            let element = &site.elements[source.element as usize];
            SafetySourceEntry {
                rule: source.rule,
                global_id: site.text(element.global_id).to_owned(),
                name: text_or_null(site.text(element.name)),
            }
        };
        let rules = &layer.rules;
        Self {
            version: 1,
            speed_step_m_s: speed_step_m_s(rules.records()),
            rules: rules.records().iter().map(|rule| SafetyRule::of(rules, rule)).collect(),
            sources: layer.sources.iter().map(source).collect(),
            speed_cells: stretches(&layer.speed_source, layer.spec.width as usize),
            cost_cells: stretches(&layer.cost_source, layer.spec.width as usize),
        }
    }
}

impl SafetyRule {
    fn of(rules: &SafetyRules, rule: &SafetyRuleRecord) -> Self {
        let (material, class) = match rules.subject(rule) {
            SafetySubject::Material(words) => (Some(words.to_owned()), None),
            SafetySubject::Class(class) => (None, Some(class.name())),
            _ => (None, None),
        };
        Self {
            near: rule.kind.get().name(),
            material,
            class,
            distance_m: rounded(rule.distance_m),
            speed_m_s: (rule.speed_m_s > 0.0).then(|| rounded(rule.speed_m_s)),
        }
    }
}

/// Stretches of cells of one source in a row.
fn stretches(sources: &[u32], width: usize) -> Vec<[u32; 4]> {
    let mut found = Vec::new();
    for (row, cells) in (0u32..).zip(sources.chunks(width.max(1))) {
        let mut column = 0;
        for same in cells.chunk_by(|a, b| a == b) {
            let end = column + same.len() as u32;
            if same[0] != NO_SOURCE {
                found.push([row, column, end, same[0]]);
            }
            column = end;
        }
    }
    found
}
