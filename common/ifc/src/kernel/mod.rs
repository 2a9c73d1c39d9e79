//! The only place that names ifc-lite: records, schema, meshes.
//!
//! Everything else works on [`File`], [`Record`] and [`MeshPart`](crate::MeshPart), so that the kernel can be replaced.

mod file;
mod mesh;
mod patch;
mod placement;
mod schema;
mod step;

pub(crate) use file::{Class, File, Span};
pub(crate) use mesh::{ItemMesh, MeshRequest, mesh};
pub(crate) use patch::Patch;
pub(crate) use placement::Resolver;
pub(crate) use schema::Schema;
pub(crate) use step::{Record, Value};
