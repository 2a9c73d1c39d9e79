//! Enumerations as they lie in records: checked once, when the archive is opened.

use crate::archive::ArchiveError;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use std::fmt;
use std::marker::PhantomData;

/// An enumeration that archives store as a number.
pub trait Enumeration: CheckedBitPattern<Bits: Pod> + NoUninit + fmt::Debug + 'static {}

impl<E: CheckedBitPattern<Bits: Pod> + NoUninit + fmt::Debug + 'static> Enumeration for E {}

/// The number of a variant of `E` in a record.
///
/// It is made from a variant. Only bytes from outside can hold another number, and an archive with one is refused when it is
/// opened: see [`Tag::is_known`].
pub type Tag<E> = TagOf<<E as CheckedBitPattern>::Bits, PhantomData<E>>;

/// [`Tag`] by the type of its number and a marker of its enumeration: what is plain data for any of both.
#[derive(Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(transparent)]
pub struct TagOf<Bits, Marker>(Bits, PhantomData<Marker>);

impl<Bits: Copy, Marker> TagOf<Bits, Marker> {
    /// The tag with this number, for constants.
    pub(crate) const fn numbered(number: Bits) -> Self {
        Self(number, PhantomData)
    }
}

impl<E: Enumeration> Tag<E> {
    /// The variant.
    ///
    /// # Panics
    /// If there is none with this number, which is so only in records that were not read from an archive.
    pub fn get(self) -> E {
        self.known().expect("an archive with an unknown number is refused when it is opened")
    }

    /// The variant with this number, if there is one.
    pub fn known(self) -> Option<E> {
        bytemuck::checked::try_cast(self.0).ok()
    }

    /// True if there is a variant with this number.
    pub fn is_known(self) -> bool {
        E::is_valid_bit_pattern(&self.0)
    }
}

impl<E: Enumeration> From<E> for Tag<E> {
    fn from(variant: E) -> Self {
        Self(bytemuck::cast(variant), PhantomData)
    }
}

impl<E: Enumeration> PartialEq<E> for Tag<E> {
    fn eq(&self, variant: &E) -> bool {
        bytemuck::bytes_of(&self.0) == bytemuck::bytes_of(variant)
    }
}

impl<E: Enumeration> fmt::Debug for Tag<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.known() {
            Some(variant) => variant.fmt(f),
            None => write!(f, "unknown {:?}", bytemuck::bytes_of(&self.0)),
        }
    }
}

/// Checks the tags of an archive.
pub(crate) fn check_tags<E: Enumeration>(
    tags: impl IntoIterator<Item = Tag<E>>,
    what: &'static str,
) -> Result<(), ArchiveError> {
    if tags.into_iter().all(Tag::is_known) { Ok(()) } else { Err(ArchiveError::Unknown { what }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ElementState, SequenceKind};

    #[test]
    fn a_tag_is_its_variant_or_unknown() {
        let tag = Tag::from(SequenceKind::FinishStart);
        assert_eq!((tag.get(), tag.is_known()), (SequenceKind::FinishStart, true));
        assert!(tag == SequenceKind::FinishStart && tag != SequenceKind::StartStart);
        for number in [0, 5, u32::MAX] {
            let unknown = Tag::<SequenceKind>::numbered(number);
            assert_eq!((unknown.known(), unknown.is_known()), (None, false));
        }
        assert_eq!(format!("{tag:?} {:?}", Tag::<SequenceKind>::numbered(9)), "FinishStart unknown [9, 0, 0, 0]");
    }

    #[test]
    fn one_byte_is_enough_for_states_of_elements() {
        let tags: &[Tag<ElementState>] = bytemuck::cast_slice(&[0u8, 4, 5]);
        assert_eq!(tags.iter().map(|t| t.is_known()).collect::<Vec<_>>(), [true, true, false]);
        assert_eq!(tags[1].get(), ElementState::Removed);
    }
}
