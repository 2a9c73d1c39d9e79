//! IFC ingestion: files in, `site` out.

use bus::Daemon;
use ifc_ingest::service::IngestService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(Daemon::IfcIngest, IngestService::new)
}
