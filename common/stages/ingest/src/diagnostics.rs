//! Writes diagnostics into the `site` archive.

use ifc::Diagnostic;
use messages::{DiagnosticRecord, SiteBuilder};

/// Writes one diagnostic of a file.
pub(crate) fn add_diagnostic(builder: &mut SiteBuilder, source: u32, diagnostic: &Diagnostic) {
    let record = DiagnosticRecord { source, ..DiagnosticRecord::of(diagnostic, &mut builder.texts) };
    builder.diagnostics.push(record);
}
