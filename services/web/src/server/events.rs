//! `data/events`: what changes, as server-sent events. A viewer that comes late gets the newest of each kind.

use super::headers::{OWN_PAGE, not_found};
use super::served::{MAX_VIEWERS, Served};
use crate::live::Feed;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::stream::{self, Stream};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, watch};

/// Interval of signs of life, so that a connection that is gone is noticed.
const SIGN_OF_LIFE: Duration = Duration::from_secs(10);

pub(super) async fn events(State(served): State<Served>) -> Response {
    let Some(live) = served.live else { return not_found() };
    let Ok(place) = served.viewers.try_acquire_owned() else {
        let text = format!("{MAX_VIEWERS} viewers follow the site already: more are too many");
        // By the header the page tells this from a proxy behind which nothing answers.
        let headers = [(header::RETRY_AFTER, "10"), (header::HeaderName::from_static(OWN_PAGE), "too-many-viewers")];
        return (StatusCode::SERVICE_UNAVAILABLE, headers, text).into_response();
    };
    Sse::new(of_feed(live.feed(), place)).keep_alive(KeepAlive::new().interval(SIGN_OF_LIFE)).into_response()
}

/// The newest of each kind, then what changes; the viewer's place is free again when it ends.
fn of_feed(
    receiver: watch::Receiver<Feed>,
    place: OwnedSemaphorePermit,
) -> impl Stream<Item = Result<Event, Infallible>> {
    stream::unfold((receiver, place, Feed::new()), |(mut receiver, place, mut sent)| async move {
        loop {
            let next = next_event(&receiver.borrow_and_update(), &sent);
            if let Some((kind, data)) = next {
                let event = Event::default().event(kind).data(&*data);
                sent.insert(kind, data);
                return Some((Ok(event), (receiver, place, sent)));
            }
            if receiver.changed().await.is_err() {
                return None;
            }
        }
    })
}

/// An event that the viewer does not have. The site goes before what belongs to it.
fn next_event(newest: &Feed, sent: &Feed) -> Option<(&'static str, Arc<str>)> {
    let is_new = |kind: &str, data: &Arc<str>| sent.get(kind).is_none_or(|known| !Arc::ptr_eq(known, data));
    let new = newest.iter().filter(|(kind, data)| is_new(kind, data));
    new.min_by_key(|(kind, _)| **kind != "site").map(|(kind, data)| (*kind, Arc::clone(data)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_site_comes_before_what_belongs_to_it() {
        let newest: Feed = [("date", Arc::from("1")), ("site", Arc::from("2"))].into();
        assert_eq!(next_event(&newest, &Feed::new()), Some(("site", Arc::from("2"))));
    }

    #[test]
    fn a_viewer_gets_the_newest_of_each_kind_once() {
        let newest: Feed = [("date", Arc::from("1")), ("status", Arc::from("{}"))].into();
        let mut sent = Feed::new();
        while let Some((kind, data)) = next_event(&newest, &sent) {
            assert!(sent.insert(kind, data).is_none());
        }
        assert_eq!(sent, newest);
        let later: Feed = [("date", Arc::from("2")), ("status", Arc::clone(&newest["status"]))].into();
        assert_eq!(next_event(&later, &sent), Some(("date", Arc::from("2"))));
    }
}
