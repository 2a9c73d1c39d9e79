//! The rules of a robot that shows a site which another machine draws, for the daemon and for simulations of a site.

mod archive_folder;
mod fetcher;
mod file_folder;
mod outputs;
mod plan_set;
pub mod service;
