//! A revision of a site compared with the one in force, as a table for people.

use daemon::{IngestAnswer, Revision, RevisionEffect};
use messages::{Difference, StoreyPresence};
use std::fmt::Write;

/// What became of a revision, below how it differs.
pub(crate) fn text(answer: &IngestAnswer) -> String {
    let mut out = answer.revision.as_ref().map(table).unwrap_or_default();
    let objections = answer.revision.iter().flat_map(|revision| &revision.comparison.objections);
    let objections: String = objections.map(|objection| format!("  {objection}\n")).collect();
    out += &match (answer.effect, objections.is_empty()) {
        (RevisionEffect::InForce, _) if answer.site.epoch == 0 => "there is no site yet\n".to_owned(),
        (RevisionEffect::InForce, _) => format!("in force, epoch {}\n", answer.site.epoch),
        (RevisionEffect::Waits, _) => {
            format!("waits for groundplan confirm; groundplan load --discard forgets it:\n{objections}")
        }
        (RevisionEffect::DryRun, true) => "compared only: it would take effect\n".to_owned(),
        (RevisionEffect::DryRun, false) => {
            format!("compared only: it would wait for groundplan confirm:\n{objections}")
        }
        (RevisionEffect::Discarded, _) => "discarded\n".to_owned(),
    };
    out
}

/// Storeys, elements, rooms and warnings, before and after.
fn table(revision: &Revision) -> String {
    let comparison = &revision.comparison;
    let mut out = format!("{:<32} {:>8} {:>8} {:>8} {:>8}\n", "", "before", "after", "added", "removed");
    let mut row = |name: &str, d: &Difference, note: &str| {
        let name: String = name.chars().take(32).collect();
        let cells = format!("{name:<32} {:>8} {:>8} {:>8} {:>8}", d.before, d.after, d.added, d.removed);
        let _ = writeln!(out, "{cells}{note}");
    };
    for storey in &comparison.storeys {
        // A storey of both, without elements, is not worth a line.
        if storey.presence == StoreyPresence::Kept && storey.elements == Difference::default() {
            continue;
        }
        let note = match storey.presence {
            StoreyPresence::Kept => "",
            StoreyPresence::Added => "  new storey",
            StoreyPresence::Removed => "  storey removed",
        };
        row(&storey.name, &storey.elements, note);
    }
    let bodies = match (comparison.n_changed, comparison.n_moved) {
        (0, _) => String::new(),
        (changed, 0) => format!("  {changed} changed"),
        (changed, moved) => format!("  {changed} changed, {moved} of them moved"),
    };
    row("elements", &comparison.elements, &bodies);
    row("rooms", &comparison.rooms, "");
    let [before, after] = comparison.warnings;
    let _ = writeln!(out, "{:<32} {before:>8} {after:>8}", "warnings");
    if comparison.other_georeference {
        out += "another georeference\n";
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::Published;
    use messages::{ContentHash, SiteComparison, StoreyDifference};

    #[test]
    fn a_revision_that_waits_is_shown_with_its_storeys_and_the_reasons() {
        let difference =
            |before, after, added, removed| Difference { before, after, shared: before - removed, added, removed };
        let storey = |name: &str, presence, elements| StoreyDifference {
            global_id: name.to_owned(),
            name: name.to_owned(),
            presence,
            elements,
            n_bodies: 0,
            n_bodies_lost: 0,
        };
        let comparison = SiteComparison {
            storeys: vec![
                storey("Ground floor", StoreyPresence::Kept, difference(20, 21, 1, 0)),
                storey("Roof", StoreyPresence::Removed, difference(4, 0, 0, 4)),
            ],
            elements: difference(24, 21, 1, 4),
            n_changed: 2,
            n_moved: 1,
            rooms: difference(3, 3, 0, 0),
            warnings: [1, 2],
            unmapped: Vec::new(),
            damages: [0, 0],
            other_georeference: false,
            objections: vec!["it removes 4 of 4 elements of storey Roof".to_owned()],
        };
        let answer = IngestAnswer {
            site: Published { content_hash: ContentHash::from_bits(1), epoch: 7 },
            effect: RevisionEffect::Waits,
            revision: Some(Revision { models: vec!["/b.ifc".into()], sha256: Vec::new(), comparison }),
        };
        let expected = "
                                   before    after    added  removed
Ground floor                           20       21        1        0
Roof                                    4        0        0        4  storey removed
elements                               24       21        1        4  2 changed, 1 of them moved
rooms                                   3        3        0        0
warnings                                1        2
waits for groundplan confirm; groundplan load --discard forgets it:
  it removes 4 of 4 elements of storey Roof
";
        assert_eq!(format!("\n{}", text(&answer)), expected);
        let in_force = IngestAnswer { effect: RevisionEffect::InForce, revision: None, ..answer };
        assert_eq!(text(&in_force), "in force, epoch 7\n");
    }
}
