//! Failures of services, and errors as one line of text.

/// Why a service could not handle an event; its earlier output stays valid.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// An error with its causes.
pub fn chain(error: &(dyn std::error::Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text = format!("{text}: {error}");
        cause = error.source();
    }
    text
}
