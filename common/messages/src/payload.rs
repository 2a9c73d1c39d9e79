//! The kinds of archives as types: the payload of a topic, the result of a writer.

use crate::archive::ArchiveError;
use crate::archive_kind::{ArchiveKind, every_kind};
use crate::section::Section;

/// A kind of archive.
pub trait Payload: 'static {
    /// Its number in the preamble.
    const KIND: ArchiveKind;

    /// How its bytes are read in place.
    type View<'a>: Copy;

    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole archive of this kind.
    fn open(bytes: &[u8]) -> Result<Self::View<'_>, ArchiveError>;

    /// Views an archive whose hash and records were validated before; sections are looked up, nothing else is.
    ///
    /// # Errors
    /// Bytes that are no archive of this kind.
    fn view(bytes: &[u8]) -> Result<Self::View<'_>, ArchiveError>;

    /// Its sections, in the order in which they are written.
    fn sections() -> Vec<Section>;
}

macro_rules! payloads {
    ($($(#[$doc:meta])* $kind:ident = $number:literal $name:literal,)*) => {
        $($(#[$doc])* #[derive(Debug)] pub enum $kind {})*

        impl ArchiveKind {
            /// Validates an archive of this kind.
            ///
            /// # Errors
            /// Bytes that are no whole archive of this kind.
            pub fn check(self, bytes: &[u8]) -> Result<(), ArchiveError> {
                match self {
                    $(Self::$kind => $kind::open(bytes).map(drop),)*
                }
            }

            /// Its sections, in the order in which they are written.
            pub fn sections(self) -> Vec<Section> {
                match self {
                    $(Self::$kind => $kind::sections(),)*
                }
            }
        }
    };
}
every_kind!(payloads);
