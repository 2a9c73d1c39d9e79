//! Changes by a new revision of the plan: rooms that open at other dates, elements that stand at others, maps that differ.

use super::revised_steps::{StandingState, StateHistory, differing_spans, united};
use crate::named::date_text;
use messages::{NONE, Site};
use schedule::Timeline;
use serde::Serialize;
use std::fmt::Write;

/// Heights around the floor of a map storey whose bodies its maps may show.
const BELOW_FLOOR_TENTHS: i32 = 5_000;
const ABOVE_FLOOR_TENTHS: i32 = 30_000;
/// Most lines of a list for people; all are in the JSON document.
const MAX_LINES: usize = 20;

/// What differs between two revisions of the plan.
#[derive(Debug, Serialize)]
pub struct PlanRevision<'s> {
    /// Files of the older revision.
    against: Vec<String>,
    /// Files of the newer one.
    files: Vec<String>,
    /// Spaces that open at other dates.
    spaces: Vec<SpaceEntry<'s>>,
    /// Elements that stand, or are removed, at other dates.
    elements: Vec<ElementEntry<'s>>,
    /// All map storeys with the times at which an element or space of them differs.
    storeys: Vec<StoreyEntry<'s>>,
}

/// A date in both revisions.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct RevisedDate {
    before: Option<String>,
    after: Option<String>,
    /// Hours that it is later; negative if it is earlier, null if a revision has no date.
    later_h: Option<f64>,
}

#[derive(Debug, Serialize)]
struct SpaceEntry<'s> {
    global_id: &'s str,
    name: &'s str,
    long_name: &'s str,
    /// When it first opens after it was closed; null if it never does.
    first_opens: RevisedDate,
    /// When it opens and is not closed again; null if it is never closed, or closed in the end.
    finally_opens: RevisedDate,
}

#[derive(Debug, Serialize)]
struct ElementEntry<'s> {
    global_id: &'s str,
    #[serde(rename = "type")]
    ifc_type: &'s str,
    name: &'s str,
    /// When it first stands; null if it does from the beginning, or never.
    stands: RevisedDate,
    /// When it is gone and does not come back; null if that never is.
    removed: RevisedDate,
}

#[derive(Debug, Serialize)]
struct StoreyEntry<'s> {
    /// Index of the map storey.
    index: usize,
    name: &'s str,
    /// Elements in its heights that differ at any time.
    elements: usize,
    /// Spaces of it that differ at any time.
    spaces: usize,
    /// When any of them differs.
    differs: Vec<Span>,
}

/// A span of time.
#[derive(Debug, Serialize)]
struct Span {
    /// Null: from the beginning.
    from: Option<String>,
    /// Exclusive; null: for good.
    until: Option<String>,
}

/// Compares two revisions of the plan of a site.
pub fn revision<'s>(
    site: &'s Site<'_>,
    before: (&Timeline, Vec<String>),
    after: (&Timeline, Vec<String>),
) -> PlanRevision<'s> {
    let [old, new] = [before.0, after.0].map(|timeline| StateHistory::of(site, timeline));
    let elements: Vec<Vec<[i64; 2]>> =
        (0..site.elements.len()).map(|k| differing_spans(&old.elements[k], &new.elements[k])).collect();
    let spaces: Vec<Vec<[i64; 2]>> =
        (0..site.spaces.len()).map(|k| differing_spans(&old.blocked[k], &new.blocked[k])).collect();
    PlanRevision {
        against: before.1,
        files: after.1,
        spaces: (0..spaces.len()).filter_map(|k| SpaceEntry::of(site, k, [&old.blocked[k], &new.blocked[k]])).collect(),
        elements: (0..elements.len())
            .filter_map(|k| ElementEntry::of(site, k, [&old.elements[k], &new.elements[k]]))
            .collect(),
        storeys: (0..site.map_storeys.len()).map(|k| StoreyEntry::of(site, k, &elements, &spaces)).collect(),
    }
}

impl RevisedDate {
    fn of([before, after]: [Option<i64>; 2]) -> Self {
        let later_h = before.zip(after).map(|(before, after)| ((after - before) as f64 / 36.0).round() / 100.0);
        Self { before: before.map(date_text), after: after.map(date_text), later_h }
    }

    fn differs(&self) -> bool {
        self.before != self.after
    }
}

impl<'s> SpaceEntry<'s> {
    /// `None` if it opens as before.
    fn of(site: &Site<'s>, k: usize, blocked: [&[(i64, bool)]; 2]) -> Option<Self> {
        // The first state of a history is no change.
        let opens = |steps: &[(i64, bool)]| steps.iter().skip(1).find(|step| !step.1).map(|step| step.0);
        let finally =
            |steps: &[(i64, bool)]| steps.iter().skip(1).next_back().filter(|step| !step.1).map(|step| step.0);
        let first_opens = RevisedDate::of(blocked.map(opens));
        let finally_opens = RevisedDate::of(blocked.map(finally));
        let space = &site.spaces[k];
        let [global_id, name, long_name] = [space.global_id, space.name, space.long_name].map(|text| site.text(text));
        let differs = first_opens.differs() || finally_opens.differs();
        differs.then_some(Self { global_id, name, long_name, first_opens, finally_opens })
    }
}

impl<'s> ElementEntry<'s> {
    /// `None` if it stands and is removed as before.
    fn of(site: &Site<'s>, k: usize, steps: [&[(i64, StandingState)]; 2]) -> Option<Self> {
        let stands = |steps: &[(i64, StandingState)]| {
            steps.iter().find(|step| step.1 == StandingState::Stands).map(|step| step.0).filter(|at_s| *at_s > i64::MIN)
        };
        let removed = |steps: &[(i64, StandingState)]| {
            steps.iter().skip(1).next_back().filter(|step| step.1 == StandingState::Absent).map(|step| step.0)
        };
        let (stands, removed) = (RevisedDate::of(steps.map(stands)), RevisedDate::of(steps.map(removed)));
        let element = &site.elements[k];
        let [global_id, ifc_type, name] = [element.global_id, element.ifc_type, element.name].map(|t| site.text(t));
        (stands.differs() || removed.differs()).then_some(Self { global_id, ifc_type, name, stands, removed })
    }
}

impl<'s> StoreyEntry<'s> {
    fn of(site: &Site<'s>, storey: usize, elements: &[Vec<[i64; 2]>], spaces: &[Vec<[i64; 2]>]) -> Self {
        let record = &site.map_storeys[storey];
        let [lowest, highest] =
            [-BELOW_FLOOR_TENTHS, ABOVE_FLOOR_TENTHS].map(|by| record.floor_z_tenths.saturating_add(by));
        let is_shown = |k: &usize| {
            let element = &site.elements[*k];
            element.n_parts > 0 && element.min_tenths[2] <= highest && lowest <= element.max_tenths[2]
        };
        let is_of_it = |k: &usize| {
            let of = site.spaces[*k].map_storey;
            of != NONE && of as usize == storey
        };
        let elements = (0..elements.len()).filter(is_shown).map(|k| &elements[k]).filter(|spans| !spans.is_empty());
        let spaces = (0..spaces.len()).filter(is_of_it).map(|k| &spaces[k]).filter(|spans| !spans.is_empty());
        let [elements, spaces] = [elements.collect::<Vec<_>>(), spaces.collect()];
        let spans = united(elements.iter().chain(&spaces).flat_map(|spans| spans.iter().copied()).collect());
        let time = |at_s: i64| Some(at_s).filter(|s| i64::MIN < *s && *s < i64::MAX).map(date_text);
        let span = |[from_s, until_s]: [i64; 2]| Span { from: time(from_s), until: time(until_s) };
        Self {
            index: storey,
            name: site.text(record.name),
            elements: elements.len(),
            spaces: spaces.len(),
            differs: spans.into_iter().map(span).collect(),
        }
    }
}

impl PlanRevision<'_> {
    /// For people.
    pub fn text(&self) -> String {
        let mut out = format!("{} against {}\n", self.files.join(", "), self.against.join(", "));
        let space = |space: &SpaceEntry<'_>| {
            let name = [space.name, space.long_name].join(" ");
            let name = if name.trim().is_empty() { space.global_id } else { name.trim() };
            let dates = if space.first_opens == space.finally_opens {
                space.first_opens.text("opens")
            } else {
                [space.first_opens.text("opens first"), space.finally_opens.text("opens for good")].concat()
            };
            format!("{name}: {}", dates.trim_start_matches("; "))
        };
        list(&mut out, "rooms that open at other dates", self.spaces.iter().map(space));
        let element = |element: &ElementEntry<'_>| {
            let dates = [element.stands.text("stands"), element.removed.text("is gone")].concat();
            format!("{} {} {:?}: {}", element.global_id, element.ifc_type, element.name, dates.trim_start_matches("; "))
        };
        list(&mut out, "elements that stand or are removed at other dates", self.elements.iter().map(element));
        for storey in self.storeys.iter().filter(|storey| !storey.differs.is_empty()) {
            let what = format!(
                "maps of storey {} {} may differ ({} elements, {} rooms), spans of time",
                storey.index, storey.name, storey.elements, storey.spaces
            );
            list(&mut out, &what, storey.differs.iter().map(Span::text));
        }
        let names: Vec<&str> = self.storeys.iter().filter(|s| s.differs.is_empty()).map(|storey| storey.name).collect();
        if !names.is_empty() {
            // Writing to a string does not fail.
            let _ = writeln!(out, "storeys whose maps are the same on all days: {}", names.join(", "));
        }
        out
    }
}

impl RevisedDate {
    /// `; stands 2024-05-02T00:00:00 instead of 2024-04-29T00:00:00 (72 h later)`, or nothing if it is the same.
    fn text(&self, what: &str) -> String {
        let date = |date: &Option<String>| date.clone().unwrap_or_else(|| "no date".to_owned());
        let by = match self.later_h {
            Some(hours) if hours > 0.0 => format!(" ({hours} h later)"),
            Some(hours) => format!(" ({} h earlier)", -hours),
            None => String::new(),
        };
        let text = || format!("; {what} {} instead of {}{by}", date(&self.after), date(&self.before));
        if self.differs() { text() } else { String::new() }
    }
}

impl Span {
    fn text(&self) -> String {
        let from = self.from.as_deref().unwrap_or("from the beginning");
        format!("{from} until {}", self.until.as_deref().unwrap_or("the end"))
    }
}

/// A heading with the number of lines, and the first of them.
fn list(out: &mut String, what: &str, lines: impl ExactSizeIterator<Item = String>) {
    let n = lines.len();
    // Writing to a string does not fail.
    let _ = writeln!(out, "{what}: {n}");
    for line in lines.take(MAX_LINES) {
        let _ = writeln!(out, "  {line}");
    }
    if n > MAX_LINES {
        let _ = writeln!(out, "  .. and {} more; --json lists all", n - MAX_LINES);
    }
}
