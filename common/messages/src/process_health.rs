//! The health of a process of a site, by what is seen of it and what it reported last.

use std::time::Duration;

/// A process as the caller finds it.
#[derive(Debug, Clone, PartialEq)]
pub struct SeenProcess {
    /// As of its process; behind it the robot whose it is, of a site with several.
    pub name: String,
    /// True if it lives.
    pub is_alive: bool,
    /// The last that it reported; `None` if it never did.
    pub report: Option<SeenReport>,
}

/// The last report of a process.
#[derive(Debug, Clone, PartialEq)]
pub struct SeenReport {
    /// How long ago it was written.
    pub age: Duration,
    /// True if a process that lives would have reported again by now.
    pub is_overdue: bool,
    /// Its process.
    pub process_id: u32,
    /// How often it died and was started again.
    pub restarts: u32,
    /// Resident memory in bytes.
    pub memory_bytes: u64,
    /// What it is doing.
    pub activity: String,
    /// Why its output is not what its inputs ask for, or what it failed to do last.
    pub error: Option<String>,
    /// What an operator should know although nothing failed.
    pub warning: Option<String>,
    /// What it works on, and for how long.
    pub busy: Option<(String, Duration)>,
}

/// How a process is, from bad to good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProcessHealth {
    /// It does not run, or lives and never reported: nothing is known of it.
    Down,
    /// It lives, and reports nothing any more.
    Hangs,
    /// It has an error.
    Error,
    /// It has something to tell.
    Warning,
    /// All is well.
    Ok,
}

impl ProcessHealth {
    /// `down`, `error`, `warning` or `ok`: what hangs has an error.
    pub fn name(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Hangs | Self::Error => "error",
            Self::Warning => "warning",
            Self::Ok => "ok",
        }
    }

    /// True if the process lives and reports.
    pub fn is_up(self) -> bool {
        match self {
            Self::Down | Self::Hangs => false,
            Self::Error | Self::Warning | Self::Ok => true,
        }
    }
}

impl SeenProcess {
    /// How it is, and what is wrong with it, for people; `None` if nothing is.
    pub fn health(&self) -> (ProcessHealth, Option<&str>) {
        let Some(report) = self.report.as_ref().filter(|_| self.is_alive) else {
            return (ProcessHealth::Down, Some("it does not run"));
        };
        match (&report.error, &report.warning) {
            _ if report.is_overdue => (ProcessHealth::Hangs, Some("it hangs")),
            (Some(error), _) => (ProcessHealth::Error, Some(error)),
            (None, Some(warning)) => (ProcessHealth::Warning, Some(warning)),
            (None, None) => (ProcessHealth::Ok, None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn health_is_that_of_what_is_worst() {
        let report = |is_overdue, error: Option<&str>, warning: Option<&str>| SeenReport {
            age: Duration::from_secs(1),
            is_overdue,
            process_id: 7,
            restarts: 1,
            memory_bytes: 5,
            activity: "published".to_owned(),
            error: error.map(str::to_owned),
            warning: warning.map(str::to_owned),
            busy: None,
        };
        let check = |is_alive, report: Option<SeenReport>, expected: (ProcessHealth, Option<&str>)| {
            let seen = SeenProcess { name: "rasterize".to_owned(), is_alive, report };
            assert_eq!(seen.health(), expected, "{seen:?}");
        };
        use ProcessHealth::*;
        check(true, Some(report(false, None, None)), (Ok, None));
        check(true, Some(report(false, None, Some("look"))), (Warning, Some("look")));
        check(true, Some(report(false, Some("bad"), Some("look"))), (Error, Some("bad")));
        check(true, Some(report(true, Some("bad"), None)), (Hangs, Some("it hangs")));
        check(true, None, (Down, Some("it does not run")));
        for is_overdue in [false, true] {
            check(false, Some(report(is_overdue, None, None)), (Down, Some("it does not run")));
        }
        assert_eq!([Down, Hangs, Error, Warning, Ok].map(ProcessHealth::is_up), [false, false, true, true, true]);
    }
}
