//! Searches that clients asked for: in which order they begin, and what became of them.

use crate::job::SearchArea;
use daemon::{Failure, Published, SearchState};
use std::collections::VecDeque;

/// Searches that wait; more are refused.
const MAX_ASKED: usize = 16;
/// Results that are kept for the clients that ask about them.
const MAX_RESULTS: usize = 32;

/// The searches of clients, by number.
#[derive(Debug, Clone, Default)]
pub(crate) struct Searches {
    next: u64,
    /// Those that wait, the next one first.
    asked: VecDeque<(u64, SearchArea)>,
    running: Option<(u64, SearchArea)>,
    /// Those that have ended, the newest last.
    ended: VecDeque<(u64, SearchState)>,
}

impl Searches {
    /// Numbers that no other process gives: all epochs that were taken before this start are below this one, and no search is asked
    /// for before an alignment has taken the next.
    pub(crate) fn of_process(first_epoch: u64) -> Self {
        Self { next: first_epoch << 10, ..Self::default() }
    }

    /// Takes a search that is asked for; its number.
    ///
    /// # Errors
    /// Too many wait.
    pub(crate) fn ask(&mut self, search_area: SearchArea) -> Result<u64, Failure> {
        if self.asked.len() >= MAX_ASKED {
            return Err("too many searches wait already".into());
        }
        self.asked.push_back((self.next, search_area));
        self.next += 1;
        Ok(self.next - 1)
    }

    /// True if a search waits.
    pub(crate) fn is_waiting(&self) -> bool {
        !self.asked.is_empty()
    }

    /// Begins the next search.
    pub(crate) fn begin(&mut self) -> Option<(u64, SearchArea)> {
        self.running = self.asked.pop_front();
        self.running.clone()
    }

    /// Puts the running search back, because its inputs have changed: it is the next one.
    pub(crate) fn begin_again(&mut self) {
        if let Some(search) = self.running.take() {
            self.asked.push_front(search);
        }
    }

    /// Ends the running search.
    pub(crate) fn end(&mut self, state: SearchState) {
        if let Some((number, _)) = self.running.take() {
            self.ended.push_back((number, state));
            self.ended.drain(..self.ended.len().saturating_sub(MAX_RESULTS));
        }
    }

    /// The alignment of what has ended since the last decision is published as this.
    pub(crate) fn are_published(&mut self, last: Published) {
        for (_, state) in &mut self.ended {
            if let SearchState::Done { alignment: alignment @ Published { epoch: 0, .. }, .. } = state {
                *alignment = last;
            }
        }
    }

    /// What became of a search.
    pub(crate) fn state(&self, number: u64) -> SearchState {
        if let Some((_, state)) = self.ended.iter().find(|(ended, _)| *ended == number) {
            return state.clone();
        }
        if self.running.iter().chain(&self.asked).any(|(known, _)| *known == number) {
            return SearchState::Running;
        }
        SearchState::Failed { why: "slam-align was started again meanwhile: ask again".to_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ContentHash;

    fn done(epoch: u64) -> SearchState {
        SearchState::Done { alignment: Published { epoch, content_hash: ContentHash::NONE }, is_of_newest_map: true }
    }

    #[test]
    fn searches_end_in_order_also_if_one_begins_again() {
        let mut searches = Searches::of_process(4);
        let [first, second] = [(); 2].map(|()| searches.ask(SearchArea::default()).unwrap());
        assert_eq!(searches.begin().map(|(number, _)| number), Some(first));
        searches.begin_again();
        assert_eq!((searches.state(first), searches.state(second)), (SearchState::Running, SearchState::Running));
        assert_eq!(searches.begin().map(|(number, _)| number), Some(first));
        searches.end(done(0));
        searches.are_published(Published { epoch: 7, content_hash: ContentHash::NONE });
        searches.begin();
        searches.end(SearchState::Failed { why: "why".to_owned() });
        searches.are_published(Published { epoch: 8, content_hash: ContentHash::NONE });
        assert_eq!((searches.state(first), searches.is_waiting()), (done(7), false));
        assert_eq!(searches.state(second), SearchState::Failed { why: "why".to_owned() });
        assert!(matches!(searches.state(second + 1), SearchState::Failed { .. }), "nobody asked for it");
    }

    #[test]
    fn too_many_searches_are_refused() {
        let mut searches = Searches::default();
        let refused = (0..).find(|_| searches.ask(SearchArea::default()).is_err());
        assert_eq!(refused, Some(MAX_ASKED));
    }
}
