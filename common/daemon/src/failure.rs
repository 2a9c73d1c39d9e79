//! Failures of services, and errors as one line of text.

use std::borrow::Borrow;

/// Why a service could not handle an event; its earlier output stays valid.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

pub use bus::chain;

/// Sentences as one text; `None` without any.
pub fn joined<S: Borrow<str>>(sentences: impl IntoIterator<Item = S>) -> Option<String> {
    let sentences: Vec<S> = sentences.into_iter().collect();
    (!sentences.is_empty()).then(|| sentences.join("; "))
}
