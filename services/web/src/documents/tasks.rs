//! `tasks.json`: the tasks of the schedule with their dates, what they act on, and their progress.

use super::date::entries;
use answers::tasks::{Progress, TaskList, status_at};
use input_files::read_regular_file;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Bytes of the largest list of tasks that is read.
const MAX_TASKS_BYTES: u64 = 256 << 20;

/// The document.
#[derive(Debug, Serialize)]
pub(crate) struct TasksDocument {
    known_from: KnownFrom,
    tasks: Vec<ListedTask>,
    /// Planned, reported and observed dates; null where they are not known.
    progress: Option<Value>,
}

/// What the tasks are known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum KnownFrom {
    /// All of them.
    Schedule,
    /// Elements on the maps alone: neither tasks that act on none of them, nor rooms that tasks close.
    Elements,
}

/// What `groundplan tasks --json` prints, as far as the page needs it.
#[derive(Debug, Default, Deserialize)]
struct ListedTasks {
    tasks: Vec<ListedTask>,
}

#[derive(Debug, Default, Serialize, Deserialize)]
struct ListedTask {
    global_id: String,
    identification: Option<String>,
    name: Option<String>,
    file: Option<String>,
    parent: Option<String>,
    depth: usize,
    is_summary: bool,
    start: Option<String>,
    finish: Option<String>,
    dates_from: Option<String>,
    total_float_h: Option<f64>,
    completion: Option<f64>,
    elements: Vec<ListedElement>,
    spaces: Vec<ListedSpace>,
    warnings: Vec<ListedWarning>,
}

#[derive(Debug, Serialize, Deserialize)]
struct ListedElement {
    global_id: String,
    operation: String,
}

#[derive(Debug, Serialize, Deserialize)]
struct ListedSpace {
    global_id: String,
}

#[derive(Debug, Serialize, Deserialize)]
struct ListedWarning {
    message: String,
}

/// A file that is no list of tasks.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TasksFileError {
    /// It cannot be read.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is something else.
    #[error("{} is not what groundplan tasks --json prints", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
}

impl TasksDocument {
    /// Of the schedule in force.
    ///
    /// # Errors
    /// None that is known: the list is what this reads.
    pub(crate) fn of_schedule(list: &TaskList<'_>, progress: &Progress<'_>) -> Result<Self, serde_json::Error> {
        let listed = ListedTasks::deserialize(serde_json::to_value(list)?)?;
        let progress = Some(serde_json::to_value(progress)?);
        Ok(Self { known_from: KnownFrom::Schedule, tasks: listed.tasks, progress })
    }

    /// Of a file with what `groundplan tasks --json` prints.
    ///
    /// # Errors
    /// See [`TasksFileError`].
    pub(crate) fn of_file(path: &Path) -> Result<Self, TasksFileError> {
        let bytes = read_regular_file(path, MAX_TASKS_BYTES)
            .map_err(|source| TasksFileError::Io { path: path.to_owned(), source })?;
        let listed: ListedTasks =
            serde_json::from_slice(&bytes).map_err(|source| TasksFileError::Json { path: path.to_owned(), source })?;
        Ok(Self { known_from: KnownFrom::Schedule, tasks: listed.tasks, progress: None })
    }

    /// Of the elements of `semantic.json`, each of which names its last task.
    pub(crate) fn of_elements(semantic: &Value) -> Self {
        let mut tasks: BTreeMap<&str, ListedTask> = BTreeMap::new();
        for (id, element) in entries(semantic, "elements") {
            let schedule = &element["schedule"];
            let Some(task) = schedule["task"].as_str() else { continue };
            let text = |key: &str| schedule[key].as_str().map(str::to_owned);
            let removes = schedule["finish"].is_null() && !schedule["removal_finish"].is_null();
            let [start, finish] = if removes { ["removal_start", "removal_finish"] } else { ["start", "finish"] };
            let listed = tasks.entry(task).or_insert_with(|| ListedTask {
                global_id: task.to_owned(),
                name: text("task_name"),
                file: text("file"),
                dates_from: text("source"),
                total_float_h: schedule["total_float_h"].as_f64(),
                ..ListedTask::default()
            });
            let operation = if removes { "removes" } else { "constructs" };
            listed.elements.push(ListedElement { global_id: id.clone(), operation: operation.to_owned() });
            listed.start = [listed.start.take(), text(start)].into_iter().flatten().min();
            listed.finish = [listed.finish.take(), text(finish)].into_iter().flatten().max();
        }
        let mut tasks: Vec<ListedTask> = tasks.into_values().collect();
        tasks.sort_by(|a, b| (&a.start, &a.global_id).cmp(&(&b.start, &b.global_id)));
        Self { known_from: KnownFrom::Elements, tasks, progress: None }
    }

    /// Status of every task with dates at a date.
    pub(super) fn statuses(&self, at: &str) -> BTreeMap<&str, &'static str> {
        let dated = |task: &'_ ListedTask| Some(status_at(at, task.start.as_deref()?, task.finish.as_deref()?));
        self.tasks.iter().filter_map(|task| Some((task.global_id.as_str(), dated(task)?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn tasks_of_elements_have_the_dates_and_elements_of_all_that_name_them() {
        let element = |task: &str, start: &str, finish: &str| {
            let source = "task_schedule";
            json!({"schedule": {"task": task, "task_name": "Doors", "start": start, "finish": finish, "source": source}})
        };
        let gone = json!({"schedule": {"task": "9", "finish": null, "removal_start": "2024-02-01T08:00:00",
            "removal_finish": "2024-02-03T17:00:00"}});
        let semantic = json!({"elements": {"a": element("3.1", "2024-03-04T08:00:00", "2024-03-08T17:00:00"),
            "b": element("3.1", "2024-03-02T08:00:00", "2024-03-05T17:00:00"), "c": {"schedule": {"source": "none"}}, "d": gone}});
        let document = TasksDocument::of_elements(&semantic);
        let tasks = serde_json::to_value(&document).unwrap();
        assert_eq!((&tasks["known_from"], &tasks["progress"]), (&json!("elements"), &Value::Null));
        let facts = |task: &Value| json!([task["global_id"], task["start"], task["finish"], task["elements"]]);
        let elements = |ids: &[(&str, &str)]| -> Vec<Value> {
            ids.iter().map(|(id, operation)| json!({"global_id": id, "operation": operation})).collect()
        };
        assert_eq!(
            tasks["tasks"].as_array().unwrap().iter().map(facts).collect::<Vec<_>>(),
            [
                json!(["9", "2024-02-01T08:00:00", "2024-02-03T17:00:00", elements(&[("d", "removes")])]),
                json!([
                    "3.1",
                    "2024-03-02T08:00:00",
                    "2024-03-08T17:00:00",
                    elements(&[("a", "constructs"), ("b", "constructs")])
                ]),
            ]
        );
        let statuses = document.statuses("2024-03-02T08:00:00");
        assert_eq!(statuses, BTreeMap::from([("9", "finished"), ("3.1", "in_progress")]));
    }

    #[test]
    fn a_file_that_is_no_list_of_tasks_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tasks.json");
        std::fs::write(&path, "{\"task\": []}").unwrap();
        let told = TasksDocument::of_file(&path).unwrap_err().to_string();
        assert!(told.ends_with("tasks.json is not what groundplan tasks --json prints"), "{told}");
        assert!(matches!(TasksDocument::of_file(&folder.path().join("none")), Err(TasksFileError::Io { .. })));
    }
}
