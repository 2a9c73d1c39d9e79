//! Answers about the maps that a running site shows.

use crate::question::Question;
use crate::source::SourceError;
use answers::MapUse;
use schedule::Timeline;
use site_answers::{circumstances_of, situation_of};
use site_view::SiteSet;

/// The answer of a set of maps.
///
/// # Errors
/// Names that stand for nothing; maps without a mission plan; samples of different sites.
pub(super) fn answer(
    question: &Question,
    set: &SiteSet<'_>,
    timeline: Option<&Timeline>,
    maps: MapUse,
) -> Result<Vec<u8>, SourceError> {
    let views = set.views().map_err(|why| SourceError::Live(why.into()))?;
    let circumstances = circumstances_of(set, &views, maps);
    let situation = situation_of(&views, timeline, &circumstances).ok_or(SourceError::NotYet)?;
    Ok(question.answer(&situation)?)
}
