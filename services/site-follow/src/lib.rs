//! The rules of a robot that shows a site which another machine draws, for the daemon and for simulations of a site.

pub mod archive_folder;
pub mod fetcher;
mod file_folder;
mod observer;
mod outputs;
mod plan_set;
pub mod service;
mod teller;
