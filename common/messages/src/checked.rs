//! Archives that were validated once, each with its kind as a type.

use crate::archive::{ArchiveBuffer, ArchiveError};
use crate::content_hash::ContentHash;
use crate::payload::Payload;
use std::fmt;
use std::marker::PhantomData;

/// An archive that was validated once, with the memory that it lies in: viewed as often as needed, never hashed again.
///
/// `B` must return the same bytes each time it is asked.
pub struct Checked<P, B = ArchiveBuffer> {
    bytes: B,
    payload: PhantomData<fn() -> P>,
}

impl<P: Payload, B: AsRef<[u8]>> Checked<P, B> {
    /// Validates an archive.
    ///
    /// # Errors
    /// Bytes that are no whole archive of this kind.
    pub fn new(bytes: B) -> Result<Self, ArchiveError> {
        P::open(bytes.as_ref())?;
        Ok(Self { bytes, payload: PhantomData })
    }

    /// The view. It finds the sections, which takes about a microsecond.
    ///
    /// # Panics
    /// If the memory does not hold what was validated.
    pub fn view(&self) -> P::View<'_> {
        P::view(self.bytes.as_ref()).expect("the archive was validated, and its memory stays as it is")
    }

    /// The memory.
    pub fn bytes(&self) -> &B {
        &self.bytes
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> ContentHash {
        crate::archive::content_hash_of(self.bytes.as_ref())
    }

    /// The memory, given up.
    pub fn into_bytes(self) -> B {
        self.bytes
    }
}

impl<P, B: AsRef<[u8]>> AsRef<[u8]> for Checked<P, B> {
    fn as_ref(&self) -> &[u8] {
        self.bytes.as_ref()
    }
}

impl<P: Payload, B> fmt::Debug for Checked<P, B> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Checked").field("kind", &P::KIND).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ArchiveWriter, ScheduleState, ScheduleStateBuilder, payload};

    #[test]
    fn a_checked_archive_is_viewed_again_without_its_hash() {
        let builder = ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), 2, 1);
        let checked = Checked::<payload::ScheduleState>::new(builder.to_buffer()).unwrap();
        let whole = ScheduleState::open(checked.bytes().bytes()).unwrap();
        assert_eq!((checked.view().n_elements(), checked.content_hash()), (2, whole.content_hash()));
        let mut damaged = builder.to_buffer();
        let last = damaged.bytes().len() - 1;
        damaged.bytes_mut()[last] ^= 1;
        assert!(Checked::<payload::ScheduleState>::new(damaged).is_err());
        assert!(
            Checked::<payload::MissionPlan>::new(builder.to_buffer()).is_err(),
            "a schedule state is no mission plan"
        );
    }

    #[test]
    fn a_writer_writes_every_byte_and_returns_the_hash() {
        let builder = ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), 2, 1);
        let mut memory = ArchiveBuffer::zeroed(builder.length());
        memory.bytes_mut().fill(0xAA);
        let hash = builder.write(memory.bytes_mut());
        assert_eq!(memory.bytes(), builder.to_buffer().bytes());
        assert_eq!(ScheduleState::open(memory.bytes()).unwrap().content_hash(), hash);
    }
}
