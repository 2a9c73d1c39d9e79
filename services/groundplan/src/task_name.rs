//! Names of tasks in texts for people.

use messages::Site;

/// Identification and name of a task.
pub(crate) fn task_name(site: &Site<'_>, task: usize) -> String {
    let record = &site.schedule.tasks[task];
    let name = format!("{} {}", site.schedule.text(record.identification), site.schedule.text(record.name));
    if name.trim().is_empty() { site.schedule.text(record.global_id).to_owned() } else { name.trim().to_owned() }
}
