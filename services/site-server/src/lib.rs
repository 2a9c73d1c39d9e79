//! The rules of a server that gives a site to its robots, for the daemon and for simulations.

mod enabling;
mod exports;
mod giver;
pub mod later_sets;
pub mod pieces;
pub mod publication;
mod robots;
pub mod service;
