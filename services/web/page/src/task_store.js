// Tasks of the site, loaded when somebody wants them, and which elements a task acts on.

import { say } from "./live.js";
import { onChange, state, update } from "./state.js";
import { loadSummary, loadTasks } from "./source.js";
import { t } from "./texts.js";

const SUMMARY_DELAY_MS = 150; // dates that are passed in play are not counted

let wanted = false;
let loads = 0;
/** @typedef {Map<string, string[]>} Lists of GlobalIds of tasks */
/** @type {{tasks: Map<string, import("./types.js").Task>, children: Lists, byElement: Lists, byRoom: Lists} | null} */
let index = null;

export function createTaskStore() {
  onChange(["site"], () => {
    index = null;
    kept = { tasks: null, ids: new Map() };
    loads += 1;
    if (state.tasks !== null) update({ tasks: null });
    if (wanted) load();
  });
  onChange(["tab", "sheet", "task", "filter", "select"], wantTasks);
  onChange(["doc"], countSoon);
  wantTasks();
  countSoon();
}

// Elements tell their tasks and progress, so that a selection wants them, too.
function wantTasks() {
  const isWanted = state.tab === "tasks" || state.task !== null || state.filter.task !== null || state.select !== null;
  if (!isWanted || wanted) return;
  wanted = true;
  load();
}

async function load() {
  const own = ++loads;
  try {
    const tasks = await loadTasks();
    if (own !== loads) return;
    index = null;
    update({ tasks });
  } catch (error) {
    wanted = false;
    say(t("failed", { what: error.message }));
  }
}

let timer = 0;
function countSoon() {
  clearTimeout(timer);
  timer = setTimeout(count, SUMMARY_DELAY_MS);
}

async function count() {
  const { doc } = state;
  if (doc === null || state.summary?.key === doc.key) return;
  try {
    const summary = await loadSummary(doc.key);
    if (state.doc?.key === doc.key) update({ summary: { key: doc.key, doc: summary } });
  } catch (error) {
    say(t("failed", { what: error.message }));
  }
}

/**
 * What was counted at the date shown; null until it is loaded.
 * @returns {import("./types.js").Summary | null}
 */
export const summaryNow = () => (state.summary !== null && state.summary.key === state.doc?.key ? state.summary.doc : null);

function indexed() {
  if (index !== null || state.tasks === null) return index;
  index = { tasks: new Map(), children: new Map(), byElement: new Map(), byRoom: new Map() };
  const add = (map, key, value) => {
    if (!map.has(key)) map.set(key, []);
    map.get(key).push(value);
  };
  for (const task of state.tasks.tasks) {
    index.tasks.set(task.global_id, task);
    if (task.parent !== null) add(index.children, task.parent, task.global_id);
    for (const part of task.elements) add(index.byElement, part.global_id, task.global_id);
    for (const room of task.spaces) add(index.byRoom, room.global_id, task.global_id);
  }
  return index;
}

/** @type {(id: string) => import("./types.js").Task | null} */
export const taskOf = (id) => indexed()?.tasks.get(id) ?? null;

/**
 * Tasks that act on an element; that of its dates while the tasks are not loaded.
 * @param {string} id GlobalId
 * @returns {string[]}
 */
export function tasksOfElement(id) {
  const own = state.site.elements[id]?.schedule?.task;
  return indexed()?.byElement.get(id) ?? (own ? [own] : []);
}

/**
 * Tasks that close a room while they are at work; none while the tasks are not loaded.
 * @param {string} id GlobalId
 * @returns {string[]}
 */
export const tasksOfRoom = (id) => indexed()?.byRoom.get(id) ?? [];

/** @type {{tasks: import("./types.js").Tasks | null, ids: Map<string, Set<string>>}} */
let kept = { tasks: null, ids: new Map() };

/**
 * GlobalIds of the elements that a task, or those nested in it, acts on.
 * @param {string | null} id GlobalId of a task
 * @returns {Set<string>}
 */
export function elementsOfTask(id) {
  if (id === null) return new Set();
  if (kept.tasks !== state.tasks) kept = { tasks: state.tasks, ids: new Map() };
  if (kept.ids.has(id)) return kept.ids.get(id);
  /** @type {Set<string>} */
  const ids = new Set();
  const known = indexed();
  if (known === null) {
    for (const [part, { schedule }] of Object.entries(state.site.elements)) if (schedule?.task === id) ids.add(part);
  } else {
    const open = [id];
    for (const task of open) {
      for (const part of known.tasks.get(task)?.elements ?? []) ids.add(part.global_id);
      open.push(...(known.children.get(task) ?? []));
    }
  }
  kept.ids.set(id, ids);
  return ids;
}

/** @param {import("./types.js").Task} task */
export const labelOf = ({ global_id: id, identification, name }) => {
  const words = [identification, name].filter((word, i, all) => word && all.indexOf(word) === i);
  return words.length > 0 ? words.join(" ") : id;
};
