//! Answers about the maps that a running site shows.

use crate::question::Question;
use crate::source::SourceError;
use answers::{Circumstances, Epochs, MapUse, Situation};
use bus::CheckedSample;
use schedule::Timeline;
use site_view::{SiteSet, SiteViews};

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
    let SiteViews { site, state, index, grids, mission_plan } = &views;
    let mission_plan = mission_plan.as_ref().ok_or(SourceError::NotYet)?;
    let epochs = Epochs {
        site: set.site.bytes().header().epoch,
        schedule_state: set.state.bytes().header().epoch,
        grids: set.index.bytes().header().epoch,
        mission_plan: set.mission_plan.map(CheckedSample::bytes).map_or(0, |sample| sample.header().epoch),
    };
    let resolution_m = grids.first().map(|grid| grid.spec().resolution_m());
    let circumstances = Circumstances::of_running(site, state, index, resolution_m, (epochs, maps));
    let situation =
        Situation { site, schedule_state: state, index, grids, mission_plan, timeline, circumstances: &circumstances };
    Ok(question.answer(&situation)?)
}
