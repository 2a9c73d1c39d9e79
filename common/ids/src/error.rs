//! Errors of reading an IDS file and of checking an IFC file.

/// An IDS file that cannot be used. The text names the place and the fault.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum IdsError {
    /// More bytes than are read.
    #[error("the IDS file has {bytes} bytes, and files of at most {max} are read")]
    TooLarge {
        /// Length of the file.
        bytes: usize,
        /// The limit.
        max: usize,
    },
    /// Bytes that are not in the encoding that the file declares.
    #[error("the IDS file is not in the encoding {encoding}")]
    Encoding {
        /// Its name.
        encoding: String,
    },
    /// Not well-formed XML.
    #[error("line {line} of the IDS file: {why}")]
    Xml {
        /// Line, from 1.
        line: usize,
        /// The fault.
        why: String,
    },
    /// XML that is not as the schema of IDS 1.0 demands.
    #[error("line {line} of the IDS file: {why}; IDS 1.0 does not allow it")]
    Structure {
        /// Line, from 1.
        line: usize,
        /// The fault.
        why: String,
    },
    /// A specification that no IFC file can meet.
    #[error("line {line} of the IDS file, specification {specification:?}: {why}, so no IFC file can meet it")]
    Unsatisfiable {
        /// Line of the facet, from 1.
        line: usize,
        /// Name of the specification.
        specification: String,
        /// The contradiction.
        why: String,
    },
}

/// An IFC file that cannot be checked.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// Nothing could be made of the IFC file.
    #[error("the IFC file cannot be read")]
    Ifc(#[from] ifc::ReadError),
}
