//! Closures of spaces, with reasons.

use crate::construction_phases::ConstructionPhases;
use crate::diagnostics::{Entity, ScheduleDiagnostics};
use crate::property_dates::ScheduleProperties;
use crate::rules::{Rules, RulesMode};
use crate::task_effects::TaskEffects;
use diagnostics::nearest_names_hint;
use messages::{DiagnosticCode, Severity, Site, SpaceRecord};
use wildmatch::WildMatch;

/// A space must not be entered from `start_s` until before `finish_s`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Closure {
    pub(crate) start_s: i64,
    pub(crate) finish_s: i64,
    pub(crate) why: ClosureReason,
}

/// The reason of a closure, in the order in which reasons are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ClosureReason {
    /// A task occupies it.
    Task(u32),
    /// It is not released yet.
    BeforeRoomDate,
    /// It has no date of release (mode `paper` only).
    NoRoomDate,
    /// A rule closes it: index of the rule.
    Closed(u32),
}

/// Closures of all spaces, each sorted by start.
pub(crate) fn closures(
    site: &Site<'_>,
    rules: &Rules,
    task_effects: &TaskEffects,
    properties: &ScheduleProperties,
    diagnostics: &mut ScheduleDiagnostics<'_>,
) -> Vec<Vec<Closure>> {
    let construction_phases = ConstructionPhases::of(rules);
    let patterns: Vec<WildMatch> = rules.closed_spaces.iter().map(|c| WildMatch::new(&c.pattern)).collect();
    let mut used = vec![false; patterns.len()];
    let all = site.spaces.iter().enumerate().map(|(k, space)| {
        let mut closures: Vec<Closure> = task_effects.spaces[k]
            .iter()
            .map(|o| Closure { start_s: o.start_s, finish_s: o.finish_s, why: ClosureReason::Task(o.task) })
            .collect();
        let room_date = properties.spaces[k].actual.or(properties.spaces[k].planned);
        let opens_s = match rules.mode {
            RulesMode::Standard => room_date.map(|d| d.finish_s()).or_else(|| {
                properties.spaces[k].construction_phase.and_then(|name| construction_phases.finish_s(site.text(name)))
            }),
            RulesMode::Paper => room_date.map(|d| d.end_of_day_s()),
        };
        if let Some(finish_s) = opens_s {
            closures.push(Closure { start_s: i64::MIN, finish_s, why: ClosureReason::BeforeRoomDate });
        } else if rules.mode == RulesMode::Paper {
            closures.push(Closure { start_s: i64::MIN, finish_s: i64::MAX, why: ClosureReason::NoRoomDate });
        }
        for (index, (closed, pattern)) in (0u32..).zip(rules.closed_spaces.iter().zip(&patterns)) {
            if site.text(space.global_id) == closed.pattern || names(site, space).iter().any(|n| pattern.matches(n)) {
                used[index as usize] = true;
                let (start_s, finish_s) = (closed.from_s, closed.until_s);
                closures.push(Closure { start_s, finish_s, why: ClosureReason::Closed(index) });
            }
        }
        closures.sort_unstable();
        closures
    });
    let all = all.collect();
    for (closed, _) in rules.closed_spaces.iter().zip(used).filter(|(_, used)| !used) {
        let called = site.spaces.iter().flat_map(|s| [s.name, s.long_name, s.global_id]).map(|t| site.text(t));
        let nearest = nearest_names_hint(&closed.pattern, called);
        let message = format!("closed_spaces: no space is called {:?}{nearest}", closed.pattern);
        diagnostics.add(Severity::Warning, DiagnosticCode::ClosedSpaceUnknown, None, message);
    }
    if rules.mode == RulesMode::Paper {
        report_undated(site, properties, diagnostics);
    }
    all
}

/// Names by which a rule may refer to a space: name, long name, both.
fn names(site: &Site<'_>, space: &SpaceRecord) -> [String; 3] {
    let (name, long_name) = (site.text(space.name), site.text(space.long_name));
    [name.to_owned(), long_name.to_owned(), format!("{name} {long_name}")]
}

/// The prototype stops at a room without a date.
fn report_undated(site: &Site<'_>, properties: &ScheduleProperties, diagnostics: &mut ScheduleDiagnostics<'_>) {
    for (space, properties) in site.spaces.iter().zip(&properties.spaces) {
        if properties.actual.or(properties.planned).is_none() {
            let entity = Entity::of(space.global_id, space.name, 0, space.source);
            let message = "the room has no date of release; it stays blocked".to_owned();
            diagnostics.add(Severity::Warning, DiagnosticCode::RoomUndated, Some(entity), message);
        }
    }
}

/// Instants at which a space becomes blocked or open, and whether it is blocked from then on; blocked before all if the
/// first is at `i64::MIN`.
pub(crate) fn steps(closures: &[Closure]) -> Vec<(i64, bool)> {
    let mut steps: Vec<(i64, bool)> = Vec::new();
    let mut until_s = None;
    for closure in closures.iter().filter(|c| c.start_s < c.finish_s) {
        match until_s {
            Some(end_s) if closure.start_s <= end_s => until_s = Some(closure.finish_s.max(end_s)),
            _ => {
                steps.extend(until_s.map(|end_s| (end_s, false)));
                steps.push((closure.start_s, true));
                until_s = Some(closure.finish_s);
            }
        }
    }
    steps.extend(until_s.filter(|end_s| *end_s < i64::MAX).map(|end_s| (end_s, false)));
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closures_that_meet_are_one() {
        let closure = |start_s, finish_s| Closure { start_s, finish_s, why: ClosureReason::BeforeRoomDate };
        let found = steps(&[closure(i64::MIN, 5), closure(5, 8), closure(6, 7), closure(9, 9), closure(10, i64::MAX)]);
        assert_eq!(found, [(i64::MIN, true), (8, false), (10, true)]);
        assert!(steps(&[]).is_empty());
    }
}
