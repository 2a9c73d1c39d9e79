//! Checks that hold for every plan that is read, whatever the bytes were.

use schedule_files::PlanFile;

/// Parents stand before what is nested in them, every index is one, and calendars are in order.
///
/// # Panics
/// If it does not hold.
pub(crate) fn check(plan: &PlanFile) {
    for (k, task) in plan.tasks.iter().enumerate() {
        assert!(task.parent.is_none_or(|parent| parent < k));
        assert!(task.calendar.is_none_or(|calendar| calendar < plan.calendars.len()));
        for share in [task.complete, task.physical_complete].into_iter().flatten() {
            assert!((0.0..=1.0).contains(&share));
        }
    }
    let n = plan.tasks.len();
    assert!(plan.dependencies.iter().all(|link| link.predecessor < n && link.successor < n));
    assert!(plan.findings.iter().all(|finding| finding.task.is_none_or(|task| task < n)));
    for calendar in &plan.calendars {
        assert!(calendar.exceptions.iter().all(|exception| exception.first <= exception.last));
        assert!(calendar.exceptions.is_sorted_by(|a, b| a.last < b.first));
        let days = calendar.week.iter().chain(calendar.exceptions.iter().map(|exception| &exception.periods_s));
        for day in days {
            assert!(day.iter().all(|[from, to]| from < to && *to <= 86_400) && day.is_sorted_by(|a, b| a[1] < b[0]));
        }
    }
}
