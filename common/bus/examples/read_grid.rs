//! A subscriber: reads the grid of a storey from the running daemons, in place, and goes on with every new one.
//!
//! ```text
//! groundplan up                                   # in another terminal
//! cargo run --example read_grid -- 0              # the bus of a machine: /run/groundplan, prefix gp010_
//! cargo run --example read_grid -- 0 ROOT PREFIX  # another one, as [bus] of its site.toml has it
//! ```

use bus::{Bus, Daemon, Domain, GridSlot, topics};
use std::error::Error;
use std::io::Write;
use std::time::Duration;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (storey, root, prefix) = match &arguments[..] {
        [storey] => (storey, Domain::DEFAULT_ROOT, Domain::DEFAULT_PREFIX),
        [storey, root, prefix] => (storey, root.as_str(), prefix.as_str()),
        _ => return Err("usage: read_grid STOREY [ROOT PREFIX]".into()),
    };
    let slot = GridSlot::new(storey.parse()?).ok_or("there are grid/00 to grid/63")?;

    // Programs beside the daemons join as clients, of which there may be several.
    let (bus, mut waiter) = Bus::join(&Domain::shared(prefix, root)?, Daemon::Groundplan)?;
    let grids = bus.subscriber(topics::Grid(slot))?;
    loop {
        // The memory stays as it is while the sample is held; its content is validated once.
        if let Some(sample) = grids.take()? {
            let epoch = sample.header().epoch;
            let sample = sample.check()?;
            let grid = sample.view();
            let n_free = grid.planning.iter().filter(|&&occupancy| occupancy == 0).count();
            let free_m2 = n_free as f64 * grid.spec().resolution_m().powi(2);
            let n_keepout = grid.keepout.iter().filter(|&&value| value == 100).count();
            let (width, height) = (grid.spec().width, grid.spec().height);
            writeln!(
                std::io::stdout(),
                "epoch {epoch}: {width} x {height} cells, {free_m2:.1} m2 free, {n_keepout} keep-out"
            )?;
        }
        let wake = waiter.wait(Duration::from_secs(1))?;
        if wake.stopped || wake.superseded {
            return Ok(());
        }
    }
}
