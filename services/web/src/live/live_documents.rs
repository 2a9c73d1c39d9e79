//! Documents of a set of samples that belong together.

use super::content_names::{model_name, tiles_name};
use crate::documents::{
    DateDocument, DateHead, DateStop, FreeCells, Published, SiteDocument, SiteHead, StoreyAtDate, SummaryDocument,
    TasksDocument,
};
use crate::source::{Bytes, json};
use crate::tiles::{Layer, TileGrid};
use answers::changes::Calendar;
use answers::optional_date_text;
use answers::tasks::{list, progress};
use daemon::{Failure, SiteConfig, chain};
use export::{ExportInput, Manifest, Report, Semantic, SiteGraph, Waypoints, status_of};
use grid::pixel_of;
use messages::Grid;
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
    pub(super) tasks: TasksDocument,
    /// The schedule in force; `None` while it is not known here.
    pub(super) timeline: Option<Timeline>,
}

/// `dates/KEY.json` and `summary/KEY.json`.
pub(super) struct MadeDate {
    pub(super) date: Bytes,
    pub(super) summary: Bytes,
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
    let schedule = match schedule_in_force(config, site, state) {
        Ok(schedule) => Some(schedule),
        Err(why) => {
            warn!(
                service = "groundplan-web",
                error = chain(&why),
                "the page has no other dates: the schedule in force is not known"
            );
            None
        }
    };
    let tasks = match &schedule {
        Some(known) => {
            let planned = known.planned.as_ref().unwrap_or(&known.timeline);
            let progress = progress(site, planned, &known.reported, &known.observed)?;
            TasksDocument::of_schedule(&list(site, &known.timeline, None, None), &progress)?
        }
        None => TasksDocument::of_elements(&published.semantic),
    };
    let timeline = schedule.map(|known| known.timeline);
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
        tasks,
        timeline,
    })
}

/// The documents of a date, for tiles that lie so, these tasks, and a model with the site's options.
///
/// # Errors
/// Samples of different sites.
pub(super) fn date_documents(
    key: &str,
    config: &SiteConfig,
    (tiles, tasks): (&TileGrid, &TasksDocument),
    set: &SiteSet<'_>,
) -> Result<MadeDate, Failure> {
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
    let published = published(&input)?;
    let n_free = |grid: &Grid<'_>| grid.planning.iter().filter(|cell| pixel_of(**cell) == pixel_of(0)).count();
    let free = FreeCells {
        resolution_m: grids.first().map_or(0.0, |grid| grid.spec().resolution_m()),
        n_free: grids.iter().map(|grid| (grid.head.map_storey, n_free(grid))).collect(),
    };
    let summary = json(&SummaryDocument::of(&published, &free, tasks, head.at.as_deref()));
    Ok(MadeDate { date: json(&DateDocument::of(head, published)), summary })
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
