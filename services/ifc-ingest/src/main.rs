//! The ifc-ingest daemon: IFC files in, `site` out.

mod service;

use bus::Daemon;
use service::IngestService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(Daemon::IfcIngest, IngestService::new)
}
