//! Decisions on revisions of a site around the `ingest` stage.

mod in_force;
pub mod judge;
mod mesh_store;
mod model_files;
mod output;
mod proposal;
mod revision_reader;
mod revision_verdict;
mod revisions;
pub mod service;
mod site_store;
