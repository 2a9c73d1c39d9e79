//! What the running daemons know: tables of progress in force, who confirmed absences, deviations of the newest comparison.

use super::gathered::{Gathered, Row};
use super::observations::SiteOfModel;
use crate::commands::deviations::with_newest;
use crate::failure::Failure;
use crate::wait::{ask, join};
use as_built::sha256_hex;
use bus::{Bus, Waiter};
use daemon::{AlignAnswer, AlignRequest, Confirmed, SiteConfig, progress_in_force, rules_in_force};
use export::{DeviationExport, DeviationsDocument, json_text};
use frames::PlanTime;
use input_files::{MAX_CONFIGURATION_BYTES, read_regular_text};
use jiff::tz::TimeZone;
use messages::{Site, plan_time};
use schedule::{ABSENT, Actual, OverrideError, Rules, parse_actuals};
use site_view::SiteSetReader;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Timeout of a site that is on its way.
const SITE_TIMEOUT: Duration = Duration::from_secs(30);
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Works with the site, and all that its daemons know. `needs_deviations`: without deviations nothing is done.
///
/// # Errors
/// No daemons, a site that does not have this model, progress that cannot be read; those of the work.
pub(super) fn with_site<T>(
    config: &SiteConfig,
    model: &[u8],
    rules: Option<&Path>,
    needs_deviations: bool,
    work: impl FnOnce(&SiteOfModel<'_>, &Gathered) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let (bus, mut waiter) = join(config)?;
    let rules = match rules {
        Some(path) => {
            let failed = |error: String| Failure::usage(format!("{}: {error}", path.display()));
            let text = read_regular_text(path, MAX_CONFIGURATION_BYTES).map_err(|error| failed(error.to_string()))?;
            Rules::parse(&text).map_err(|error| failed(error.to_string()))?
        }
        None => rules_in_force(config, Rules::parse).map_err(Failure::work)?,
    };
    let mut gathered = Gathered { is_of_running_site: true, ..Gathered::default() };
    add_progress(&mut gathered, config, &rules, &bus, &mut waiter)?;
    match deviations(&bus, &mut waiter) {
        Ok(document) => gathered.add_compared("deviations of the site", &document).map_err(Failure::work)?,
        Err(why) if needs_deviations => return Err(why),
        Err(why) => eprintln!("groundplan: no deviations are written: {why:#}"),
    }
    with_newest_site(&bus, &mut waiter, |site| {
        let source = site.sources.iter().position(|source| hex(source.sha256) == sha256_hex(model));
        let Some(source) = source else {
            let names: Vec<&str> = site.sources.iter().map(|source| site.text(source.file)).collect();
            return Err(Failure::usage(format!(
                "the model is none of the files that the site has loaded ({}): load it, or give --actuals and --deviations",
                names.join(", ")
            )));
        };
        work(&SiteOfModel { site, source: source as u32, rules: &rules }, &gathered)
    })
}

fn hex(sha256: [u8; 32]) -> String {
    sha256.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Works with the newest site.
fn with_newest_site<T>(
    bus: &Bus,
    waiter: &mut Waiter,
    work: impl FnOnce(&Site<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let mut states = SiteSetReader::of_states(bus).map_err(Failure::work)?;
    let begun = Instant::now();
    loop {
        states.take().map_err(Failure::work)?;
        if let Some(state) = states.state() {
            let (site, _) = state.views().map_err(Failure::work)?;
            return work(&site);
        }
        if begun.elapsed() > SITE_TIMEOUT {
            return Err(Failure::work("the site has not come: see groundplan status"));
        }
        waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
    }
}

/// The document of the newest deviations.
fn deviations(bus: &Bus, waiter: &mut Waiter) -> Result<Vec<u8>, Failure> {
    with_newest(bus, waiter, |site, schedule_state, found| {
        // Topics have a creation date, the document has not.
        let created = messages::plan_time(found.head.plan_time_s).unwrap_or(PlanTime::LAST);
        Ok(json_text(&DeviationsDocument::of(&DeviationExport { site, schedule_state, deviations: found, created })))
    })
}

/// A row, and the table in which it stands.
type RowOfTable = (Actual, Arc<[u8]>);

/// The tables in force: observations, then reports, which rank before them.
fn add_progress(
    gathered: &mut Gathered,
    config: &SiteConfig,
    rules: &Rules,
    bus: &Bus,
    waiter: &mut Waiter,
) -> Result<(), Failure> {
    let with_hash = |bytes: &[u8]| {
        let table: Arc<[u8]> = bytes.into();
        Ok::<Vec<RowOfTable>, OverrideError>(
            parse_actuals(bytes)?.into_iter().map(|actual| (actual, Arc::clone(&table))).collect(),
        )
    };
    let [reported, observed] = progress_in_force(config, with_hash).map_err(Failure::work)?;
    let confirmed = match observed.iter().any(|(actual, _)| actual.start == ABSENT) {
        true => confirmations(bus, waiter, rules.site_zone.as_ref())?,
        false => BTreeMap::new(),
    };
    for (name, rows) in [("observed progress of the site", observed), ("reported progress of the site", reported)] {
        let Some((_, table)) = rows.first() else { continue };
        let source = gathered.add_source(name, table);
        for (actual, _) in rows {
            let (by, at) = confirmed.get(&actual.id).filter(|_| actual.start == ABSENT).cloned().unwrap_or_default();
            let observer = if by.is_empty() { name.to_owned() } else { format!("robot; confirmed by {by}") };
            gathered.rows.push(Row { actual, source, observer, at });
        }
    }
    Ok(())
}

/// Who confirmed which absence, and when at the site; without a zone of the site in UTC.
fn confirmations(
    bus: &Bus,
    waiter: &mut Waiter,
    zone: Option<&TimeZone>,
) -> Result<BTreeMap<String, (String, Option<PlanTime>)>, Failure> {
    let AlignAnswer::Confirmations(listed) = ask(bus, waiter, &AlignRequest::ListConfirmed)? else {
        return Err(crate::alignment_request::other_answer());
    };
    let utc = TimeZone::UTC;
    let of = |Confirmed { by, at }: &Confirmed| {
        let civil = zone.unwrap_or(&utc).to_datetime(*at);
        (by.to_string(), plan_time(PlanTime(civil).civil_seconds()))
    };
    let absent = listed.absent.iter();
    Ok(absent.filter_map(|element| Some((element.global_id.clone(), of(element.confirmed.as_ref()?)))).collect())
}
