//! Progress of a request: the service reports it, the loop sends it to the client.

use bus::Waker;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, Mutex, PoisonError};

/// Progress of a daemon with a request.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Progress {
    /// What it is doing.
    pub doing: String,
    /// Percent of the whole work that is done, at most 100; it does not fall.
    pub percent: u8,
}

/// Where a service reports the progress of a request, from any thread.
///
/// Reporting neither waits nor fails, also when the client is gone: the loop sends only the newest report. The default
/// one reports to no client.
#[derive(Clone, Default)]
pub struct Reporter {
    newest: Arc<Mutex<Newest>>,
    waker: Option<Waker>,
}

#[derive(Default)]
struct Newest {
    progress: Progress,
    is_sent: bool,
}

impl Reporter {
    /// Reports to a loop, which the waker wakes.
    pub(crate) fn new(waker: Waker) -> Self {
        Self { waker: Some(waker), ..Self::default() }
    }

    /// Reports what is being done, and the share of the whole work that is done, from 0 to 1. A share below an earlier
    /// one counts as that one.
    pub fn report(&self, doing: &str, share: f64) {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let percent = ((share.clamp(0.0, 1.0) * 100.0) as u8).max(newest.progress.percent);
        if (newest.progress.doing.as_str(), newest.progress.percent) == (doing, percent) {
            return;
        }
        *newest = Newest { progress: Progress { doing: doing.to_owned(), percent }, is_sent: false };
        drop(newest);
        self.waker.iter().for_each(Waker::wake_up);
    }

    /// What is being done; empty before the first report.
    pub(crate) fn doing(&self) -> String {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).progress.doing.clone()
    }

    /// The newest report, unless it was taken before.
    pub(crate) fn take(&self) -> Option<Progress> {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let is_news = !newest.is_sent && newest.progress != Progress::default();
        newest.is_sent = true;
        is_news.then(|| newest.progress.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_does_not_fall_and_is_taken_once() {
        let reporter = Reporter::default();
        assert_eq!(reporter.take(), None, "nothing was reported");
        for (share, percent) in [(0.101, 10), (0.5, 50), (0.3, 50), (f64::NAN, 50), (7.0, 100)] {
            reporter.report(&format!("{share}"), share);
            assert_eq!(reporter.take().map(|p| p.percent), Some(percent), "{share}");
            assert_eq!(reporter.take(), None);
        }
        reporter.report("7", 1.0);
        assert_eq!(reporter.take(), None, "it says the same");
        reporter.report("done", 1.0);
        assert_eq!(reporter.take(), Some(Progress { doing: "done".to_owned(), percent: 100 }));
    }
}
