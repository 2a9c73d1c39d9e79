//! Prints a schedule file as JSON, and what is wrong with it to standard error: `dump_plan PLAN.xer`.

#[path = "../tests/plan_json/mod.rs"]
mod plan_json;

use schedule_files::ReadOptions;
use std::error::Error;
use std::io::Write;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: dump_plan FILE")?;
    let file = schedule_files::read(&path, &std::fs::read(&path)?, &ReadOptions::default())?;
    for finding in &file.findings {
        let task = finding.task.map_or("", |task| &file.tasks[task].name);
        writeln!(std::io::stderr(), "{:?} {task:?}: {}", finding.kind, finding.message)?;
    }
    writeln!(std::io::stdout(), "{}", plan_json::plan_json(&file))?;
    Ok(())
}
