// Dates of a task or an element as planned, reported and observed, in a table; what is not known on this page is said.

import { fact, h } from "./dom.js";
import { state } from "./state.js";
import { tasksOfElement } from "./task_store.js";
import { shortDate, t, word } from "./texts.js";

/** @typedef {{planned: string, reported: string, observed: string}} ProgressTexts */

// Dates that come from what people reported.
const REPORTED = new Set(["reported", "task_actual"]);

// Where progress is not known: in files, and on a robot that follows a server.
const unknown = () => t(state.site.live ? "notKnownServer" : "notKnownHere");

/** @param {import("./types.js").ProgressDates | null} dates */
function text(dates) {
  if (dates.start === "absent") return t("absentDate");
  const at = (date) => (date === null ? t("openEnd") : /^\d{4}-\d\d-\d\dT/.test(date) ? shortDate(date) : date);
  return `${at(dates.start)} – ${at(dates.finish)}`;
}

/**
 * @param {import("./types.js").Task} task
 * @returns {ProgressTexts}
 */
export function progressOfTask(task) {
  const { progress } = state.tasks;
  if (progress === null) return ofDates(task.start, task.finish, task.dates_from);
  const own = progress.tasks[task.global_id] ?? { planned: null, reported: null };
  return {
    planned: own.planned ? text(own.planned) : t("noDates"),
    reported: own.reported ? text(own.reported) : t("notReported"),
    observed: observedOf(task, progress),
  };
}

// A robot observes elements: how many of the task's, and what.
function observedOf(task, progress) {
  const seen = task.elements.map((part) => progress.elements[part.global_id]?.observed ?? null).filter(Boolean);
  if (seen.length === 0) return t("notObserved");
  return t("observedOf", { n: seen.length, of: task.elements.length });
}

// What files tell: the dates in force, and where they come from.
function ofDates(start, finish, source) {
  const dates = start || finish ? text({ start, finish }) : t("noDates");
  const isReported = REPORTED.has(source);
  return { planned: isReported ? unknown() : dates, reported: isReported ? dates : unknown(), observed: unknown() };
}

/**
 * @param {string} id GlobalId of an element
 * @returns {ProgressTexts}
 */
export function progressOfElement(id) {
  const { schedule } = state.site.elements[id];
  const progress = state.tasks?.progress ?? null;
  const start = schedule?.start ?? schedule?.removal_start ?? null;
  const finish = schedule?.finish ?? schedule?.removal_finish ?? null;
  const inForce = ofDates(start, finish, schedule?.source);
  if (progress === null) return inForce;
  const own = progress.elements[id];
  const ofTask = tasksOfElement(id).map((task) => progress.tasks[task]).find((task) => task?.reported);
  return {
    planned: own ? text(own.planned) : ofTask?.planned ? text(ofTask.planned) : inForce.planned,
    reported: own?.reported ? text(own.reported) : ofTask ? `${text(ofTask.reported)} (${t("ofTask")})` : t("notReported"),
    observed: own?.observed ? text(own.observed) : t("notObserved"),
  };
}

/**
 * @param {ProgressTexts} texts
 * @param {string | null} completion as a file has it
 */
export function progressTable({ planned, reported, observed }, completion = null) {
  return h(
    "dl",
    { class: "facts progress" },
    fact(t("planned"), planned),
    fact(t("reported"), reported),
    fact(t("observedDates"), observed),
    fact(t("completionOf"), completion),
  );
}

/** Where the dates in force of a task come from. */
export const noteOfSource = ({ start, finish, dates_from: from }) =>
  start === null ? "" : `${t("inForce")}: ${text({ start, finish })} (${word("f", from)})`;
