//! Progress of work in this process, on standard error: a line on a terminal, or JSON lines for programs.

use crate::progress_record::ProgressRecord;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use ingest::{Progress, Stage};
use site_answers::DrawingProgress;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often the line is drawn while nothing advances.
const TICK: Duration = Duration::from_millis(250);
/// Time between two JSON lines of a stage.
const PERIOD: Duration = Duration::from_secs(1);
/// Work that has not advanced for so long is slow.
const SLOW: Duration = Duration::from_secs(5);

/// Says what this process is doing.
pub(crate) struct ProgressLine {
    shown: Arc<Mutex<Shown>>,
    output: Output,
}

enum Output {
    /// Silent where standard error is no terminal.
    Line(ProgressBar),
    /// A thread tells of what is slow until it is told to end.
    Json(Option<(Sender<()>, JoinHandle<()>)>),
}

/// What was reported last.
struct Shown {
    record: ProgressRecord,
    begun: Instant,
    stage_begun: Instant,
    advanced: Instant,
    printed: Option<Instant>,
}

impl ProgressLine {
    /// A line for a person, or JSON lines.
    pub(crate) fn new(is_json: bool) -> Self {
        let now = Instant::now();
        let shown = Shown {
            record: ProgressRecord::of("starting"),
            begun: now,
            stage_begun: now,
            advanced: now,
            printed: None,
        };
        let shown = Arc::new(Mutex::new(shown));
        let output = if is_json { Output::Json(tells_of_slow_work(&shown)) } else { Output::Line(line(&shown)) };
        Self { shown, output }
    }

    /// A stage of unknown length.
    pub(crate) fn stage(&self, stage: &'static str) {
        self.show(ProgressRecord::of(stage));
    }

    /// Steps of a stage.
    pub(crate) fn step(&self, stage: &'static str, done: usize, total: usize) {
        self.show(ProgressRecord { done: Some(done), total: Some(total), ..ProgressRecord::of(stage) });
    }

    /// A step of the reader.
    pub(crate) fn reader(&self, progress: Progress<'_>) {
        let stage = match progress.stage {
            Stage::Reading => "reading",
            Stage::Meshing => "meshing",
            Stage::Joining => "joining",
        };
        self.show(ProgressRecord {
            file: (!progress.file.is_empty()).then(|| progress.file.to_owned()),
            done: Some(progress.done),
            total: Some(progress.total),
            waits_for: progress.waits_for.map(|named| format!("#{} {} {}", named.step_id, named.global_id, named.name)),
            ..ProgressRecord::of(stage)
        });
    }

    fn show(&self, record: ProgressRecord) {
        let mut shown = self.shown.lock().unwrap_or_else(PoisonError::into_inner);
        let is_other = !shown.record.is_same_stage(&record);
        shown.take(record, Instant::now());
        match &self.output {
            Output::Line(bar) => {
                // The line asks for what is shown.
                drop(shown);
                if is_other {
                    bar.tick();
                }
            }
            Output::Json(_) => {
                if is_other || shown.printed.is_none_or(|at| at.elapsed() >= PERIOD) {
                    shown.print();
                }
            }
        }
    }
}

impl DrawingProgress for ProgressLine {
    fn stage(&self, stage: &'static str) {
        self.stage(stage);
    }

    fn step(&self, stage: &'static str, done: usize, total: usize) -> bool {
        self.step(stage, done, total);
        true
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        match &mut self.output {
            Output::Line(bar) => bar.finish_and_clear(),
            Output::Json(teller) => {
                if let Some((end, thread)) = teller.take() {
                    drop(end);
                    // It only prints.
                    let _ = thread.join();
                }
            }
        }
    }
}

impl Shown {
    fn take(&mut self, record: ProgressRecord, now: Instant) {
        if !self.record.is_same_stage(&record) {
            self.stage_begun = now;
            self.advanced = now;
        } else if self.record.done != record.done {
            self.advanced = now;
        }
        self.record = record;
    }

    /// With its times at this moment.
    fn at(&self, now: Instant) -> ProgressRecord {
        let stands = now.saturating_duration_since(self.advanced);
        ProgressRecord {
            elapsed_s: seconds(now.saturating_duration_since(self.begun)),
            left_s: self.record.left_s(now.saturating_duration_since(self.stage_begun)),
            stands_s: (stands >= SLOW).then(|| seconds(stands)),
            ..self.record.clone()
        }
    }

    fn print(&mut self) {
        let now = Instant::now();
        self.printed = Some(now);
        if let Ok(line) = serde_json::to_string(&self.at(now)) {
            eprintln!("{line}");
        }
    }
}

/// In tenths.
fn seconds(duration: Duration) -> f64 {
    (duration.as_secs_f64() * 10.0).round() / 10.0
}

fn line(shown: &Arc<Mutex<Shown>>) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    let shown = Arc::clone(shown);
    let text = move |_: &ProgressState, out: &mut dyn std::fmt::Write| {
        let shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = write!(out, "{}", shown.at(Instant::now()));
    };
    if let Ok(style) = ProgressStyle::with_template("{spinner} {text}") {
        bar.set_style(style.with_key("text", text));
    }
    if !bar.is_hidden() {
        bar.enable_steady_tick(TICK);
    }
    bar
}

/// Prints what is slow, which reports nothing itself.
fn tells_of_slow_work(shown: &Arc<Mutex<Shown>>) -> Option<(Sender<()>, JoinHandle<()>)> {
    let (end, ended) = channel::<()>();
    let shown = Arc::clone(shown);
    let tell = move || {
        while ended.recv_timeout(SLOW) == Err(RecvTimeoutError::Timeout) {
            let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
            if shown.advanced.elapsed() >= SLOW {
                shown.print();
            }
        }
    };
    let thread = std::thread::Builder::new().name("progress".to_owned()).spawn(tell).ok()?;
    Some((end, thread))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_does_not_advance_is_slow_and_says_what_it_waits_for() {
        let begun = Instant::now();
        let step = |done| ProgressRecord {
            done: Some(done),
            total: Some(4),
            waits_for: Some("#7 wall".to_owned()),
            ..ProgressRecord::of("meshing")
        };
        let record = ProgressRecord::of("starting");
        let mut shown = Shown { record, begun, stage_begun: begun, advanced: begun, printed: None };
        let at = |s| begun + Duration::from_secs(s);
        shown.take(step(0), at(1));
        shown.take(step(1), at(3));
        assert_eq!(shown.at(at(5)).to_string(), "meshing 1 of 4, about 12 s left");
        assert_eq!(shown.at(at(9)).to_string(), "meshing 1 of 4, for 6 s at #7 wall or another");
        shown.take(step(3), at(9));
        assert_eq!(shown.at(at(9)).stands_s, None);
        assert_eq!(shown.at(at(9)).elapsed_s, 9.0);
    }
}
