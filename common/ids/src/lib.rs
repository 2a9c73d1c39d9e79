//! Reads IDS files and checks IFC files against them.
//!
//! An IDS file (Information Delivery Specification 1.0, buildingSMART) says what elements of a model must have. [`Ids::read`] reads
//! one, and [`check()`] tells of an IFC file which elements meet each specification and what is wrong with the others. Both take
//! bytes: no files, no bus. [`GROUNDPLAN`] says what maps need.
//!
//! ```
//! let ids = ids::Ids::read(ids::GROUNDPLAN.as_bytes())?;
//! let ifc = b"ISO-10303-21;HEADER;FILE_SCHEMA(('IFC4'));ENDSEC;DATA;#1=IFCPROJECT('p',$,$,$,$,$,$,$,$);ENDSEC;END-ISO-10303-21;";
//! let report = ids::check(&ids, ifc, ids::Scope::OfRelease).expect("it is an IFC file");
//! assert!(!report.passed);
//! print!("{}", report.text());
//! # Ok::<(), ids::IdsError>(())
//! ```
//!
//! # Guarantees
//!
//! - A file that does not follow the XML schema of IDS 1.0 is refused with its line, and so is a specification that no IFC file can
//!   meet: a class that no release has, a number with a comma, a pattern for a number (`src/audit.rs`). What only one of the
//!   releases of a specification lacks is no fault.
//! - Regular expressions are those of XML Schema, and match in time in proportion to the text (`src/pattern.rs`).
//! - Values are compared in units of SI, attributes included; a length, area, volume, angle or mass in a unit that the file does
//!   not define matches nothing. Reals are equal within 1e-6 of their size and 1e-6.
//! - The data of the schemas comes from `scripts/ids_schema.py`; IFC2X3, IFC4 and IFC4X3, releases between them as the one before.
//! - Results depend on the bytes alone. Limits: 32 MiB of IDS, nesting of 32, those of `ifc` for the model.
//!
//! # Where IDS leaves it open
//!
//! - An optional property without a value passes; a prohibited one fails, as the user manual has it.
//! - A bounded property matches a value between its bounds, and with a set point that point or a bound.
//! - Several patterns of one restriction are alternatives, as in XML Schema.
//! - Sets of one name at one element are one set.
//! - Wholes are followed through all relations, or through the one that is named, as far as they go.

mod audit;
mod check;
mod describe;
mod document;
mod error;
mod facets;
mod model;
mod pattern;
mod read;
mod report;
mod schema;
mod units;
mod value;
mod xml;

pub use check::{Scope, check, check_file};
pub use document::{
    AttributeFacet, Cardinality, ClassificationFacet, EntityFacet, Facet, FacetAt, Ids, Info, MaterialFacet,
    PartOfFacet, PropertyFacet, Relation, Requirement, Specification, SpecificationCardinality,
};
pub use error::{CheckError, IdsError};
pub use pattern::Pattern;
pub use report::{
    FailedElement, IdsReport, REPORT_VERSION, RequirementReport, SpecificationOutcome, SpecificationReport,
};
pub use schema::{Release, concrete_entities, enumeration_values};
pub use value::{Bound, BoundKind, Constraint, Restriction};

/// What maps, doors, waypoints, schedules and alignment need of a model: `config/ids/groundplan.ids`.
pub const GROUNDPLAN: &str = include_str!("../../../config/ids/groundplan.ids");

impl Ids {
    /// Reads an IDS file: UTF-8, or the encoding that it declares or marks.
    ///
    /// # Errors
    /// What is no XML, not as IDS 1.0 demands, or asks for what no IFC file can have; the text names the line.
    pub fn read(bytes: &[u8]) -> Result<Self, IdsError> {
        let ids = read::read(bytes)?;
        audit::check(&ids)?;
        Ok(ids)
    }
}
