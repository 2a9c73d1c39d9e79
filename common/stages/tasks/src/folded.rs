//! Texts as they are compared.

/// A text as it is compared: without spaces around it, in lower case.
pub(crate) fn fold(text: &str) -> String {
    text.trim().to_lowercase()
}
