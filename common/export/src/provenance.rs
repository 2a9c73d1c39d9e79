//! File and link rule of the dates that tasks of schedule files give.

use messages::{LinkKind, NONE, Site, TaskRecord};

/// Base name of the schedule file of a task; `None` for a task of the models.
pub fn schedule_file<'s>(site: &Site<'s>, task: &TaskRecord) -> Option<&'s str> {
    let source = site.schedule.sources.get(task.source as usize)?;
    Some(site.schedule.text(source.file))
}

/// The rule, or the row of the table, that links a task with an element or with what it is a part of; `None` for links of the models.
///
/// Links of schedule files are sorted by task, then elements before spaces, then by index.
pub fn link_rule<'s>(site: &Site<'s>, task: u32, element: u32) -> Option<&'s str> {
    let schedule = &site.schedule;
    // Wholes that are parts of themselves end after a round.
    let whole = |k: &u32| Some(site.elements[*k as usize].whole).filter(|whole| *whole != NONE);
    std::iter::successors(Some(element), whole).take(64).find_map(|target| {
        let key = (task, LinkKind::Element as u32, target);
        let of = |link: &messages::TaskLinkRecord| (link.task, link.kind.get() as u32, link.target);
        let at = schedule.task_links.partition_point(|link| of(link) < key);
        let is_it = schedule.task_links.get(at).is_some_and(|link| of(link) == key);
        schedule.link_rules.get(at).filter(|_| is_it).map(|rule| schedule.text(*rule))
    })
}
