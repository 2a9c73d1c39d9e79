//! What shows a site that another machine draws: its rules, for the daemon and for simulations of a site.

mod archive_folder;
mod fetcher;
mod outputs;
mod plan_set;
pub mod service;
