//! One view of a site: which samples of the bus belong together.
//!
//! Samples of different topics come in any order. [`SiteSamples`] holds the newest of each topic, and gives the
//! [`SiteSet`] of those that belong together; a [`SiteSetReader`] follows the topics for it.

mod site_set;
mod site_set_reader;

pub use site_set::{SiteSample, SiteSamples, SiteSet, SiteState, SiteViews};
pub use site_set_reader::{SiteSetError, SiteSetReader};
