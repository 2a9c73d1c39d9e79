//! Reports of pairs of files as lines of JSON, for comparison with another checker (`scripts/check_ids.py`).
//!
//! usage: ids_report IDS IFC [IDS IFC]..
//!
//! All specifications are checked, whatever their release. A file that is refused gives `{"error": ..}`.

#![expect(clippy::print_stdout, reason = "it prints what it finds")]

use std::process::ExitCode;

use ids::{Ids, Scope};

fn line(ids: &str, ifc: &str) -> std::io::Result<String> {
    let (ids, ifc) = (std::fs::read(ids)?, std::fs::read(ifc)?);
    let report = Ids::read(&ids).map_err(|error| error.to_string());
    let report = report.and_then(|ids| ids::check(&ids, &ifc, Scope::All).map_err(|error| error.to_string()));
    let value = match report {
        Ok(report) => serde_json::to_value(report)?,
        Err(error) => serde_json::json!({ "error": error }),
    };
    Ok(value.to_string())
}

fn main() -> ExitCode {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    if paths.is_empty() || !paths.len().is_multiple_of(2) {
        eprintln!("usage: ids_report IDS IFC [IDS IFC]..");
        return ExitCode::from(2);
    }
    for pair in paths.chunks_exact(2) {
        match line(&pair[0], &pair[1]) {
            Ok(line) => println!("{line}"),
            Err(error) => {
                eprintln!("{} or {}: {error}", pair[0], pair[1]);
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
