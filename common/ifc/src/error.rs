//! Errors of reading a file.

/// Errors of reading a file. The text names the fault and a remedy.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// No bytes.
    #[error("the file is empty; export it again")]
    Empty,
    /// More bytes than 32 bits number.
    #[error("the file has {bytes} bytes, and files of less than 4 GiB are read; export the model in parts")]
    TooLarge {
        /// Length of the file.
        bytes: usize,
    },
    /// Neither STEP nor a zip container of STEP.
    #[error("this is no IFC file: it begins with {begins:?} instead of ISO-10303-21; give a .ifc or .ifczip file")]
    NotStep {
        /// The first characters.
        begins: String,
    },
    /// A file of another format, which is known by its first bytes.
    #[error("this is no IFC file but {what}")]
    OtherFormat {
        /// What it is, and what to do instead.
        what: &'static str,
    },
    /// The header does not say which schema the data follows.
    #[error("the header has no readable FILE_SCHEMA, so the data cannot be interpreted; export the file again")]
    NoSchema,
    /// Bytes that no process that reads files has made.
    #[error("these bytes are no task of meshing")]
    NoTask,
    /// STEP, but of a schema that is not read.
    #[error(
        "schema {schema:?} is not read; export the file as IFC2X3, IFC4 or IFC4X3 (IFC2X and IFC2X2 are read as IFC2X3)"
    )]
    UnsupportedSchema {
        /// FILE_SCHEMA as written.
        schema: String,
    },
    /// The end is missing.
    #[error("the file is cut off: {missing} is missing at its end; copy or export it again")]
    Truncated {
        /// The missing part.
        missing: &'static str,
    },
    /// A record swallows the rest of the file.
    #[error("the record that begins with {begins:?} is never closed and hides the rest of the file; export it again")]
    UnclosedRecord {
        /// The first characters of the record.
        begins: String,
    },
    /// There is geometry, but no length unit to read it in.
    #[error("the length unit is unknown ({why}), so the geometry has no size; export the file with a length unit")]
    UnknownLengthUnit {
        /// The fault.
        why: String,
    },
    /// A zip container without exactly one readable .ifc file.
    #[error("the zip container cannot be used: {why}")]
    Container {
        /// The fault.
        why: String,
    },
    /// The machine refused the threads that the kernel needs.
    #[error("no threads for meshing")]
    Threads(#[source] rayon::ThreadPoolBuildError),
}
