//! The ifc-ingest daemon: IFC files in, `site` out.

use ifc_ingest::service::Ingest;
use std::process::ExitCode;

fn main() -> ExitCode {
    daemon::run_mesh_process(ingest::mesh_task).unwrap_or_else(|| daemon::run(bus::commit!(), Ingest::start))
}
