//! Layout of the dashboard.

use super::map_pane::GridPixels;
use super::snapshot::Snapshot;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Row, Table};

/// The selection of the user.
#[derive(Debug, Default)]
pub(crate) struct View {
    pub(crate) storey: usize,
    pub(crate) shows_keepout: bool,
}

impl View {
    pub(crate) fn next_storey(&mut self, n_storeys: usize) {
        self.storey = (self.storey + 1) % n_storeys.max(1);
    }

    pub(crate) fn previous_storey(&mut self, n_storeys: usize) {
        self.storey = (self.storey + n_storeys.saturating_sub(1)) % n_storeys.max(1);
    }
}

const GOOD: Style = Style::new().fg(Color::Green);
const BAD: Style = Style::new().fg(Color::Red);

/// Draws everything; 80 columns and 24 rows are enough.
pub(crate) fn draw(frame: &mut Frame<'_>, snapshot: &Snapshot, view: &View, map: Option<&GridPixels<'_>>) {
    let n_storeys = snapshot.storeys.len() as u16;
    let n_errors = snapshot.errors.len().clamp(1, 3) as u16;
    let [head, body, errors, keys] = Layout::vertical([
        Constraint::Length(head_lines(snapshot).len() as u16),
        Constraint::Min(8),
        Constraint::Length(n_errors),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let [left, right] = Layout::horizontal([Constraint::Length(46), Constraint::Min(20)]).areas(body);
    let daemons_height = snapshot.daemons.len() as u16 + 1;
    let [daemons, storeys, topics] =
        Layout::vertical([Constraint::Length(daemons_height), Constraint::Max(n_storeys + 1), Constraint::Min(3)])
            .areas(left);
    frame.render_widget(Paragraph::new(head_lines(snapshot)), head);
    draw_daemons(frame, snapshot, daemons);
    draw_storeys(frame, snapshot, view, storeys);
    draw_topics(frame, snapshot, topics);
    draw_map(frame, snapshot, view, map, right);
    let lines: Vec<Line<'_>> = snapshot.errors.iter().map(|e| Line::styled(e.as_str(), BAD)).collect();
    frame.render_widget(Paragraph::new(lines), errors);
    let help = "q quit   arrows, tab: storey   k: keep-out";
    frame.render_widget(Paragraph::new(Line::from(help).dim()), keys);
}

fn head_lines(snapshot: &Snapshot) -> Vec<Line<'_>> {
    let (word, style) = match snapshot.verdict {
        "current" => ("maps are current", GOOD),
        "overtaken" => ("a newer schedule state has no maps yet", Style::new().fg(Color::Yellow)),
        "hold" => ("stand still: maps are late", BAD),
        _ => (snapshot.why_no_map.as_deref().unwrap_or("no map"), BAD),
    };
    let plan_time_line = snapshot.plan_time_line.clone().unwrap_or_default();
    let time = plan_time_line.plan_time.as_deref().unwrap_or("everything built").to_owned();
    let robot = snapshot.robot.as_deref().unwrap_or("none");
    let first =
        Line::from(vec![time.bold(), "  ".into(), Span::styled(word, style), format!("  robot {robot}").into()]);
    let none = || "never".to_owned();
    let (since, next) =
        (plan_time_line.valid_from.unwrap_or_else(none), plan_time_line.valid_until.unwrap_or_else(none));
    let second = Line::from(format!("last change {since}, next {next}, {} in all", plan_time_line.changes)).dim();
    let third = snapshot.alignment.as_ref().map(|alignment| {
        let style = if alignment.is_effective() { Style::new() } else { BAD };
        Line::styled(alignment.to_string(), style)
    });
    [first, second].into_iter().chain(third).collect()
}

fn head_row<'a>(words: impl IntoIterator<Item = &'a str>) -> Row<'a> {
    Row::new(words.into_iter().map(str::to_owned)).style(Style::new().dim())
}

fn draw_daemons(frame: &mut Frame<'_>, snapshot: &Snapshot, area: Rect) {
    let rows = snapshot.daemons.iter().map(|d| {
        let state = if d.alive { d.activity } else { "silent" };
        let cells = [
            d.name.to_owned(),
            state.to_owned(),
            d.process_id.to_string(),
            format!("{} MB", d.memory_bytes / 1_000_000),
            d.restarts.to_string(),
        ];
        Row::new(cells).style(if d.alive && d.error.is_none() { GOOD } else { BAD })
    });
    let widths = [13, 10, 8, 7, 4].map(Constraint::Length);
    frame.render_widget(
        Table::new(rows, widths).header(head_row(["daemon", "activity", "process", "memory", "died"])),
        area,
    );
}

fn draw_storeys(frame: &mut Frame<'_>, snapshot: &Snapshot, view: &View, area: Rect) {
    // The chosen one stays in sight.
    let room = usize::from(area.height.saturating_sub(1)).max(1);
    let first = (view.storey + 1).saturating_sub(room);
    let rows = snapshot.storeys.iter().skip(first).map(|s| {
        let changed = s.changed_cells.map_or("-".to_owned(), |n| n.to_string());
        let row = Row::new([
            s.name.clone().unwrap_or_default(),
            changed,
            format!("{:.0} m2", s.free_m2),
            s.epoch.to_string(),
        ]);
        if s.index == view.storey { row.style(Style::new().bold()) } else { row }
    });
    let widths = [18, 9, 9, 8].map(Constraint::Length);
    frame.render_widget(Table::new(rows, widths).header(head_row(["storey", "changed", "free", "epoch"])), area);
}

fn draw_topics(frame: &mut Frame<'_>, snapshot: &Snapshot, area: Rect) {
    let rows = snapshot.topics.iter().map(|t| {
        let latency = t.latency_ms.map_or("-".to_owned(), |ms| format!("{ms:.2} ms"));
        Row::new([t.topic.clone(), size(t.bytes), format!("{:.1}", t.rate_hz), latency, format!("{:.0} s", t.age_s)])
    });
    let widths = [14, 8, 4, 9, 7].map(Constraint::Length);
    frame.render_widget(Table::new(rows, widths).header(head_row(["topic", "size", "Hz", "latency", "age"])), area);
}

/// Bytes for people.
fn size(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{} kB", bytes / 1_000),
        _ => format!("{} MB", bytes / 1_000_000),
    }
}

fn draw_map(frame: &mut Frame<'_>, snapshot: &Snapshot, view: &View, map: Option<&GridPixels<'_>>, area: Rect) {
    let name = snapshot.storeys.get(view.storey).map_or("no map", |s| s.name.as_deref().unwrap_or("without a name"));
    let block = Block::bordered().title(name);
    let inside = block.inner(area);
    frame.render_widget(block, area);
    if let Some(map) = map {
        map.draw(inside, view.shows_keepout, frame.buffer_mut());
    }
}

#[cfg(test)]
mod tests {
    use super::super::snapshot::{DaemonLine, PlanTimeLine, StoreyLine, TopicLine};
    use super::*;
    use daemon::facts::{AlignmentSummary, Pose};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn snapshot() -> Snapshot {
        let daemon = |name, alive, restarts| DaemonLine {
            name,
            alive,
            activity: "published",
            process_id: 4711,
            restarts,
            memory_bytes: 25_400_000,
            silent_s: 0.3,
            error: None,
        };
        let topic = |topic: &str, bytes, latency_ms| TopicLine {
            topic: topic.to_owned(),
            epoch: 12,
            bytes,
            samples: 3,
            rate_hz: 0.2,
            age_s: 61.0,
            latency_ms,
        };
        let storey = |index, name: &str, changed_cells| StoreyLine {
            index,
            name: Some(name.to_owned()),
            epoch: 9,
            changed_cells,
            free_m2: 279.4,
            ..StoreyLine::default()
        };
        let at = |text: &str| Some(text.to_owned());
        Snapshot {
            bus_generation: Some(1),
            daemons: vec![
                daemon("ifc-ingest", true, 0),
                daemon("schedule-eval", true, 1),
                daemon("rasterize", false, 0),
            ],
            topics: vec![topic("site", 1_200_000, None), topic("grid/00", 1_375_000, Some(0.04))],
            plan_time_line: Some(PlanTimeLine {
                plan_time: at("2024-04-29T10:00:00"),
                valid_from: at("2024-04-29T08:00:00"),
                valid_until: None,
                changes: 31,
            }),
            verdict: "current",
            why_no_map: None,
            robot: at("default"),
            alignment: Some(AlignmentSummary {
                epoch: 5,
                verdict: "accepted".to_owned(),
                validity: "effective".to_owned(),
                state: "tracked".to_owned(),
                storey: Some(1),
                map_from_slam: Some(Pose::of([1.5, -20.25, 0.5])),
                is_waiting: false,
                holds: None,
            }),
            storeys: vec![storey(0, "Ground floor", Some(1234)), storey(1, "Upper floor", None)],
            errors: vec!["rasterize: no room".to_owned()],
        }
    }

    /// `UPDATE_GOLDEN=1` rewrites the text; a person reads the difference.
    #[test]
    fn the_screen_is_that_of_the_golden_text() {
        let mut terminal = Terminal::new(TestBackend::new(80, 24)).unwrap();
        let view = View { storey: 1, shows_keepout: false };
        terminal.draw(|frame| draw(frame, &snapshot(), &view, None)).unwrap();
        let buffer = terminal.backend().buffer();
        let rows = buffer.content().chunks(80).map(|row| {
            let text: String = row.iter().map(|cell| cell.symbol()).collect();
            text.trim_end().to_owned() + "\n"
        });
        let text: String = rows.collect();
        let golden = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/monitor.txt");
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::create_dir_all(golden.parent().unwrap()).unwrap();
            std::fs::write(&golden, &text).unwrap();
        }
        assert_eq!(text, std::fs::read_to_string(golden).unwrap_or_default(), "UPDATE_GOLDEN=1 rewrites it");
    }

    #[test]
    fn storeys_go_round() {
        let mut view = View::default();
        view.previous_storey(3);
        assert_eq!(view.storey, 2);
        view.next_storey(3);
        assert_eq!(view.storey, 0);
        view.next_storey(0);
        assert_eq!(view.storey, 0);
    }
}
