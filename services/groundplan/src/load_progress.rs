//! The progress of a daemon that loads models, on standard error.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::RefCell;
use std::io::IsTerminal;

/// The progress of a daemon that loads models: a bar on a terminal, a line for each step of ten percent elsewhere.
pub(crate) struct LoadProgress {
    /// `None` where standard error is no terminal.
    bar: Option<ProgressBar>,
    lines: RefCell<Lines>,
}

impl LoadProgress {
    pub(crate) fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(Some(100), ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos:>3} %  {msg}") {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, lines: RefCell::default() }
    }

    /// Shows a report of the daemon.
    pub(crate) fn show(&self, progress: &daemon::Progress) {
        if let Some(bar) = &self.bar {
            bar.set_message(progress.doing.clone());
            bar.set_position(u64::from(progress.percent));
        } else if let Some(line) = self.lines.borrow_mut().line_of(progress) {
            eprintln!("{line}");
        }
    }

    /// The daemon is done; others go on.
    pub(crate) fn waits_for(&self, what: &'static str) {
        self.bar.iter().for_each(|bar| bar.set_message(what));
    }
}

impl Drop for LoadProgress {
    fn drop(&mut self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }
}

/// Which reports become lines where there is no terminal.
#[derive(Default)]
struct Lines {
    printed: Option<daemon::Progress>,
}

impl Lines {
    /// A line for other work, for every ten percent, and for the end.
    fn line_of(&mut self, progress: &daemon::Progress) -> Option<String> {
        let is_next = |last: &daemon::Progress| {
            last.doing != progress.doing
                || last.percent.saturating_add(10) <= progress.percent
                || last.percent < progress.percent && progress.percent == 100
        };
        if !self.printed.as_ref().is_none_or(is_next) {
            return None;
        }
        self.printed = Some(progress.clone());
        Some(format!("{:>3} %  {}", progress.percent, progress.doing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_of_other_work_of_ten_percent_and_of_the_end() {
        let mut lines = Lines::default();
        let mut line = |percent, doing: &str| lines.line_of(&daemon::Progress { doing: doing.to_owned(), percent });
        let printed =
            [(0, "a"), (4, "a"), (5, "b"), (14, "b"), (15, "b"), (95, "b"), (99, "b"), (100, "b"), (100, "b")]
                .map(|(percent, doing)| line(percent, doing));
        let printed: Vec<String> = printed.into_iter().flatten().collect();
        assert_eq!(printed, ["  0 %  a", "  5 %  b", " 15 %  b", " 95 %  b", "100 %  b"]);
    }
}
