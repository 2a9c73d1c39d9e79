// The tasks: all of them or those at work in a window ahead of the date shown, each with its strip of a Gantt chart, and the one
// that is chosen with its progress, elements and rooms.

import { byId, h, show, svg } from "./dom.js";
import { link } from "./link.js";
import { elementState, nameOf, roomState } from "./site.js";
import { isolatedTask } from "./filter.js";
import { noteOfSource, progressOfTask, progressTable } from "./progress.js";
import { roomsBetween } from "./changes.js";
import { onChange, state, update } from "./state.js";
import { labelOf, summaryNow, taskOf } from "./task_store.js";
import { milliseconds, number, shortDate, t, word } from "./texts.js";

const LISTED = 300; // tasks, and elements of one
const WEEK_MS = 7 * 24 * 3600 * 1000;
const WEEKS = [1, 2, 4, 6];

let filterText = "";

export function createTasks() {
  onChange(["tasks", "task", "look", "doc", "summary", "tab", "sheet", "site", "calendar", "filter"], showTasks);
  showTasks();
}

function showTasks() {
  if (state.tab !== "tasks" && state.sheet !== "tasks") return;
  const panel = byId("panel-tasks");
  if (state.tasks === null) {
    show(panel, h("h2", {}, t("tasks")), h("p", { class: "quiet" }, t("loading")));
    return;
  }
  const chosen = state.task === null ? null : taskOf(state.task);
  const scroll = panel.scrollTop;
  show(panel, h("h2", {}, t("tasks")), chosen === null ? lists() : details(chosen));
  panel.scrollTop = chosen === null ? scroll : 0;
}

/** @returns {import("./dom.js").Child[]} */
function lists() {
  const { tasks, known_from: from } = state.tasks;
  const window = state.look === null ? null : windowOf(state.look);
  return [
    h(
      "div",
      { class: "row look", role: "group", "aria-label": t("tasks") },
      lookButton(null, t("tasksAll")),
      WEEKS.map((weeks) => lookButton(weeks, weeks === 1 ? t("nextWeek") : t("nextWeeks", { n: weeks }))),
    ),
    h("input", {
      type: "search",
      id: "task-filter",
      class: "text-field",
      "aria-label": t("tasksFilter"),
      placeholder: t("tasksFilter"),
      value: filterText,
      oninput: (event) => {
        filterText = event.target.value;
        show(byId("task-list"), rows(tasks, window));
      },
    }),
    from === "elements" && tasks.length > 0 ? h("p", { class: "quiet note" }, t("tasksOfElements")) : null,
    h("div", { id: "task-list" }, rows(tasks, window)),
    window === null ? null : roomsIn(window),
  ];
}

const lookButton = (weeks, text) =>
  h(
    "button",
    { type: "button", class: "button small", "aria-pressed": String(state.look === weeks), onclick: () => update({ look: weeks }) },
    text,
  );

// From the date shown on; null where everything is built.
function windowOf(weeks) {
  const at = state.doc?.at ?? null;
  if (at === null) return { from: null, to: null };
  const to = new Date(milliseconds(at) + weeks * WEEK_MS).toISOString().slice(0, 19);
  return { from: at, to };
}

/**
 * @param {import("./types.js").Task[]} tasks
 * @param {{from: string | null, to: string | null} | null} window
 * @returns {import("./dom.js").Child}
 */
function rows(tasks, window) {
  if (tasks.length === 0) return h("p", { class: "quiet" }, t("tasksNone"));
  if (window !== null && window.from === null) return h("p", { class: "quiet" }, t("lookNoDate"));
  const typed = filterText.trim().toLowerCase();
  const fits = (task) => typed === "" || labelOf(task).toLowerCase().includes(typed);
  let list = tasks.filter(fits);
  if (window !== null) {
    list = list.filter((task) => !task.is_summary && task.start !== null && task.start < window.to && task.finish > window.from);
    list.sort((a, b) => a.start.localeCompare(b.start));
  }
  const dated = list.filter((task) => task.start !== null && task.finish !== null);
  const [first, last] = window
    ? [window.from, window.to]
    : [dated.map((task) => task.start).sort()[0], dated.map((task) => task.finish).sort().at(-1)];
  const shown = list.slice(0, LISTED);
  return [
    window ? h("p", { class: "quiet note" }, t("lookFrom", span(window, list.length))) : null,
    list.length === 0 && window ? h("p", {}, t("lookNone")) : null,
    h("ul", { class: "links tasks" }, shown.map((task) => h("li", {}, row(task, window, first, last)))),
    list.length > shown.length ? h("p", { class: "quiet" }, t("tasksMore", { n: list.length - shown.length })) : null,
  ];
}

const span = ({ from, to }, n) => ({ from: shortDate(from), to: shortDate(to), n });

function row(task, window, first, last) {
  const status = summaryNow()?.tasks[task.global_id] ?? null;
  return h(
    "button",
    {
      type: "button",
      class: `link task depth-${window ? 0 : Math.min(task.depth, 4)}${task.is_summary ? " task-summary" : ""}`,
      "data-task": task.global_id,
      onclick: () => update({ task: task.global_id, select: null }),
    },
    h("span", { class: "link-name" }, labelOf(task), h("span", { class: "link-note" }, datesOf(task, window))),
    status === null ? null : h("span", { class: `tag tag-${status}` }, word("ts", status)),
    task.start !== null && task.finish !== null && first ? strip(task, status, first, last) : null,
  );
}

function datesOf(task, window) {
  if (task.start === null || task.finish === null) return t("noDates");
  const [from, to] = [shortDate(task.start), shortDate(task.finish)];
  if (window === null) return t("k_both", { from, to });
  const begins = window.from <= task.start;
  const ends = task.finish <= window.to;
  if (begins && ends) return t("k_both", { from, to });
  return begins ? t("k_begins", { date: from }) : ends ? t("k_ends", { date: to }) : t("k_goesOn");
}

// A bar from start to finish on the scale of the list, and a line at the date shown.
function strip({ start, finish, is_summary: summary }, status, first, last) {
  const span = milliseconds(last) - milliseconds(first) || 1;
  const place = (at) => Math.max(0, Math.min(1000, (1000 * (milliseconds(at) - milliseconds(first))) / span));
  const [x0, x1] = [place(start), place(finish)];
  const now = state.doc?.at ?? null;
  return svg(
    "svg",
    { class: "gantt", viewBox: "0 0 1000 10", preserveAspectRatio: "none", "aria-hidden": "true" },
    svg("rect", {
      class: `bar bar-${summary ? "summary" : (status ?? "plain")}`,
      x: x0.toFixed(1),
      width: Math.max(4, x1 - x0).toFixed(1),
      y: summary ? 3.5 : 1,
      height: summary ? 3 : 8,
    }),
    now !== null && first <= now && now <= last ? svg("path", { class: "gantt-now", d: `M${place(now).toFixed(1)} 0V10` }) : null,
  );
}

function roomsIn({ from, to }) {
  if (from === null) return null;
  const changes = roomsBetween(from, to);
  if (changes === null || changes.length === 0) return null;
  return h(
    "section",
    { class: "block" },
    h("h3", {}, t("lookRooms"), h("span", { class: "count" }, String(changes.length))),
    h(
      "ul",
      { class: "links" },
      changes
        .slice(0, LISTED)
        .map(({ id, at, after }) => h("li", {}, link(id, nameOf(id), word("s", after), after, shortDate(at)))),
    ),
  );
}

/** @param {import("./types.js").Task} task */
function details(task) {
  const status = summaryNow()?.tasks[task.global_id] ?? null;
  const elements = task.elements.filter((part) => Object.hasOwn(state.site.elements, part.global_id));
  const rooms = task.spaces.filter((room) => Object.hasOwn(state.site.spaces, room.global_id));
  const isIsolated = state.filter.task === task.global_id;
  return [
    h(
      "div",
      { class: "row" },
      h(
        "button",
        { type: "button", class: "button small", id: "tasks-back", onclick: () => update({ task: null }) },
        t("tasksBack"),
      ),
      h(
        "button",
        {
          type: "button",
          class: "button small",
          id: "task-isolate",
          "aria-pressed": String(isIsolated),
          onclick: () => update({ filter: isolatedTask(isIsolated ? null : task.global_id) }),
        },
        t("isolateTask"),
      ),
    ),
    h("p", { class: "kind" }, [t("task"), task.file].filter(Boolean).join(" · ")),
    h("h2", { id: "task-name" }, labelOf(task)),
    status === null ? null : h("p", {}, h("span", { class: `tag tag-${status}` }, word("ts", status))),
    h("h3", {}, t("progress")),
    progressTable(progressOfTask(task), task.completion === null ? null : `${number(100 * task.completion, 0)} %`),
    h("p", { class: "quiet note" }, noteOfSource(task)),
    task.warnings.length === 0 ? null : h("h3", {}, t("taskWarnings")),
    task.warnings.length === 0 ? null : h("ul", { class: "plain" }, task.warnings.map(({ message }) => h("li", {}, message))),
    partList("elementsOf", elements, elementState),
    partList("roomsClosedBy", rooms, roomState),
  ];
}

function partList(title, parts, stateOf) {
  if (parts.length === 0) return null;
  const rest = parts.length - LISTED;
  return h(
    "section",
    { class: "block" },
    h("h3", {}, t(title), h("span", { class: "count" }, String(parts.length))),
    h(
      "ul",
      { class: "links" },
      parts.slice(0, LISTED).map(({ global_id: id }) => h("li", {}, link(id, nameOf(id), word("s", stateOf(id)), stateOf(id)))),
      rest > 0 ? h("li", { class: "quiet" }, t("more", { n: rest })) : null,
    ),
  );
}

