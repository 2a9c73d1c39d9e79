//! The ifc-ingest daemon: IFC files in, `site` out.

mod service;

use service::IngestService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run(IngestService::new)
}
