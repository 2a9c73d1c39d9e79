//! The ifc-ingest daemon: IFC files in, `site` out.

mod model_files;
mod revision_reader;
mod revisions;
mod service;
mod site_store;

use service::IngestService;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run_mesh_process(ingest::mesh_task).unwrap_or_else(|| daemon::run(IngestService::new))
}
