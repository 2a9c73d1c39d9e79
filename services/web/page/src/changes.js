// What changed since the previous stop: from the calendar, or, where that is empty (live), from the two documents.
// The list groups elements by task; the plan shows a halo around each (draw_site.js).

import { byId, h, show } from "./dom.js";
import { link } from "./link.js";
import { onChange, state } from "./state.js";
import { noWayReason } from "./reasons.js";
import { element, nameOf, taskName } from "./site.js";
import { byName, shortDate, t, word } from "./texts.js";

const LISTED = 60; // elements of a task that are listed at once

let byStop = null; // stop -> {elements: [[id, before, after]], spaces: [[id, before, after]]}
let kept = { doc: null, changes: null, ids: new Set() };

export function createChanges() {
  onChange(["calendar", "site"], () => {
    byStop = null;
    kept = { doc: null, changes: null, ids: new Set() };
  });
  onChange(["doc", "calendar", "tab", "sheet"], showChanges);
  showChanges();
}

function fromCalendar(calendar) {
  const changes = [];
  for (const kind of ["elements", "spaces"]) {
    for (const [id, steps] of Object.entries(calendar[kind])) {
      for (let i = 1; i < steps.length; i++) {
        const [stop, after] = steps[i];
        changes[stop] ??= { elements: [], spaces: [] };
        changes[stop][kind].push([id, steps[i - 1][1], after]);
      }
    }
  }
  return changes;
}

function fromDocuments(before, after) {
  const changes = { elements: [], spaces: [] };
  const compare = (kind, ids, read) => {
    for (const id of ids) {
      const [was, is] = [read(before[kind], id), read(after[kind], id)];
      if (was !== is) changes[kind].push([id, was, is]);
    }
  };
  const ids = (kind) => new Set([...Object.keys(before[kind]), ...Object.keys(after[kind])]);
  compare("elements", ids("elements"), (states, id) => states[id] ?? "built");
  compare("spaces", ids("spaces"), (spaces, id) => spaces[id]?.state ?? "open");
  return changes;
}

const hasAny = (object) => {
  for (const _ in object) return true;
  return false;
};
export const hasCalendar = () =>
  state.calendar !== null && (hasAny(state.calendar.spaces) || hasAny(state.calendar.elements));

// Changes of the date shown, {since, elements, spaces}; null if there is nothing to compare it with. A live site is
// compared with what was shown before, because reports from the site change more than the calendar knows.
function currentChanges() {
  if (kept.doc === state.doc && kept.changes !== null) return kept.changes;
  const { doc, previousDoc, stop, site } = state;
  let changes = null;
  if (site.live && doc && previousDoc) {
    changes = { since: previousDoc.at, ...fromDocuments(previousDoc, doc) };
  } else if (doc && hasCalendar() && stop > 0) {
    byStop ??= fromCalendar(state.calendar);
    changes = { since: site.dates[stop - 1].at, elements: [], spaces: [], ...byStop[stop] };
  }
  const ids = new Set(changes ? [...changes.elements, ...changes.spaces].map(([id]) => id) : []);
  kept = { doc, changes, ids };
  return changes;
}

export function changedIds() {
  currentChanges();
  return kept.ids;
}

function showChanges() {
  if (state.tab !== "changes" && state.sheet !== "changes") return;
  const panel = byId("panel-changes");
  const changes = currentChanges();
  if (changes === null) {
    const why = state.site.live ? "changesLive" : state.stop === 0 ? "changesFirst" : "changesWait";
    show(panel, h("h2", {}, t("changes")), h("p", { class: "quiet" }, t(why)));
    return;
  }
  const nothing = changes.elements.length + changes.spaces.length === 0;
  show(
    panel,
    h("h2", {}, t("changes")),
    h("p", { class: "quiet" }, t("changesSince", { date: shortDate(changes.since) })),
    nothing ? h("p", {}, t("changesNone")) : null,
    rooms(changes.spaces, "reached", "roomsReached"),
    rooms(changes.spaces, "no_way", "roomsNoWay"),
    rooms(changes.spaces, "open", "roomsOpened"),
    rooms(changes.spaces, "blocked", "roomsClosed"),
    [...byTask(changes.elements)].map(([task, elements]) => taskBlock(task, elements)),
  );
}

function rooms(spaces, after, title) {
  const list = spaces.filter(([, , is]) => is === after);
  if (list.length === 0) return null;
  return h(
    "section",
    { class: "block" },
    h("h3", {}, t(title), h("span", { class: "count" }, String(list.length))),
    h(
      "ul",
      { class: "links" },
      list.map(([id]) => h("li", {}, link(id, nameOf(id), word("s", after), after, noWayReason(id)))),
    ),
  );
}

function byTask(elements) {
  const groups = new Map();
  for (const change of elements) {
    const task = element(change[0])?.schedule?.task ?? null;
    if (!groups.has(task)) groups.set(task, []);
    groups.get(task).push(change);
  }
  return new Map([...groups].sort(([a], [b]) => Number(a === null) - Number(b === null) || byName(String(a), String(b))));
}

function taskBlock(task, elements) {
  const items = elements
    .slice(0, LISTED)
    .map(([id, , after]) => h("li", {}, link(id, nameOf(id), word("s", after), after)));
  const title = task === null ? t("noTask") : `${t("task")} ${taskName(task)}`;
  const rest = elements.length - items.length;
  return h(
    "section",
    { class: "block" },
    h("h3", {}, title, h("span", { class: "count" }, String(elements.length))),
    h("ul", { class: "links" }, items, rest > 0 ? h("li", { class: "quiet" }, t("more", { n: rest })) : null),
  );
}
