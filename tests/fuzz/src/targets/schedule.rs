//! Schedules: tasks, times, sequences and calendars of an IFC file, under rules that may stand before it as TOML.

use super::site;
use messages::{ScheduleState, Site};
use schedule::{Delay, Overrides, Period, Rules, Timeline, evaluate, parse_actuals};

/// Instants at which a timeline is looked at.
const INSTANTS_MAX: usize = 6;

/// Evaluates the schedule of the file as planned, with a delay or with a report, and looks at schedule states of it.
pub fn run(bytes: &[u8]) {
    let begin = memchr::memmem::find(bytes, b"ISO-10303-21").unwrap_or(0);
    let (rules, file) = bytes.split_at(begin);
    let rules = std::str::from_utf8(rules).ok().and_then(|text| Rules::parse(text).ok()).unwrap_or_default();
    let Ok(site) = site::of_bytes(file) else { return };
    let site = Site::open(site.bytes()).expect("what was written can be read");
    if let Ok(timeline) = evaluate(&site, &rules, &overrides(&site, bytes.len())) {
        look(&site, &timeline);
    }
}

/// Nothing, a delay of the first task or a report of it; which of them is any function of the input.
fn overrides(site: &Site<'_>, choice: usize) -> Overrides {
    let first = site.schedule.tasks.first().map_or("", |task| site.schedule.text(task.global_id));
    match choice % 3 {
        0 => Overrides::default(),
        1 => Overrides { delays: Delay::parse(&format!("{first}=3d")).into_iter().collect(), ..Overrides::default() },
        _ => {
            let table = format!("id,start,finish\n{first},2024-03-05,\n");
            Overrides { actuals: parse_actuals(table.as_bytes()).unwrap_or_default(), ..Overrides::default() }
        }
    }
}

/// Asks a timeline for everything that products are made of.
fn look(site: &Site<'_>, timeline: &Timeline) {
    let instants_s = timeline.instants_s();
    assert!(instants_s.is_sorted());
    assert_eq!(timeline.changes().len(), instants_s.len());
    let _ = timeline.update_instants_s();
    for task in 0..site.schedule.tasks.len() {
        if let Some(dates) = timeline.task(task) {
            assert!(dates.start_s <= dates.finish_s, "a task ends before it starts");
        }
        let _ = timeline.float(task);
    }
    let ends = [i64::MIN, 0, i64::MAX];
    for at_s in instants_s.iter().copied().take(INSTANTS_MAX).chain(ends) {
        for until_s in [None, Some(at_s.saturating_add(86_400))] {
            let schedule_state = timeline.schedule_state(Period { from_s: at_s, until_s }).finish();
            let schedule_state = ScheduleState::open(schedule_state.bytes()).expect("what was written can be read");
            schedule_state.check_site(site).expect("it is of this site");
        }
    }
    let _ = timeline.everything_built().finish();
}
