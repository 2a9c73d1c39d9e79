//! The documents of the page, made of those that robots get: what does not change with the date once, and what does for each date.
//!
//! What a state, a finding or a change is, is said by `answers`.

mod calendar;
mod date;
mod site;
mod summary;
mod tasks;

pub(crate) use calendar::add_date;
pub(crate) use date::{DateDocument, DateHead, Published, StoreyAtDate};
pub(crate) use site::{DateStop, SiteDocument, SiteHead, Storey};
pub(crate) use summary::{FreeCells, SummaryDocument};
pub(crate) use tasks::TasksDocument;
