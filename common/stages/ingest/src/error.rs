//! Errors of ingestion.

use crate::input::MAX_SPACES;
use ifc::ReadError;

/// Errors of ingestion.
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    /// The list of files is empty.
    #[error("no file was given")]
    NoFiles,
    /// A file cannot be read.
    #[error("{file} cannot be read")]
    Read {
        /// Base name.
        file: String,
        /// Why.
        source: ReadError,
    },
    /// Boxes would stand in for most of a file.
    #[error(
        "of {n_bodies} bodies in {file} {n_lost} cannot be meshed, and a map of bounding boxes looks like one of a building \
         ({element}: {why}): export the file with other geometry; --allow-boxes, or allow_boxes in the site's configuration, \
         takes the boxes"
    )]
    MostlyBoxes {
        /// Base name.
        file: String,
        /// Elements of which a box or nothing is drawn.
        n_lost: usize,
        /// Elements with a body.
        n_bodies: usize,
        /// Entity, STEP id and GlobalId of the first of them.
        element: String,
        /// Why it cannot be meshed.
        why: String,
    },
    /// Two files lie too far apart.
    #[error(
        "{first} and {file} lie {gap_m:.0} m apart: if they are one site, say where the second lies with \
         --place {file}=X,Y,Z,YAW"
    )]
    FarApart {
        /// The first file.
        first: String,
        /// The file that is far from it.
        file: String,
        /// Gap between their boxes.
        gap_m: f64,
    },
    /// More spaces than the `space` layer of a grid can number.
    #[error("the site has {n_spaces} spaces, a map can number {MAX_SPACES}: convert the files one by one")]
    TooManySpaces {
        /// Spaces of all files.
        n_spaces: usize,
    },
    /// Two elements have one GlobalId and different bodies.
    #[error("{ifc_type} {global_id} of {file} has another body in an earlier file: --prefer-last takes the last")]
    TwoBodies {
        /// Entity name.
        ifc_type: String,
        /// GlobalId.
        global_id: String,
        /// The later file.
        file: String,
    },
}
