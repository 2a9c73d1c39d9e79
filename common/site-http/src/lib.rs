//! Parts of the HTTP servers of a site: a listener with its limits, admission, tokens.
//!
//! The page of a site and its answers to questions are served alike: on the machine itself for whoever reaches it there, elsewhere
//! for holders of a token, of which only the sha256 is stored; by https where the configuration names a certificate.
//!
//! # Guarantees
//!
//! - Heads and bodies of requests have their time ([`REQUEST_TIMEOUT`]), bodies their length ([`read_whole`]), connections their
//!   number; whoever is one too many is told so ([`tell_one_too_many`]).
//! - An address that cannot be had is no reason to end: [`Listening`] tries again whenever it is told to keep up.
//! - Tokens are compared whole, however early they differ. A certificate or key is read up to a limit, and never from a pipe.

mod access;
mod connections;
mod listening;
mod request_body;
mod server;
mod token;

pub use access::{Access, bearer_token, host_of, is_own_name};
pub use connections::tell_one_too_many;
pub use listening::{Listening, ListeningFor};
pub use request_body::{BodyLimit, REQUEST_TIMEOUT, read_whole};
pub use server::{MAX_CONNECTIONS, ServeError, Server, ServerSettings};
pub use token::{TokenError, access_of};
