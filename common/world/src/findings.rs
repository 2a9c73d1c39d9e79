//! Diagnostics of a world: elements that are not in it, and pieces for which others stand in.

use crate::collision_meshes::Replacement;
use crate::static_elements::Body;
use diagnostics::counted;
use export::ExportInput;
use messages::{Diagnostic, DiagnosticCode, Named, Severity};
use std::collections::BTreeMap;

/// What there is to say about the link of an element, or of a stand-in, of so many pieces.
pub(crate) fn of_link(
    input: &ExportInput<'_>,
    body: Body,
    link: &str,
    n_pieces: usize,
    replaced: &BTreeMap<Replacement, usize>,
) -> Option<Diagnostic> {
    let (code, message) = if n_pieces == 0 && body != Body::StandIn {
        (DiagnosticCode::NotInWorld, "no convex piece could be made of its body: it is not in the world".to_owned())
    } else if replaced.is_empty() {
        return None;
    } else {
        let words = |(replacement, n): (&Replacement, &usize)| match replacement {
            Replacement::Hull => format!("the hull of its corners stands in for {n} that were not closed and convex"),
            Replacement::Plate => format!("plates of 2 mm stand in for {n} without thickness"),
        };
        let words: Vec<String> = replaced.iter().map(words).collect();
        let of = format!("of its {} that collide", counted(n_pieces, "piece"));
        (DiagnosticCode::CollisionReplaced, format!("{of}, with the corners of their files: {}", words.join("; ")))
    };
    let named =
        named(input, body).unwrap_or_else(|| Named { step_id: 0, global_id: String::new(), name: link.to_owned() });
    Some(Diagnostic { severity: Severity::Warning, code, entity: Some(named), source: None, message })
}

/// That ground lies outside of the map of the ground outdoors.
pub(crate) fn of_far_ground(input: &ExportInput<'_>, body: Body) -> Diagnostic {
    Diagnostic {
        severity: Severity::Info,
        code: DiagnosticCode::NotInWorld,
        entity: named(input, body),
        source: None,
        message: "it lies outside of the map of the ground outdoors, and is not in the world".to_owned(),
    }
}

fn named(input: &ExportInput<'_>, body: Body) -> Option<Named> {
    let [global_id, name, _] = body.texts(input.site)?.map(|text| input.site.text(text).to_owned());
    Some(Named { step_id: 0, global_id, name })
}
