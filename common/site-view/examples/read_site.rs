//! A robot's program: the maps of a running site that belong together, read in place, whether they may be used, and which rooms
//! are closed. It prints a line for each set.
//!
//! ```text
//! groundplan up                                 # in another terminal
//! cargo run --example read_site                 # the bus of a machine: /run/groundplan
//! cargo run --example read_site -- ROOT PREFIX  # another one, as [bus] of its site.toml has it
//! ```

use bus::{Bus, Daemon, Domain, Stamp};
use site_view::{ClockTime, MapRule, MapVerdict, SiteSet, SiteSetReader};
use std::error::Error;
use std::io::Write;
use std::time::Duration;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (root, prefix) = match &arguments[..] {
        [] => (Domain::DEFAULT_ROOT, Domain::DEFAULT_PREFIX),
        [root, prefix] => (root.as_str(), prefix.as_str()),
        _ => return Err("usage: read_site [ROOT PREFIX]".into()),
    };
    // Programs beside the daemons join as clients, of which there may be several.
    let (bus, mut waiter) = Bus::join(&Domain::shared(prefix, root)?, Daemon::Groundplan)?;
    let mut reader = SiteSetReader::of(&bus)?;
    let heartbeats = bus.status_reader()?;
    let mut rule = MapRule::default();
    rule.joined(Stamp::now());
    let mut shown = None;
    loop {
        reader.take()?;
        while let Some(record) = heartbeats.take()? {
            Daemon::from_id(record.daemon).into_iter().for_each(|daemon| rule.insert_heartbeat(Stamp::now(), daemon));
        }
        if let Some(newest) = reader.state() {
            rule.insert_schedule_state(Stamp::now(), newest.state.content_hash(), newest.state.view().head);
        }
        if let Some(set) = reader.set().filter(|set| shown != Some(set.index.content_hash())) {
            rule.insert_index(Stamp::now(), set.index.view().head, true);
            shown = Some(set.index.content_hash());
            writeln!(std::io::stdout(), "{}", line(&set)?)?;
        }
        // Ask before each use: a daemon that falls silent makes no sample.
        let verdict = rule.verdict(Stamp::now(), ClockTime::Unknown);
        if shown.is_some() && !matches!(verdict, MapVerdict::Current | MapVerdict::Overtaken) {
            writeln!(std::io::stdout(), "stand still: {verdict:?}")?;
        }
        let wake = waiter.wait(Duration::from_secs(1))?;
        if wake.stopped || wake.superseded {
            return Ok(());
        }
    }
}

/// What a set shows.
fn line(set: &SiteSet<'_>) -> Result<String, Box<dyn Error>> {
    let views = set.views()?;
    let n_cells: usize = views.grids.iter().map(|grid| grid.planning.iter().filter(|&&value| value == 0).count()).sum();
    let closed = (0..views.site.spaces.len()).filter(|&space| views.state.is_blocked(space));
    let names: Vec<&str> = closed.map(|space| views.site.text(views.site.spaces[space].name)).collect();
    let plan_time = views.state.head.plan_time().map_or("everything built".to_owned(), |at| at.to_string());
    let n_grids = views.grids.len();
    Ok(format!("{plan_time}: {n_grids} maps, {n_cells} free cells, closed: {}", names.join(" ")))
}
