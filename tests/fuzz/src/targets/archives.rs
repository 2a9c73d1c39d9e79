//! Archives of every kind, changed, cut and with a hash that fits again: refused, or read to the end.

#[path = "../../../../common/messages/tests/support/mod.rs"]
mod support;

pub(super) use support::reseal;

use messages::ArchiveBuffer;
use std::sync::LazyLock;

/// One whole archive of each kind.
static WHOLE: LazyLock<Vec<ArchiveBuffer>> = LazyLock::new(support::every_archive);

/// The first byte chooses the archive; the rest are changes to it, or, for any other choice, the archive itself.
pub fn run(bytes: &[u8]) {
    let Some((&choice, bytes)) = bytes.split_first() else { return };
    let mut buffer = match WHOLE.get(usize::from(choice)) {
        Some(whole) => whole.clone(),
        None => ArchiveBuffer::copy_of(bytes),
    };
    if usize::from(choice) < WHOLE.len() {
        change(&mut buffer, bytes);
    }
    support::walk(buffer.bytes());
    reseal(buffer.bytes_mut());
    support::walk(buffer.bytes());
}

/// Applies changes of six bytes each: the index of a word, and its new value. A last change of less than six bytes cuts the
/// archive off at that many words.
pub(super) fn change(buffer: &mut ArchiveBuffer, changes: &[u8]) {
    let (changes, rest) = changes.as_chunks::<6>();
    let n_words = buffer.bytes().len() / 4;
    for [low, high, word @ ..] in changes {
        let at = usize::from(u16::from_le_bytes([*low, *high])) % n_words * 4;
        buffer.bytes_mut()[at..at + 4].copy_from_slice(word);
    }
    if let [low, high, ..] = *rest {
        let cut = usize::from(u16::from_le_bytes([low, high])) % n_words * 4;
        *buffer = ArchiveBuffer::copy_of(&buffer.bytes()[..cut]);
    }
}
