//! Where questions come in: so many at once, each with its time, and the documents that go out.

use crate::bounds::{Page, bounded};
use crate::document::{Document, NOTICE};
use crate::problem::{Problem, ProblemKind};
use crate::questions::{Declared, question};
use crate::schemas::PAGING;
use crate::site::Site;
use serde_json::{Map, Value};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;
use tokio::sync::Semaphore;

/// Questions that are worked on at the same time, of each lane.
const N_AT_WORK: [usize; 2] = [2, 1];
/// Questions that wait for their turn.
const MAX_WAITING: usize = 32;
/// Time for its turn.
const TURN_TIMEOUT: Duration = Duration::from_secs(30);

/// Takes questions.
#[derive(Clone)]
pub(crate) struct Desk {
    site: Arc<Site>,
    turns: [Arc<Semaphore>; 2],
    waiting: Arc<AtomicUsize>,
    n_asked: Arc<AtomicU64>,
}

impl Desk {
    /// For a site.
    pub(crate) fn of(site: Arc<Site>) -> Self {
        Self {
            site,
            turns: N_AT_WORK.map(|n| Arc::new(Semaphore::new(n))),
            waiting: Arc::default(),
            n_asked: Arc::default(),
        }
    }

    /// Questions that were asked so far.
    pub(crate) fn n_asked(&self) -> u64 {
        self.n_asked.load(Ordering::Relaxed)
    }

    /// Answers a question, on a thread for work that takes its time.
    ///
    /// # Errors
    /// See [`ProblemKind`].
    pub(crate) async fn ask(&self, name: &str, mut parameters: Map<String, Value>) -> Result<Value, Problem> {
        self.n_asked.fetch_add(1, Ordering::Relaxed);
        let declared = question(name)?;
        let page = page_of(declared, &mut parameters)?;
        let (lane, work) = (declared.ask)(parameters)?;
        let busy =
            || Problem::of(ProblemKind::Busy, "too many questions are asked at once: ask again in a few seconds");
        let waiting = Waiting::among(&self.waiting).ok_or_else(busy)?;
        let turn = tokio::time::timeout(TURN_TIMEOUT, Arc::clone(&self.turns[lane as usize]).acquire_owned());
        let turn = turn.await.map_err(|_| busy())?.map_err(|_| busy())?;
        drop(waiting);
        let site = Arc::clone(&self.site);
        // Who leaves does not free the turn: the work goes on until it is done.
        let work = tokio::task::spawn_blocking(move || {
            let _turn = turn;
            let (answer, running) = site.at_this_moment(lane, |moment| Ok((work(moment)?, moment.running.clone())))?;
            let (answer, cut) = bounded(answer, declared.paged, page);
            let document = Document { question: declared.name, running, notice: NOTICE, answer, cut };
            serde_json::to_value(document).map_err(|why| Problem::of(ProblemKind::Failed, why.to_string()))
        });
        let given_up = |_| Problem::of(ProblemKind::Failed, "the work was given up");
        work.await.map_err(given_up)?
    }
}

/// A place among those who wait.
struct Waiting<'a>(&'a AtomicUsize);

impl<'a> Waiting<'a> {
    fn among(waiting: &'a AtomicUsize) -> Option<Self> {
        if waiting.fetch_add(1, Ordering::AcqRel) < MAX_WAITING {
            return Some(Self(waiting));
        }
        waiting.fetch_sub(1, Ordering::AcqRel);
        None
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

/// Takes the parameters that ask for a page.
fn page_of(declared: &Declared, parameters: &mut Map<String, Value>) -> Result<Page, Problem> {
    let mut numbers = PAGING.map(|(.., default)| default);
    if !declared.paged.is_empty() {
        for (number, (name, _, [least, most], _)) in numbers.iter_mut().zip(PAGING) {
            let Some(value) = parameters.remove(name) else { continue };
            let asked = value.as_u64().map(|asked| asked as usize).filter(|asked| (least..=most).contains(asked));
            let why =
                || Problem::of(ProblemKind::BadParameter, format!("{name}: a whole number from {least} to {most}"));
            *number = asked.ok_or_else(why)?;
        }
    }
    let [first, limit] = numbers;
    Ok(Page { first, limit })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_page_is_asked_for_in_whole_numbers_within_bounds() {
        let page = |name: &str, parameters: Value| {
            let Value::Object(mut parameters) = parameters else { panic!("{parameters}") };
            page_of(question(name).unwrap(), &mut parameters).map(|page| (page.first, page.limit, parameters.len()))
        };
        assert_eq!(page("rooms", json!({"first": 7, "storey": "1"})).unwrap(), (7, 100, 1));
        assert_eq!(page("door", json!({"first": 7})).unwrap(), (0, 100, 1), "it has no long list");
        for wrong in [json!({"limit": 0}), json!({"limit": 501}), json!({"first": -1}), json!({"first": "0"})] {
            assert_eq!(page("rooms", wrong.clone()).unwrap_err().status(), 400, "{wrong}");
        }
    }

    #[test]
    fn so_many_wait_and_no_more() {
        let waiting = AtomicUsize::new(0);
        let mut places: Vec<Waiting<'_>> = (0..MAX_WAITING).map(|_| Waiting::among(&waiting).unwrap()).collect();
        assert!(Waiting::among(&waiting).is_none());
        places.pop();
        assert!(Waiting::among(&waiting).is_some());
    }
}
