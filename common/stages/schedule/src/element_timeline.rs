//! Element timelines: merges reported progress, task effects, property dates and construction phases by priority.

use crate::construction_phases::ConstructionPhases;
use crate::diagnostics::{Entity, ScheduleDiagnostics};
use crate::property_dates::{ObjectProperties, ScheduleProperties};
use crate::rules::{Rules, Undated};
use crate::task_effects::{Effect, TaskEffects, wholes};
use messages::{DateSource, DiagnosticCode, ElementState, NONE, Severity, Site};
use std::collections::BTreeMap;

/// Effects on an element in time, sorted; none for one that exists throughout.
#[derive(Debug, Clone, Default)]
pub(crate) struct ElementTimeline {
    pub(crate) effects: Vec<Effect>,
    pub(crate) source: Option<DateSource>,
}

/// A run of effects of one kind: from the first start to the last finish.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Episode {
    pub(crate) start_s: i64,
    pub(crate) finish_s: i64,
    pub(crate) removes: bool,
}

/// The timelines of all elements. Reported progress ranks before tasks, tasks before property dates, these before
/// construction phases, these before status.
pub(crate) fn element_timelines(
    site: &Site<'_>,
    rules: &Rules,
    task_effects: &TaskEffects,
    properties: &ScheduleProperties,
    reported: &BTreeMap<usize, Effect>,
    diagnostics: &mut ScheduleDiagnostics<'_>,
) -> Vec<ElementTimeline> {
    let construction_phases = ConstructionPhases::of(rules);
    let element_timelines = (0..site.elements.len()).map(|k| {
        if let Some(effect) = reported.get(&k) {
            return ElementTimeline { effects: vec![*effect], source: Some(DateSource::Reported) };
        }
        if let Some(source) = task_effects.elements[k].iter().map(|e| e.source).max() {
            return ElementTimeline { effects: task_effects.elements[k].clone(), source: Some(source) };
        }
        let of_kind = |source, date: fn(&ObjectProperties) -> Option<frames::written_date::WrittenDate>| {
            let found = wholes(site, k).find_map(|w| date(&properties.elements[w]))?;
            let finish_s = found.finish_s();
            let effect = Effect { start_s: finish_s, finish_s, removes: false, task: NONE, source };
            Some(ElementTimeline { effects: vec![effect], source: Some(source) })
        };
        of_kind(DateSource::PropertyActual, |s| s.actual)
            .or_else(|| of_kind(DateSource::PropertyPlanned, |s| s.planned))
            .or_else(|| {
                wholes(site, k)
                    .find_map(|w| construction_phase_timeline(&construction_phases, site, &properties.elements[w]))
            })
            .or_else(|| {
                let status = wholes(site, k).find_map(|w| properties.elements[w].status)?;
                let has_meaning = !matches!(site.text(status), "NOTKNOWN" | "UNSET" | "OTHER");
                has_meaning.then(|| ElementTimeline { effects: Vec::new(), source: Some(DateSource::Status) })
            })
            .unwrap_or_default()
    });
    let element_timelines: Vec<ElementTimeline> = element_timelines.collect();
    report(site, &construction_phases, properties, &element_timelines, diagnostics);
    element_timelines
}

/// The timeline from the construction phases of an element; `None` if none of them is in the rules.
fn construction_phase_timeline(
    construction_phases: &ConstructionPhases<'_>,
    site: &Site<'_>,
    properties: &ObjectProperties,
) -> Option<ElementTimeline> {
    let span = |name: Option<messages::Text>| name.and_then(|t| construction_phases.spans.get(site.text(t)).copied());
    let (created, demolished) = (span(properties.created), span(properties.demolished));
    if created.is_none() && demolished.is_none() {
        return None;
    }
    let effect = |span: Option<Option<[i64; 2]>>, removes: bool| {
        let [start_s, finish_s] = span??;
        Some(Effect { start_s, finish_s, removes, task: NONE, source: DateSource::ConstructionPhase })
    };
    let mut effects: Vec<Effect> = [effect(created, false), effect(demolished, true)].into_iter().flatten().collect();
    effects.sort_unstable();
    Some(ElementTimeline { effects, source: Some(DateSource::ConstructionPhase) })
}

impl ElementTimeline {
    /// The episodes, by start.
    pub(crate) fn episodes(&self) -> Vec<Episode> {
        let mut episodes: Vec<Episode> = Vec::new();
        for effect in &self.effects {
            match episodes.last_mut() {
                Some(last) if last.removes == effect.removes => last.finish_s = last.finish_s.max(effect.finish_s),
                _ => {
                    let Effect { start_s, finish_s, removes, .. } = *effect;
                    episodes.push(Episode { start_s, finish_s, removes });
                }
            }
        }
        episodes
    }

    /// The state before everything, and every change of it.
    pub(crate) fn steps(&self, undated: Undated) -> (ElementState, Vec<(i64, ElementState)>) {
        let episodes = self.episodes();
        let first = match episodes.first() {
            Some(first) if first.removes => ElementState::Built,
            Some(_) => ElementState::NotStarted,
            None if self.source.is_none() && undated == Undated::Absent => ElementState::NotStarted,
            None => ElementState::Built,
        };
        let mut steps = Vec::new();
        for (k, episode) in episodes.iter().enumerate() {
            let (during, after) = if episode.removes {
                (ElementState::BeingRemoved, ElementState::Removed)
            } else {
                (ElementState::InProgress, ElementState::Built)
            };
            let next_s = episodes.get(k + 1).map_or(i64::MAX, |next| next.start_s);
            if episode.start_s < episode.finish_s {
                steps.push((episode.start_s, during));
            }
            if episode.finish_s < next_s {
                steps.push((episode.finish_s, after));
            }
        }
        (first, steps)
    }
}

/// Reports statuses without a date, ambiguous dates, and construction phases that the rules do not know.
fn report(
    site: &Site<'_>,
    construction_phases: &ConstructionPhases<'_>,
    properties: &ScheduleProperties,
    element_timelines: &[ElementTimeline],
    diagnostics: &mut ScheduleDiagnostics<'_>,
) {
    let mut unknown: BTreeMap<&str, usize> = BTreeMap::new();
    for (k, element) in site.elements.iter().enumerate() {
        let properties = &properties.elements[k];
        let entity = Entity::of(element.global_id, element.name, element.step_id, element.source);
        for name in [properties.created, properties.demolished].into_iter().flatten().map(|t| site.text(t)) {
            if !construction_phases.spans.contains_key(name) {
                *unknown.entry(name).or_default() += 1;
            }
        }
        let status = properties.status.map(|t| site.text(t)).filter(|s| ["DEMOLISH", "TEMPORARY"].contains(s));
        if let Some(status) = status.filter(|_| element_timelines[k].source == Some(DateSource::Status)) {
            let message = format!("its status is {status}, but it has no date; it is taken as existing");
            diagnostics.add(Severity::Warning, DiagnosticCode::StatusWithoutDate, Some(entity), message);
        }
        if properties.is_ambiguous {
            let message = "its date fits two orders; other dates of the file decided".to_owned();
            diagnostics.add(Severity::Info, DiagnosticCode::DateAmbiguous, Some(entity), message);
        }
    }
    for name in properties.spaces.iter().filter_map(|s| s.construction_phase).map(|t| site.text(t)) {
        if !construction_phases.spans.contains_key(name) {
            *unknown.entry(name).or_default() += 1;
        }
    }
    for (name, n) in unknown {
        let message = format!(
            "{n} objects name the construction phase {name:?}, which has no dates in the rules ([[phases]]); it is ignored"
        );
        diagnostics.add(Severity::Info, DiagnosticCode::ConstructionPhaseUnknown, None, message);
    }
}
