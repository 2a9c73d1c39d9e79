//! The only place that names ifc-lite: records, schema, meshes.
//!
//! Everything else works on [`File`], [`Record`] and [`MeshPart`](crate::MeshPart), so that the kernel can be replaced.

mod cached;
mod content_keys;
mod file;
mod mesh;
mod patch;
mod placement;
mod pool;
mod record_index;
mod record_order;
mod record_table;
mod references;
mod request;
mod schema;
mod step;
mod task;

pub(crate) use cached::mesh;
pub(crate) use file::{Class, File};
pub(crate) use mesh::{ItemMesh, Meshed, faces};
pub(crate) use patch::Patch;
pub(crate) use placement::Resolver;
pub use pool::MeshPool;
pub(crate) use record_index::Span;
pub(crate) use record_table::RecordTable;
pub(crate) use request::MeshRequest;
pub(crate) use schema::Schema;
pub(crate) use step::members;
pub use step::{Record, Value};
pub use task::mesh_task;
