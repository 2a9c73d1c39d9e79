//! Prints the dates that the evaluation gives the tasks of a schedule file: a line each with name, start, finish and total float in
//! seconds, between tabs.
//!
//! usage: plan_dates FILE
#![expect(clippy::print_stdout, reason = "an example program")]

use messages::{Site, SiteBuilder, Tasks, plan_time};
use schedule::{Overrides, Rules, evaluate};
use schedule_files::ReadOptions;
use tasks::{LinkRules, Links, ScheduleFile, tasks_of};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: plan_dates FILE")?;
    let plans = [ScheduleFile::read(&path, &std::fs::read(&path)?, &ReadOptions::default())?];
    let site = SiteBuilder::default().finish();
    let site = Site::open(site.bytes())?;
    let archive = tasks_of(&site, &plans, &LinkRules::default(), &Links::default()).finish();
    let tasks = Tasks::open(archive.bytes())?;
    let timeline = evaluate(&site.with_tasks(&tasks)?, &Rules::default(), &Overrides::default())?;
    for (k, task) in plans[0].plan.tasks.iter().enumerate() {
        let at = |s: i64| plan_time(s).map(|at| at.to_string()).unwrap_or_default();
        let dates = timeline.task(k).map(|dates| [at(dates.start_s), at(dates.finish_s)]).unwrap_or_default();
        let float = timeline.float(k).map(|float| float.total_s.to_string()).unwrap_or_default();
        println!("{}\t{}\t{float}", task.name, dates.join("\t"));
    }
    Ok(())
}
