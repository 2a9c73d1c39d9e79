//! Failures of services, and errors as one line of text.

/// Why a service could not handle an event; its earlier output stays valid.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

pub use bus::chain;
