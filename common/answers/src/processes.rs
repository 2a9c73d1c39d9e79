//! State of the processes of a site: who runs, what it does and says, since when, and whether the maps may be used.

use crate::circumstances::MapUse;
use diagnostics::counted;
use messages::{ProcessHealth, SeenProcess};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;
use std::time::Duration;

/// A job of less time is not worth a word.
const LONG_S: f64 = 3.0;

/// A process of a site.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "ProcessStatus")]
pub struct ProcessAnswer {
    /// As of its process; documents have it as a key.
    #[serde(skip)]
    pub name: String,
    /// True if its process lives.
    pub alive: bool,
    /// Its process; 0 if it left.
    pub process_id: u32,
    /// What it was doing at its last report; `silent` without one, `hangs` if its process lives and reports nothing.
    #[serde(rename = "stage")]
    pub activity: String,
    /// Seconds since its last report; null without one.
    pub age_s: Option<f64>,
    /// How often it died and was started again.
    pub restarts: u32,
    /// Resident memory in bytes.
    pub memory_bytes: u64,
    /// Why its output is not what its inputs ask for, or what it failed to do last.
    pub error: Option<String>,
    /// What an operator should know although nothing failed.
    pub warning: Option<String>,
    /// What it works on, or worked on at its last report; null while it is idle.
    pub busy: Option<BusyAnswer>,
    /// How it is.
    #[serde(skip)]
    pub health: ProcessHealth,
    /// What is wrong with it, for people; `None` if nothing is.
    #[serde(skip)]
    wrong: Option<String>,
}

/// Work of a process.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "BusyStatus")]
pub struct BusyAnswer {
    /// The job, in words.
    pub job: String,
    /// For how long, in seconds.
    pub for_s: f64,
}

/// The processes of a site, and whether its maps may be used.
#[derive(Debug)]
pub struct ProcessesAnswer {
    /// The processes, in the order in which they were asked for.
    pub processes: Vec<ProcessAnswer>,
    /// Whether its maps may be used.
    pub maps: MapUse,
}

impl ProcessesAnswer {
    /// Of what the caller finds.
    pub fn of(seen: impl IntoIterator<Item = SeenProcess>, maps: MapUse) -> Self {
        Self { processes: seen.into_iter().map(ProcessAnswer::of).collect(), maps }
    }
}

impl ProcessAnswer {
    /// Of what the caller finds.
    pub fn of(seen: SeenProcess) -> Self {
        let (health, wrong) = seen.health();
        let wrong = wrong.map(str::to_owned);
        let SeenProcess { name, is_alive: alive, report } = seen;
        let Some(report) = report else {
            return Self {
                name,
                alive,
                process_id: 0,
                activity: "silent".to_owned(),
                age_s: None,
                restarts: 0,
                memory_bytes: 0,
                error: None,
                warning: None,
                busy: None,
                health,
                wrong,
            };
        };
        let busy = report.busy.filter(|_| alive);
        Self {
            name,
            alive,
            process_id: if alive { report.process_id } else { 0 },
            activity: match health {
                ProcessHealth::Down => "dead".to_owned(),
                ProcessHealth::Hangs => "hangs".to_owned(),
                ProcessHealth::Error | ProcessHealth::Warning | ProcessHealth::Ok => report.activity,
            },
            age_s: Some(tenths(report.age)),
            restarts: report.restarts,
            memory_bytes: report.memory_bytes,
            error: report.error,
            warning: report.warning,
            busy: busy.map(|(job, time)| BusyAnswer { job, for_s: tenths(time) }),
            health,
            wrong,
        }
    }

    /// For people, in a few words; `None` if there is nothing to tell. That it died meanwhile is not told by its health once it is
    /// back.
    pub fn words(&self) -> Option<String> {
        let restarted = || (self.restarts > 0).then(|| format!("started again: {}", self.restarts));
        self.wrong.clone().or_else(restarted)
    }

    /// For people: a line, and one for each thing that it tells.
    pub fn text(&self) -> String {
        let mut out = String::new();
        let megabytes = self.memory_bytes / 1_000_000;
        // Writing to a string does not fail.
        let _ = write!(out, "{:<14} {:<10} process {:<8} {megabytes} MB", self.name, self.activity, self.process_id);
        if let Some(age_s) = self.age_s.filter(|_| !self.health.is_up()) {
            let _ = write!(out, ", last seen {age_s} s ago");
        }
        if let Some(BusyAnswer { job, for_s }) = self.busy.as_ref().filter(|busy| busy.for_s >= LONG_S) {
            let _ = write!(out, ", busy with {job} for {for_s:.0} s");
        }
        if self.restarts > 0 {
            let _ = write!(out, ", started again {}", counted(self.restarts as usize, "time"));
        }
        out.push('\n');
        for words in self.error.iter().chain(&self.warning) {
            let _ = writeln!(out, "  {words}");
        }
        out
    }
}

/// Seconds, to a tenth.
fn tenths(duration: Duration) -> f64 {
    (duration.as_secs_f64() * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::SeenReport;

    #[test]
    fn what_is_wrong_with_a_process_is_told_and_that_it_died_meanwhile() {
        let report = SeenReport {
            age: Duration::from_millis(1_240),
            is_overdue: false,
            process_id: 7,
            restarts: 2,
            memory_bytes: 5_000_000,
            activity: "published".to_owned(),
            error: None,
            warning: None,
            busy: Some(("drawing".to_owned(), Duration::from_secs(4))),
        };
        let seen = |is_alive, report| {
            let answer = ProcessAnswer::of(SeenProcess { name: "rasterize".to_owned(), is_alive, report });
            (answer.health.name(), answer.words().unwrap_or_default(), answer.text())
        };
        let (health, words, text) = seen(true, Some(report.clone()));
        assert_eq!((health, words.as_str()), ("ok", "started again: 2"));
        assert_eq!(
            text,
            "rasterize      published  process 7        5 MB, busy with drawing for 4 s, started again 2 times\n"
        );
        let warning = SeenReport { warning: Some("late".to_owned()), ..report.clone() };
        assert_eq!(seen(true, Some(warning.clone())).1, "late");
        assert_eq!(seen(true, Some(SeenReport { error: Some("bad".to_owned()), ..warning })).0, "error");
        let (health, words, text) = seen(true, Some(SeenReport { is_overdue: true, ..report.clone() }));
        assert_eq!((health, words.as_str()), ("error", "it hangs"));
        assert!(text.contains("hangs") && text.contains("last seen 1.2 s ago"), "{text}");
        let (health, _, text) = seen(false, Some(report));
        assert!(health == "down" && text.contains("dead") && text.contains("process 0") && !text.contains("busy"));
        assert_eq!(seen(true, None).1, "it does not run");
        assert!(seen(false, None).2.contains("silent"));
    }
}
