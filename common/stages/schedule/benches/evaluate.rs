//! A site of 100,000 elements and 10,000 tasks: from the archive to the timeline, and what a date costs then.
//!
//! Half of the tasks have written dates, the others wait for them with lags in working time; every tenth element has a
//! date in a property instead of a task. 1,000 spaces are bounded by 20 elements each.

use bytemuck::Zeroable;
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use messages::*;
use schedule::{Overrides, Period, Rules, Timeline, evaluate};
use std::hint::black_box;

const N_ELEMENTS: usize = 100_000;
const N_TASKS: usize = 10_000;
const N_SPACES: usize = 1_000;

fn site() -> ArchiveBuffer {
    let mut b = SiteBuilder::default();
    let file = b.texts.add("large.ifc");
    b.sources.push(SourceRecord { file, ..SourceRecord::zeroed() });
    add_calendar(&mut b);
    let start = b.texts.add("2024-01-01T08:00:00").into();
    b.schedule.work_controls.push(WorkControlRecord { start, ..WorkControlRecord::zeroed() });
    for k in 0..N_TASKS {
        add_task(&mut b, k);
    }
    let supertypes = b.texts.add_list(["IfcWallStandardCase", "IfcWall", "IfcBuildingElement", "IfcElement"]);
    let [set, name] = ["Wall Schedule", "ConstructionDate"].map(|t| b.texts.add(t));
    for k in 0..N_ELEMENTS {
        let first_attribute = b.attributes.len() as u32;
        let is_dated = k.is_multiple_of(10);
        if is_dated {
            let text = b.texts.add(&format!("{:02}/{:02}/2024", k % 28 + 1, k / 28 % 12 + 1));
            b.attributes.push(AttributeRecord {
                set,
                name,
                text,
                kind: AttributeKind::Text.into(),
                ..Zeroable::zeroed()
            });
        } else {
            let task = (k % N_TASKS) as u32;
            b.schedule.task_links.push(TaskLinkRecord {
                task,
                kind: LinkKind::Element.into(),
                target: k as u32,
                flags: 0,
            });
        }
        let global_id = b.texts.add(&format!("element-{k:014}"));
        b.elements.push(ElementRecord {
            global_id,
            supertypes,
            first_attribute,
            n_attributes: u32::from(is_dated),
            whole: NONE,
            storey: NONE,
            space: NONE,
            door: NONE,
            stair: NONE,
            ..ElementRecord::zeroed()
        });
    }
    for k in 0..N_SPACES {
        let global_id = b.texts.add(&format!("space-{k:016}"));
        b.spaces.push(SpaceRecord { global_id, map_storey: NONE, storey: NONE, ..SpaceRecord::zeroed() });
        let bounding = (0..20).map(|j| BoundaryRecord { space: k as u32, element: (k * 97 + j) as u32 });
        b.boundaries.extend(bounding);
    }
    b.finish()
}

fn add_calendar(b: &mut SiteBuilder) {
    b.schedule.periods_s.extend([[8 * 3600, 12 * 3600], [13 * 3600, 17 * 3600]]);
    b.schedule.work_times.push(WorkTimeRecord {
        first_day: i32::MIN,
        last_day: i32::MAX,
        kind: RecurrenceKind::Weekly.into(),
        weekdays: 0b11_1110,
        interval: 1,
        n_periods: 2,
        ..WorkTimeRecord::zeroed()
    });
    b.schedule.calendars.push(CalendarRecord { n_working: 1, ..CalendarRecord::zeroed() });
}

fn add_task(b: &mut SiteBuilder, k: usize) {
    let global_id = b.texts.add(&format!("task-{k:017}")).into();
    let duration = b.texts.add(&format!("P{}D", k % 5 + 1)).into();
    let mut task = TaskRecord {
        global_id,
        schedule_duration: duration,
        completion: -1.0,
        parent: NONE,
        duration_kind: DurationKind::WorkTime.into(),
        ..TaskRecord::zeroed()
    };
    if k.is_multiple_of(2) {
        task.schedule_start = b.texts.add(&format!("2024-{:02}-{:02}T08:00:00", k / 28 % 12 + 1, k % 28 + 1)).into();
    } else {
        // Chains of twenty, so that they end within the years of the calendar.
        for back in [1, 2, 7].into_iter().filter(|back| *back <= k % 40) {
            let lag = b.texts.add(if back == 2 { "PT4H" } else { "" }).into();
            b.schedule.sequences.push(SequenceRecord {
                lag,
                predecessor: (k - back) as u32,
                successor: k as u32,
                kind: SequenceKind::FinishStart.into(),
                lag_calendar: NONE,
                ..SequenceRecord::zeroed()
            });
        }
    }
    b.schedule.tasks.push(task);
}

fn benches(c: &mut Criterion) {
    let site = site();
    let site = Site::open(site.bytes()).expect("the site is whole");
    let rules = Rules::default();
    let timeline = || -> Timeline { evaluate(&site, &rules, &Overrides::default()).expect("its dates are clear") };
    let made = timeline();
    assert!(made.instants_s().len() > 1_000 && made.task(N_TASKS - 1).is_some(), "it is a schedule");
    let at_s = made.instants_s()[made.instants_s().len() / 2];

    let mut group = c.benchmark_group("100k elements, 10k tasks");
    group.throughput(Throughput::Elements(N_ELEMENTS as u64)).sample_size(20);
    group.bench_function("archive to timeline", |b| b.iter(|| black_box(timeline())));
    let mut states = vec![ElementState::NotStarted; N_ELEMENTS];
    group.bench_function("states of all elements at a date", |b| {
        b.iter(|| made.elements_at(black_box(at_s), &mut states))
    });
    group.bench_function("schedule state archive at a date", |b| {
        b.iter_batched(
            || (),
            |()| made.schedule_state(Period::instant(black_box(at_s))).finish(),
            BatchSize::LargeInput,
        );
    });
    group.sample_size(10);
    let simulated =
        || schedule::probabilities(&site, &rules, &Overrides::default(), &made).expect("there is room for the runs");
    group.bench_function("2,000 runs of the schedule", |b| b.iter(|| black_box(simulated().uncertainty().runs)));
    let probabilities = simulated();
    group.bench_function("state by probability at a date", |b| {
        b.iter(|| black_box(probabilities.schedule_state(Period::instant(black_box(at_s)))))
    });
    group.bench_function("safest days of all spaces", |b| {
        b.iter(|| black_box(probabilities.safest_days(at_s.div_euclid(86_400), 28, 5)))
    });
    group.finish();
}

criterion_group!(evaluation, benches);
criterion_main!(evaluation);
