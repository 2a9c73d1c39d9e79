//! The report of the site that clients ask for. Each gets the same bytes for a while: who asks without end does not keep
//! the relay busy with making it.

use std::sync::Arc;
use std::time::{Duration, Instant};

/// A report is passed on for this long before it is made anew.
const KEPT_FOR: Duration = Duration::from_millis(200);

/// Makes and keeps the report.
pub(super) struct Report {
    make: Box<dyn Fn() -> Vec<u8> + Send>,
    last: Option<(Instant, Arc<[u8]>)>,
}

impl Report {
    pub(super) fn new(make: Box<dyn Fn() -> Vec<u8> + Send>) -> Self {
        Self { make, last: None }
    }

    /// The report as it is, or was a moment ago.
    pub(super) fn get(&mut self) -> Arc<[u8]> {
        let kept = self.last.take().filter(|(made, _)| made.elapsed() < KEPT_FOR);
        let (made, bytes) = kept.unwrap_or_else(|| {
            let bytes = (self.make)().into();
            (Instant::now(), bytes)
        });
        self.last = Some((made, Arc::clone(&bytes)));
        bytes
    }
}
