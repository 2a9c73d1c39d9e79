//! Programs that are run when maps change or become stale: one at a time, tried again with back-off, ended when they hang.

use rustix::process::{Pid, Signal, kill_process_group};
use site_view::{Staleness, Storeys};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A program that has not ended after this time hangs, and is killed.
pub(super) const TIME_LIMIT: Duration = Duration::from_secs(60);
/// A program that failed is run again after this time; each time it is doubled, up to [`MAX_BACKOFF`].
const FIRST_BACKOFF: Duration = Duration::from_secs(1);
const MAX_BACKOFF: Duration = Duration::from_secs(60);

/// Why a program is run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Occasion {
    /// Maps in this folder may be used.
    Maps { folder: PathBuf },
    /// Maps must not be used.
    Stale(Staleness),
}

/// The programs, and what is to be run.
pub(super) struct Hooks {
    on_change: Option<PathBuf>,
    on_stale: Option<PathBuf>,
    /// What holds now.
    occasion: Option<Occasion>,
    /// True if the program of the occasion is still to be run.
    is_due: bool,
    /// Failures in a row, and when the next try is due.
    failures: u32,
    next_try: Option<Instant>,
    running: Option<Running>,
    /// The folder of the last success, while no run began after it.
    previous: Option<PathBuf>,
    /// Storeys for which the maps were called stale since the last success.
    stale_storeys: Option<Storeys>,
}

struct Running {
    child: Child,
    occasion: Occasion,
    begun: Instant,
}

impl Hooks {
    pub(super) fn new(on_change: Option<PathBuf>, on_stale: Option<PathBuf>) -> Self {
        Self {
            on_change,
            on_stale,
            occasion: None,
            is_due: false,
            failures: 0,
            next_try: None,
            running: None,
            previous: None,
            stale_storeys: None,
        }
    }

    /// What holds from now on; the program of another occasion is run as soon as none runs.
    pub(super) fn set(&mut self, occasion: Occasion) {
        let is_known = match (&self.occasion, &occasion) {
            // The reason may change, and fewer storeys are nothing new.
            (Some(Occasion::Stale(before)), Occasion::Stale(now)) => before.storeys.contains(&now.storeys),
            (before, now) => before.as_ref() == Some(now),
        };
        if is_known {
            return;
        }
        if let (Occasion::Stale(_), Some(running)) = (&occasion, &mut self.running)
            && matches!(running.occasion, Occasion::Maps { .. })
        {
            // It loads maps that must not be used any more.
            running.kill();
        }
        (self.occasion, self.is_due, self.failures, self.next_try) = (Some(occasion), true, 0, None);
    }

    /// Ends what hangs, starts what is due; never waits.
    pub(super) fn tick(&mut self, now: Instant) {
        if let Some(running) = &mut self.running {
            match running.result(now) {
                None => return,
                Some(result) => self.ended(result, now),
            }
        }
        let is_time = self.next_try.is_none_or(|at| at <= now);
        if self.is_due && is_time {
            self.start(now);
        }
    }

    /// Kills what runs.
    pub(super) fn end(&mut self) {
        if let Some(running) = &mut self.running {
            running.kill();
            let _ = running.child.wait();
        }
        self.running = None;
    }

    /// Folders that programs read, or compare with.
    pub(super) fn folders(&self) -> impl Iterator<Item = &Path> {
        let running = self.running.as_ref().and_then(|running| match &running.occasion {
            Occasion::Maps { folder } => Some(folder.as_path()),
            Occasion::Stale(_) => None,
        });
        running.into_iter().chain(self.previous.as_deref())
    }

    fn start(&mut self, now: Instant) {
        let Some(occasion) = self.occasion.clone() else { return };
        let program = match &occasion {
            Occasion::Maps { .. } => &self.on_change,
            Occasion::Stale(_) => &self.on_stale,
        };
        if let Occasion::Stale(staleness) = &occasion {
            self.stale_storeys = Some(match (self.stale_storeys.take(), &staleness.storeys) {
                (None, storeys) => storeys.clone(),
                (Some(Storeys::Only(before)), Storeys::Only(now)) => Storeys::Only(&before | now),
                (Some(_), _) => Storeys::All,
            });
        }
        let Some(program) = program else {
            self.is_due = false;
            if let Occasion::Maps { folder } = occasion {
                (self.previous, self.stale_storeys) = (Some(folder), None);
            }
            return;
        };
        let mut command = Command::new(program);
        match &occasion {
            Occasion::Maps { folder } => command.arg(folder),
            Occasion::Stale(staleness) => command.arg(&staleness.reason),
        };
        command.env("GROUNDPLAN_STALE_STOREYS", self.stale_storeys.as_ref().map(text).unwrap_or_default());
        command.env("GROUNDPLAN_PREVIOUS", self.previous.as_deref().unwrap_or(Path::new("")));
        // A group of its own: what it starts ends with it.
        let spawned = command.stdin(Stdio::null()).process_group(0).spawn();
        if matches!(occasion, Occasion::Maps { .. }) {
            // Until it succeeds it is unknown what was brought where.
            self.previous = None;
        }
        match spawned {
            Ok(child) => self.running = Some(Running { child, occasion, begun: now }),
            Err(error) => self.failed(&occasion, &error.to_string(), now),
        }
    }

    /// The running program has ended.
    fn ended(&mut self, result: Result<(), String>, now: Instant) {
        let Some(Running { occasion, .. }) = self.running.take() else { return };
        match result {
            Err(why) => self.failed(&occasion, &why, now),
            Ok(()) => {
                if self.occasion.as_ref() == Some(&occasion) {
                    (self.is_due, self.failures, self.next_try) = (false, 0, None);
                }
                if let Occasion::Maps { folder } = occasion {
                    (self.previous, self.stale_storeys) = (Some(folder), None);
                }
            }
        }
    }

    /// Reports a failure; if the occasion still holds the program is run again later.
    fn failed(&mut self, occasion: &Occasion, why: &str, now: Instant) {
        let what = match occasion {
            Occasion::Maps { folder } => format!("--on-change for {}", folder.display()),
            Occasion::Stale(staleness) => format!("--on-stale for \"{}\"", staleness.reason),
        };
        if self.occasion.as_ref() != Some(occasion) {
            eprintln!("groundplan: {what}: {why}");
            return;
        }
        let backoff = (FIRST_BACKOFF * 2u32.saturating_pow(self.failures.min(6))).min(MAX_BACKOFF);
        self.failures += 1;
        self.next_try = Some(now + backoff);
        eprintln!("groundplan: {what}: {why}; it is run again in {} s", backoff.as_secs());
    }
}

impl Running {
    /// Whether it succeeded; `None` while it runs.
    fn result(&mut self, now: Instant) -> Option<Result<(), String>> {
        match self.child.try_wait() {
            Ok(Some(status)) if status.success() => Some(Ok(())),
            Ok(Some(status)) => Some(Err(status.to_string())),
            Ok(None) if now.duration_since(self.begun) >= TIME_LIMIT => {
                self.kill();
                let _ = self.child.wait();
                Some(Err(format!("it has not ended within {} s, and was killed", TIME_LIMIT.as_secs())))
            }
            Ok(None) => None,
            Err(error) => Some(Err(error.to_string())),
        }
    }

    fn kill(&mut self) {
        // One that has just ended needs no signal; its number is its own until it is waited for.
        if let Ok(id) = i32::try_from(self.child.id())
            && let Some(group) = Pid::from_raw(id)
        {
            let _ = kill_process_group(group, Signal::KILL);
        }
    }
}

/// Storeys for a program: `all`, or indices.
fn text(storeys: &Storeys) -> String {
    match storeys {
        Storeys::All => "all".to_owned(),
        Storeys::Only(storeys) => storeys.iter().map(u32::to_string).collect::<Vec<_>>().join(" "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// Writes a program by another process. What this one has open for writing, processes that other tests start at this moment have
    /// open too until they become their programs, and the system starts no program that somebody has open for writing.
    fn write_program(path: &Path, text: &str) {
        let mut shell = Command::new("sh");
        shell.args(["-c", "cat > \"$0\" && chmod 755 \"$0\""]).arg(path).stdin(Stdio::piped());
        let mut shell = shell.spawn().unwrap();
        shell.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        assert!(shell.wait().unwrap().success());
    }

    /// Programs that write a line for each run, and the time that has passed for the hooks.
    struct Bench {
        home: tempfile::TempDir,
        hooks: Hooks,
        begun: Instant,
    }

    impl Bench {
        /// `on_change` and `on_stale` are what the programs do behind their line.
        fn new(on_change: &str, on_stale: &str) -> Self {
            let home = tempfile::tempdir().unwrap();
            let program = |name: &str, body: &str| {
                let path = home.path().join(name);
                let variables = "$GROUNDPLAN_STALE_STOREYS|$GROUNDPLAN_PREVIOUS";
                let text =
                    format!("#!/bin/sh\ncd {}\necho \"{name} $1|{variables}\" >> log\n{body}\n", home.path().display());
                write_program(&path, &text);
                path
            };
            let hooks = Hooks::new(Some(program("change", on_change)), Some(program("stale", on_stale)));
            Self { home, hooks, begun: Instant::now() }
        }

        /// Ticks at a time until nothing runs.
        fn settle(&mut self, at_s: u64) {
            let limit = Instant::now() + Duration::from_secs(60);
            loop {
                self.hooks.tick(self.begun + Duration::from_secs(at_s));
                if self.hooks.running.is_none() {
                    return;
                }
                assert!(Instant::now() < limit, "a program does not end");
                std::thread::sleep(Duration::from_millis(2));
            }
        }

        fn maps(&mut self, folder: &str) -> &mut Self {
            self.hooks.set(Occasion::Maps { folder: folder.into() });
            self
        }

        fn stale(&mut self, reason: &str, storeys: Storeys) -> &mut Self {
            self.hooks.set(Occasion::Stale(Staleness { reason: reason.to_owned(), storeys }));
            self
        }

        fn log(&self) -> Vec<String> {
            let text = std::fs::read_to_string(self.home.path().join("log")).unwrap_or_default();
            text.lines().map(str::to_owned).collect()
        }
    }

    #[test]
    fn programs_run_once_for_each_occasion_and_know_what_was_before() {
        let mut bench = Bench::new("", "");
        bench.maps("1").settle(0);
        bench.maps("1").settle(0);
        bench.maps("2").settle(0);
        bench.stale("upper floor", Storeys::Only([1].into())).settle(0);
        bench.stale("no bus", Storeys::All).settle(0);
        bench.stale("no bus, still", Storeys::All).settle(0);
        bench.maps("2").settle(0);
        bench.maps("3").settle(0);
        let expected = [
            "change 1||",
            "change 2||1",
            "stale upper floor|1|2",
            "stale no bus|all|2",
            "change 2|all|2",
            "change 3||2",
        ];
        assert_eq!(bench.log(), expected);
    }

    #[test]
    fn a_program_that_fails_is_run_again_later_and_later_while_its_occasion_holds() {
        let mut bench = Bench::new("test -e well", "");
        bench.maps("1").settle(0);
        assert_eq!(bench.log().len(), 1);
        // Due after 1, 2 and 4 seconds.
        for (at_s, runs) in [(0, 1), (1, 2), (2, 2), (3, 3), (6, 3), (7, 4)] {
            bench.settle(at_s);
            assert_eq!(bench.log().len(), runs, "after {at_s} s");
        }
        bench.maps("2").settle(8);
        assert_eq!(bench.log().last().unwrap(), "change 2||", "nothing is known to be loaded");
        bench.stale("no bus", Storeys::All).settle(100);
        bench.settle(200);
        assert_eq!(bench.log().len(), 6, "stale maps are not loaded");
        std::fs::write(bench.home.path().join("well"), "").unwrap();
        bench.maps("2").settle(300);
        bench.settle(400);
        assert_eq!(bench.log().last().unwrap(), "change 2|all|");
        assert_eq!(bench.log().len(), 7);
    }

    #[test]
    fn programs_start_while_other_processes_are_started() {
        let is_done = std::sync::atomic::AtomicBool::new(false);
        let start_others = || {
            while !is_done.load(std::sync::atomic::Ordering::Relaxed) {
                assert!(Command::new("true").process_group(0).status().unwrap().success());
            }
        };
        std::thread::scope(|scope| {
            (0..6).for_each(|_| drop(scope.spawn(start_others)));
            let runs = || {
                let mut bench = Bench::new("", "");
                bench.maps("1").settle(0);
                bench.log().len()
            };
            let all = (0..150).all(|_| runs() == 1);
            is_done.store(true, std::sync::atomic::Ordering::Relaxed);
            assert!(all, "a program was not started");
        });
    }

    #[test]
    fn the_backoff_ends_at_a_minute() {
        let mut bench = Bench::new("exit 1", "");
        bench.maps("1");
        let mut at_s = 0;
        for _ in 0..9 {
            bench.settle(at_s);
            at_s += 60;
        }
        assert_eq!(bench.log().len(), 9);
    }

    #[test]
    fn a_program_that_hangs_is_killed_with_all_that_it_started() {
        let mut bench = Bench::new("sleep 1000 & echo $! > child; wait", "");
        bench.maps("1");
        let child = loop {
            bench.hooks.tick(bench.begun);
            let child = std::fs::read_to_string(bench.home.path().join("child")).unwrap_or_default();
            if child.ends_with('\n') {
                break child.trim().to_owned();
            }
            std::thread::sleep(Duration::from_millis(2));
        };
        bench.hooks.tick(bench.begun + TIME_LIMIT);
        assert!(bench.hooks.running.is_none() && bench.hooks.failures == 1);
        // The process may be a zombie of the machine's first process for a moment.
        let is_alive =
            || std::fs::read_to_string(format!("/proc/{child}/stat")).is_ok_and(|stat| !stat.contains(") Z"));
        let limit = Instant::now() + Duration::from_secs(60);
        while is_alive() {
            assert!(Instant::now() < limit, "its child stays");
        }
    }

    #[test]
    fn maps_that_become_stale_while_they_are_loaded_end_the_program_that_loads_them() {
        let mut bench = Bench::new("sleep 1000", "");
        bench.maps("1");
        while bench.log().is_empty() {
            bench.hooks.tick(bench.begun);
        }
        bench.stale("no bus", Storeys::All).settle(0);
        bench.settle(0);
        assert_eq!(bench.log(), ["change 1||", "stale no bus|all|"]);
    }

    #[test]
    fn folders_of_running_and_earlier_programs_are_in_use() {
        let mut bench = Bench::new("test $1 != 2 || sleep 1000", "");
        bench.maps("1").settle(0);
        bench.maps("2");
        bench.hooks.tick(bench.begun);
        assert_eq!(bench.hooks.folders().collect::<Vec<_>>(), [Path::new("2")]);
        bench.hooks.end();
        bench.maps("1").settle(0);
        assert_eq!(bench.hooks.folders().collect::<Vec<_>>(), [Path::new("1")]);
    }
}
