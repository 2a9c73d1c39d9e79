//! The documents of the page, made of those that robots get: what does not change with the date once, and what does for each date.

mod calendar;
mod date;
mod findings;
mod site;

pub(crate) use calendar::Calendar;
pub(crate) use date::{DateDocument, DateHead, Published, StoreyAtDate};
pub(crate) use findings::Findings;
pub(crate) use site::{DateStop, SiteDocument, SiteHead, Storey};
