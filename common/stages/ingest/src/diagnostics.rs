//! Writes diagnostics into the `site` archive.

use ifc::{Diagnostic, Named, Severity};
use messages::{DiagnosticRecord, SiteBuilder};

/// Writes one diagnostic of a file.
pub(crate) fn add_diagnostic(builder: &mut SiteBuilder, source: u32, diagnostic: &Diagnostic) {
    let nobody = Named::default();
    let entity = diagnostic.entity.as_ref().unwrap_or(&nobody);
    let record = DiagnosticRecord {
        code: builder.texts.add(diagnostic.code),
        global_id: builder.texts.add(&entity.global_id),
        name: builder.texts.add(&entity.name),
        message: builder.texts.add(&diagnostic.message),
        severity: match diagnostic.severity {
            Severity::Info => 0,
            Severity::Warning => 1,
            Severity::Error => 2,
        },
        step_id: entity.step_id,
        source,
        reserved: 0,
    };
    builder.diagnostics.push(record);
}
