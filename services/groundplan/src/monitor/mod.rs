//! The dashboard of a running site: an ordinary subscriber to all topics.
//!
//! `state` turns samples into a `snapshot::Snapshot`; `screen` draws it; `map_pane` draws the map itself. This file
//! holds the bus, the terminal and the keys together.

mod map_pane;
mod screen;
mod snapshot;
mod state;
mod subscriptions;

use crate::failure::Failure;
use bus::{Bus, Daemon, HEARTBEAT_PERIOD, Waiter, Waker};
use daemon::{SiteConfig, StatusBoard, StopSignal};
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use screen::View;
use state::State;
use std::io::Write;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use subscriptions::Subscriptions;

/// A terminal is drawn, and a line is printed, at most this often.
const MIN_REDRAW_INTERVAL: Duration = Duration::from_millis(100);
/// Ages on the screen are never older than this.
const MAX_REDRAW_INTERVAL: Duration = Duration::from_millis(500);

/// Shows a site until the user quits or the time is over; as JSON a line for each change.
///
/// # Errors
/// No terminal, a bus that refuses.
pub(crate) fn show_until(config: &SiteConfig, ends: Option<Instant>, json: bool) -> Result<(), Failure> {
    let stop = StopSignal::listen(false).map_err(Failure::work)?;
    let mut output = if json { Output::Lines } else { Output::screen()? };
    let shown = show(config, stop, ends, &mut output);
    output.close();
    shown
}

enum Output {
    Lines,
    Screen {
        terminal: Box<ratatui::DefaultTerminal>,
        view: View,
        keys: Receiver<Event>,
        waker: Arc<Mutex<Option<Waker>>>,
    },
}

impl Output {
    fn screen() -> Result<Self, Failure> {
        let terminal =
            ratatui::try_init().map_err(|e| Failure::work(format!("this is no terminal: {e}; try --json")))?;
        let waker: Arc<Mutex<Option<Waker>>> = Arc::default();
        let (pressed, keys) = channel();
        let of_thread = Arc::clone(&waker);
        let read = move || {
            while let Ok(event) = event::read() {
                if pressed.send(event).is_err() {
                    return;
                }
                of_thread.lock().unwrap_or_else(PoisonError::into_inner).iter().for_each(Waker::wake_up);
            }
        };
        std::thread::Builder::new().name("keys".to_owned()).spawn(read).map_err(Failure::work)?;
        Ok(Self::Screen { terminal: Box::new(terminal), view: View::default(), keys, waker })
    }

    /// From now on keys wake this waiter.
    fn wake_by_keys(&self, waiter: Option<&Waiter>) {
        if let Self::Screen { waker, .. } = self {
            *waker.lock().unwrap_or_else(PoisonError::into_inner) = waiter.map(Waiter::waker);
        }
    }

    /// Handles the keys; true if the user quits.
    fn take_keys(&mut self, n_storeys: usize) -> bool {
        let Self::Screen { view, keys, .. } = self else { return false };
        let mut quits = false;
        for key in keys.try_iter().filter_map(|event| event.as_key_event()).filter(|k| k.kind != KeyEventKind::Release)
        {
            match key.code {
                KeyCode::Char('q') | KeyCode::Esc => quits = true,
                KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => quits = true,
                KeyCode::Up | KeyCode::Right | KeyCode::Tab | KeyCode::Char('+') => view.next_storey(n_storeys),
                KeyCode::Down | KeyCode::Left | KeyCode::BackTab | KeyCode::Char('-') => {
                    view.previous_storey(n_storeys)
                }
                KeyCode::Char('k') => view.shows_keepout = !view.shows_keepout,
                _ => {}
            }
        }
        quits
    }

    fn show(&mut self, state: &State, subscriptions: Option<&Subscriptions>) -> Result<(), Failure> {
        let snapshot = state.snapshot();
        match self {
            Self::Lines => {
                let line = serde_json::to_string(&snapshot).map_err(Failure::work)? + "\n";
                std::io::stdout().write_all(line.as_bytes()).map_err(Failure::work)
            }
            Self::Screen { terminal, view, .. } => {
                let map = subscriptions.and_then(|a| a.map(view.storey));
                terminal.draw(|frame| screen::draw(frame, &snapshot, view, map.as_ref())).map_err(Failure::work)?;
                Ok(())
            }
        }
    }

    fn close(&self) {
        if matches!(self, Self::Screen { .. }) {
            ratatui::restore();
        }
    }
}

/// Goes from one generation of the bus to the next.
fn show(config: &SiteConfig, mut stop: StopSignal, ends: Option<Instant>, output: &mut Output) -> Result<(), Failure> {
    let domain = config.domain().map_err(Failure::usage)?;
    let mut state = State::new();
    let is_over = || ends.is_some_and(|ends| ends <= Instant::now());
    while !is_over() {
        match Bus::join(&domain, Daemon::Groundplan) {
            Ok((bus, mut waiter)) => {
                waiter.stop_on(stop.descriptor().map_err(Failure::work)?);
                output.wake_by_keys(Some(&waiter));
                state.joined(bus.generation());
                if run_generation(config, &bus, &mut waiter, ends, &mut state, output)? == End::Quit {
                    return Ok(());
                }
                output.wake_by_keys(None);
                state.left();
            }
            Err(why) => {
                state.no_bus(&daemon::chain(&why));
                output.show(&state, None)?;
                if stop.is_raised_within(MAX_REDRAW_INTERVAL) || output.take_keys(0) {
                    return Ok(());
                }
            }
        }
    }
    Ok(())
}

#[derive(PartialEq, Eq)]
enum End {
    Quit,
    Superseded,
}

fn run_generation(
    config: &SiteConfig,
    bus: &Bus,
    waiter: &mut Waiter,
    ends: Option<Instant>,
    state: &mut State,
    output: &mut Output,
) -> Result<End, Failure> {
    let mut subscriptions = Subscriptions::to(bus).map_err(Failure::work)?;
    let (mut drawn, mut is_new) = (Instant::now(), true);
    let mut board_read: Option<Instant> = None;
    loop {
        if board_read.is_none_or(|read| read.elapsed() >= HEARTBEAT_PERIOD) {
            board_read = Some(Instant::now());
            // Without a report the last one counts: heartbeats tell whether its daemon lives.
            let next = StatusBoard::of_site(config).ok().and_then(|board| daemon::next_state(&board));
            next.into_iter().for_each(|next| state.set_next_state(next));
        }
        is_new |= subscriptions.take(bus, state).map_err(Failure::work)?;
        let since = drawn.elapsed();
        // Lines are printed for changes; a screen also shows the passing time.
        let is_due = is_new && since >= MIN_REDRAW_INTERVAL
            || matches!(output, Output::Screen { .. }) && since >= MAX_REDRAW_INTERVAL;
        if is_due {
            output.show(state, Some(&subscriptions))?;
            (drawn, is_new) = (Instant::now(), false);
        }
        let rest = if is_new { MIN_REDRAW_INTERVAL } else { MAX_REDRAW_INTERVAL }.saturating_sub(drawn.elapsed());
        let rest = ends.map_or(rest, |ends| rest.min(ends.saturating_duration_since(Instant::now())));
        let wake = waiter.wait(rest).map_err(Failure::work)?;
        is_new |= wake.woken;
        if wake.stopped
            || output.take_keys(subscriptions.n_storeys())
            || ends.is_some_and(|ends| ends <= Instant::now())
        {
            return Ok(End::Quit);
        }
        if wake.superseded {
            return Ok(End::Superseded);
        }
    }
}
