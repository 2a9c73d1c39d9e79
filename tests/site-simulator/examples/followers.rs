//! Many robots that follow a site, each up to its bus, in one process: `scripts/bench-fleet` measures a server with them.
//!
//! usage: followers SITE.toml.. Each is the configuration of a robot with `[follow]`. A line of JSON on the standard output for each index
//! that a robot shows; once the standard input ends, one of what each has on its disk, checked by its sha256.

#![expect(clippy::print_stdout, reason = "it is what a script reads")]

use daemon::{CurrentActivity, Event, Failure, MachineClock, Service, SiteConfig};
use messages::ContentId;
use serde_json::json;
use site_follow::archive_folder::MachineDisk;
use site_follow::service::{SiteFollow, Surroundings};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use store::{Credentials, Objects, Store};

/// While a robot waits it looks this often whether the end has come.
const LOOK_INTERVAL: Duration = Duration::from_millis(100);

fn main() -> Result<(), Failure> {
    let ends = Arc::new(AtomicBool::new(false));
    let mut robots = Vec::new();
    for path in std::env::args().skip(1) {
        let config = SiteConfig::read(Path::new(&path))?;
        let ends = Arc::clone(&ends);
        let robot = move || follow(&path, &config, &ends).map_err(|why| daemon::chain(why.as_ref()));
        robots.push(std::thread::Builder::new().name("robot".to_owned()).spawn(robot)?);
    }
    std::io::stdin().read_to_end(&mut Vec::new())?;
    ends.store(true, Ordering::Relaxed);
    for robot in robots {
        robot.join().map_err(|_| "a robot panicked")??;
    }
    Ok(())
}

/// One robot, until the end.
fn follow(name: &str, config: &SiteConfig, ends: &AtomicBool) -> Result<(), Failure> {
    let follow = config.follow.clone().ok_or("there is no [follow]")?;
    let open = move || -> Result<Box<dyn Objects>, Failure> {
        let credentials = follow.credentials.as_deref().map(Credentials::read).transpose()?;
        Ok(Box::new(Store::open_to_read(&follow.store, &credentials.unwrap_or_default())?))
    };
    let clock = Box::new(MachineClock::of_this_boot());
    let surroundings = Surroundings { open: Box::new(open), clock, disk: Arc::new(MachineDisk) };
    let (mut service, mut fetcher) = SiteFollow::within(config, CurrentActivity::default(), surroundings)?;
    let mut shown = None;
    while !ends.load(Ordering::Relaxed) {
        let mut left = fetcher.step();
        let done = service.handle(Event::Tick);
        let facts = service.facts();
        let error = done.err().map(|why| daemon::chain(why.as_ref())).or(service.standing().error);
        let now = (facts.epoch, facts.schedule.state_plan_time_s, error);
        if shown.as_ref() != Some(&now) {
            let told = json!({
                "robot": name, "epoch": now.0, "plan_time_s": now.1, "error": now.2, "fetched_bytes": facts.fetched_bytes,
            });
            println!("{told}");
            shown = Some(now);
        }
        while !left.is_zero() && !ends.load(Ordering::Relaxed) {
            let now = left.min(LOOK_INTERVAL);
            std::thread::sleep(now);
            left -= now;
        }
    }
    let (mut n_archives, mut n_wrong) = (0, 0);
    for file in std::fs::read_dir(config.state.join("followed-archives"))? {
        let path = file?.path();
        if path.extension().is_none() {
            n_archives += 1;
            let id = ContentId::of(&std::fs::read(&path)?).to_string();
            n_wrong += i32::from(!path.ends_with(id));
        }
    }
    let facts = service.facts();
    let told = json!({
        "robot": name, "at_end": true, "epoch": facts.epoch, "fetched_bytes": facts.fetched_bytes,
        "state": facts.schedule.state.content_hash.to_string(), "archives": n_archives, "wrong": n_wrong,
    });
    println!("{told}");
    Ok(())
}
