//! What a server publishes of a site, for the daemon and for simulations of its robots.

mod enabling;
mod exports;
mod giver;
pub mod later_sets;
pub mod pieces;
pub mod publication;
mod robots;
pub mod service;
