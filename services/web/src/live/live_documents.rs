//! Documents of a set of samples that belong together.

use super::content_names::{model_name, tiles_name};
use crate::documents::{DateDocument, DateHead, DateStop, Published, SiteDocument, SiteHead, StoreyAtDate};
use crate::source::{Bytes, json};
use crate::tiles::{Layer, TileGrid};
use answers::changes::Calendar;
use answers::optional_date_text;
use daemon::{Failure, SiteConfig, chain};
use export::{ExportInput, Manifest, Report, Semantic, SiteGraph, Waypoints, status_of};
use raster::Rasterizer;
use schedule::Timeline;
use site_schedule::schedule_in_force;
use site_view::{SiteSet, SiteViews};
use std::collections::BTreeMap;
use tracing::warn;

/// `site.json` and `calendar.json`, and the schedule that they are of.
pub(super) struct MadeSite {
    pub(super) head: SiteHead,
    pub(super) site: Bytes,
    pub(super) calendar: Bytes,
    /// The schedule in force; `None` while it is not known here.
    pub(super) timeline: Option<Timeline>,
}

/// The documents of the site, without those of a date.
///
/// # Errors
/// Samples of different sites, maps or waypoints that are not there yet.
pub(super) fn site_documents(config: &SiteConfig, set: &SiteSet<'_>) -> Result<MadeSite, Failure> {
    let views = set.views()?;
    let SiteViews { site, state, index, grids, mission_plan } = &views;
    let mission_plan = mission_plan.as_ref().ok_or("there are no waypoints yet")?;
    let resolution_m = grids.first().map_or(config.robot.resolution_m, |grid| grid.spec().resolution_m());
    // Footprints are not on the bus: cutting gives the same again.
    let cut = Rasterizer::new(site, &index.head.robot, resolution_m)?;
    let footprints: Vec<_> = (0..grids.len()).map(|k| cut.footprints(k)).collect();
    let input = ExportInput {
        footprints: &footprints,
        ..ExportInput::of_maps(site, state, index, grids, mission_plan).ok_or("there are no maps yet")?
    };
    let published = published(&input)?;
    let manifest = serde_json::to_value(Manifest::of(&input, BTreeMap::new()))?;
    let head = SiteHead { live: true, control: config.web.allow_control, ..SiteHead::of_manifest(&manifest)? };
    let timeline = match schedule_in_force(config, site, state) {
        Ok(schedule) => Some(schedule.timeline),
        Err(why) => {
            warn!(
                service = "groundplan-web",
                error = chain(&why),
                "the page has no other dates: the schedule in force is not known"
            );
            None
        }
    };
    let instants_s = timeline.as_ref().map_or(&[][..], Timeline::instants_s);
    let stop = |(k, at_s): (usize, &i64)| DateStop {
        key: None,
        at: optional_date_text(*at_s),
        until: instants_s.get(k + 1).and_then(|until_s| optional_date_text(*until_s)),
    };
    let mut stops: Vec<DateStop> = instants_s.iter().enumerate().map(stop).collect();
    if stops.is_empty() {
        // Of a schedule that is not known the date that is shown is.
        let [at, until] = [state.head.plan_time_s, state.head.valid_until_s].map(optional_date_text);
        stops.push(DateStop { key: None, at, until });
    }
    Ok(MadeSite {
        site: json(&SiteDocument::of(&head, &stops, published)?),
        calendar: json(&timeline.as_ref().map(|known| Calendar::of_schedule(site, known)).unwrap_or_default()),
        head,
        timeline,
    })
}

/// `dates/KEY.json`, for tiles that lie so and a model with the site's options.
///
/// # Errors
/// Samples of different sites.
pub(super) fn date_document(
    key: &str,
    config: &SiteConfig,
    tiles: &TileGrid,
    set: &SiteSet<'_>,
) -> Result<Bytes, Failure> {
    let views = set.views()?;
    let SiteViews { site, state, index, grids, mission_plan } = &views;
    let mission_plan = mission_plan.as_ref().ok_or("there are no waypoints yet")?;
    let input = ExportInput::of_maps(site, state, index, grids, mission_plan).ok_or("there are no maps yet")?;
    let storeys = grids.iter().map(|grid| StoreyAtDate {
        index: grid.head.map_storey,
        status: status_of(grid).to_owned(),
        layers: Layer::ALL.into_iter().map(|layer| (layer.name(), tiles_name(layer, grid, tiles))).collect(),
    });
    let head = DateHead {
        key: key.to_owned(),
        at: optional_date_text(state.head.plan_time_s),
        until: optional_date_text(state.head.valid_until_s),
        storeys: storeys.collect(),
        model: Some(model_name(config, set)),
    };
    Ok(json(&DateDocument::of(head, published(&input)?)))
}

/// The documents that robots get.
fn published(input: &ExportInput<'_>) -> Result<Published, Failure> {
    Ok(Published {
        semantic: serde_json::to_value(Semantic::of(input))?,
        waypoints: serde_json::to_value(Waypoints::of(input))?,
        site_graph: serde_json::to_value(SiteGraph::of(input))?,
        report: serde_json::to_value(Report::of(input))?,
    })
}
