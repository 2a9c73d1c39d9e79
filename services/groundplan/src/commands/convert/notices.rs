//! Notices on standard output after a conversion, one per kind of diagnostic; `report.json` and `world/lookup.json` have all.

use diagnostics::counted;
use export::ExportInput;
use frames::metres;
use messages::{Diagnostic, DiagnosticRecord, DoorPassageRecord, FloorKind, Grid, NONE, ScheduleState, Severity, Site};

/// The notice about a model from which no floor can be made.
const NO_FLOOR: &str = "warning: the model holds no floor (slab, covering, ramp), no space and no wall: its maps show obstacles, \
                        no cell is free and there are no waypoints";

/// How many rooms are named for each storey.
const MAX_ROOMS: usize = 6;

/// The notices, worst first.
pub(super) fn notices(input: &ExportInput<'_>, world_diagnostics: &[Diagnostic]) -> Vec<String> {
    let site = input.site;
    let mut kinds = Kinds::default();
    let has = |kind: FloorKind| input.grids.heads().any(|head| head.floor == kind);
    if has(FloorKind::Missing) && !has(FloorKind::Ground) {
        kinds.add("floor_missing", NO_FLOOR.to_owned());
    }
    if let Some(line) = assumed_floors(input) {
        kinds.add("floor_assumed", line);
    }
    for storey in site.storeys.iter().filter(|s| s.map_storey == NONE && s.why.length > 0) {
        let (id, name, why) = (site.text(storey.global_id), site.text(storey.name), site.text(storey.why));
        let name = if name.is_empty() { id } else { name };
        kinds.add(id, format!("warning: storey {name:?} is not mapped: {why}"));
    }
    if export::schedule_ignored(site, input.schedule_state) {
        kinds.add("schedule", "warning: the model holds a schedule; this map shows everything built".to_owned());
    }
    for (word, diagnostic) in worst_first(site.diagnostics) {
        kinds.add(diagnostic.code.get().name(), format!("{word}: {}", of_diagnostic(site, diagnostic)));
    }
    for (word, diagnostic) in worst_first(input.schedule_state.diagnostics) {
        kinds.add(diagnostic.code.get().name(), format!("{word}: {}", of_schedule(input.schedule_state, diagnostic)));
    }
    for diagnostic in input.mission_plan.diagnostics.iter().filter(|d| d.severity == Severity::Error) {
        let message = input.mission_plan.text(diagnostic.message);
        kinds.add(diagnostic.code.get().name(), format!("error: {message}"));
    }
    for diagnostic in world_diagnostics {
        let Diagnostic { severity, code, entity, message, .. } = diagnostic;
        let entity = entity.as_ref();
        let who = entity.map_or(["", ""], |e| [&e.global_id, &e.name]);
        kinds.add(code.name(), format!("{}: {}", severity.name(), about(&who, message)));
    }
    let doors = export::each_door(site, input.index.doors);
    for record in doors.into_iter().filter(|d| input.writes(d.map_storey)) {
        if let Some(first) = record.closed_by().next() {
            kinds.add(&format!("door {}", first.name()), of_door(input, &record));
        }
    }
    kinds.lines()
}

/// The storeys on which floor is not that of the model: the rooms without a slab, or how much walls enclose.
fn assumed_floors(input: &ExportInput<'_>) -> Option<String> {
    let rooms = export::assumed_rooms(input.site);
    let storey = |grid: &Grid<'_>| {
        let index = grid.head.map_storey;
        let name = input.site.text(input.site.map_storeys[index as usize].name);
        if grid.head.floor == FloorKind::AssumedFromEnclosure {
            let cell_m2 = metres(grid.head.cell_tenths).powi(2);
            let floor_m2 = grid.floor.iter().filter(|f| **f != 0).count() as f64 * cell_m2;
            return Some(format!("{name:?} {floor_m2:.1} m2 that its walls enclose"));
        }
        let own = rooms.iter().copied().filter(|room| input.site.spaces[*room as usize].map_storey == index);
        let own: Vec<String> = own.map(|room| room_words(input.site, room)).collect();
        let named = &own[..own.len().min(MAX_ROOMS)];
        let more =
            if named.len() < own.len() { format!(" and {} more", own.len() - named.len()) } else { String::new() };
        (!own.is_empty()).then(|| format!("{name:?} {}: {}{more}", counted(own.len(), "room"), named.join(", ")))
    };
    let storeys: Vec<String> = input.grids.each(storey).flatten().collect();
    let why = "warning: floor is assumed where the model has none (slabs, coverings, ramps)";
    (!storeys.is_empty()).then(|| format!("{why}: {}", storeys.join("; ")))
}

/// Name and area of a room.
fn room_words(site: &Site<'_>, room: u32) -> String {
    let record = &site.spaces[room as usize];
    let name = export::space_name(site, room).unwrap_or_else(|| site.text(record.global_id).to_owned());
    format!("{name} {:.1} m2", record.area_m2)
}

/// Errors, then warnings, each with its severity.
fn worst_first(diagnostics: &[DiagnosticRecord]) -> impl Iterator<Item = (&'static str, &DiagnosticRecord)> {
    let of = |severity: Severity| {
        diagnostics.iter().filter(move |d| d.severity == severity).map(move |d| (severity.name(), d))
    };
    [Severity::Error, Severity::Warning].into_iter().flat_map(of)
}

fn of_diagnostic(site: &Site<'_>, d: &DiagnosticRecord) -> String {
    let file = site.source_file(d.source).unwrap_or_default();
    let step_id = if d.step_id == 0 { String::new() } else { format!("#{}", d.step_id) };
    let who = [file, &step_id, site.text(d.global_id), site.text(d.name)];
    about(&who, site.text(d.message))
}

fn of_schedule(schedule_state: &ScheduleState<'_>, d: &DiagnosticRecord) -> String {
    about(&[schedule_state.text(d.global_id), schedule_state.text(d.name)], schedule_state.text(d.message))
}

/// A message behind the names of its entity; empty names are left out.
fn about(who: &[&str], message: &str) -> String {
    let words: Vec<&str> = who.iter().copied().filter(|word| !word.is_empty()).collect();
    if words.is_empty() { message.to_owned() } else { format!("{}: {message}", words.join(" ")) }
}

fn of_door(input: &ExportInput<'_>, record: &DoorPassageRecord) -> String {
    let site = input.site;
    let element = &site.elements[site.doors[record.door as usize].element as usize];
    let reason = |reason| export::reason_text(site, &input.index.head.robot, record, reason);
    let why: Vec<String> = record.closed_by().map(reason).collect();
    let on_storey = format!("on {}", site.text(site.map_storeys[record.map_storey as usize].name));
    let who = [site.text(element.global_id), site.text(element.name), &on_storey];
    format!("door closed: {}", about(&who, &why.join("; ")))
}

/// Diagnostics by kind, in the order of each kind's first.
#[derive(Default)]
struct Kinds(Vec<(String, String, usize)>);

impl Kinds {
    fn add(&mut self, kind: &str, line: String) {
        match self.0.iter_mut().find(|known| known.0 == kind) {
            Some((_, _, count)) => *count += 1,
            None => self.0.push((kind.to_owned(), line, 1)),
        }
    }

    fn lines(self) -> Vec<String> {
        let line = |(_, first, count): (String, String, usize)| match count {
            1 => first,
            _ => format!("{first} (and {} more of this kind)", count - 1),
        };
        self.0.into_iter().map(line).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_about_nothing_named_begins_with_itself() {
        assert_eq!(about(&["", ""], "the map frame is kept"), "the map frame is kept");
        assert_eq!(about(&["house.ifc", "", "Door"], "is closed"), "house.ifc Door: is closed");
    }

    #[test]
    fn findings_of_one_kind_share_a_line() {
        let mut kinds = Kinds::default();
        for (kind, line) in [("a", "first"), ("b", "other"), ("a", "second"), ("a", "third")] {
            kinds.add(kind, line.to_owned());
        }
        assert_eq!(kinds.lines(), ["first (and 2 more of this kind)", "other"]);
    }
}
