//! Texts in frames.

/// Bytes of the longest text of a frame.
pub(super) const MAX_TEXT_BYTES: usize = 4096;

/// As much of a text as fits.
pub(super) fn text_bytes(text: &str) -> &[u8] {
    &text.as_bytes()[..text.floor_char_boundary(MAX_TEXT_BYTES)]
}
