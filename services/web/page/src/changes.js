// What changed since the previous stop: from the calendar, or, where that is empty (live), from the two documents; or since any
// other date that is chosen, from the calendar. The list groups elements by task; the plan shows a halo around each, and of
// two dates compared what came and what went in colours (draw_site.js).

import { byId, h, show } from "./dom.js";
import { link } from "./link.js";
import { onChange, state, update } from "./state.js";
import { noWayReason } from "./reasons.js";
import { element, nameOf, taskName } from "./site.js";
import { comparedStop, doorChanges, shownStop } from "./compare.js";
import { byName, milliseconds, shortDate, t, word } from "./texts.js";

const LISTED = 60; // elements of a task that are listed at once

let byStop = null; // stop -> {elements: [[id, before, after]], spaces: [[id, before, after]]}
/** @type {{doc: any, compare: string | null, changes: any, ids: Set<string>, kinds: Map<string, string>}} */
let kept = nothingKept();

export function createChanges() {
  onChange(["calendar", "site"], () => {
    byStop = null;
    kept = nothingKept();
  });
  onChange(["doc", "calendar", "tab", "sheet", "compare", "compareDoc"], showChanges);
  showChanges();
}

function nothingKept() {
  return { doc: null, compare: null, changes: null, ids: new Set(), kinds: new Map() };
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

const stateAt = (steps, stop) => steps.findLast(([since]) => since <= stop)?.[1] ?? steps[0][1];

// Of any two stops, whichever comes first.
function fromStops(calendar, before, after) {
  const changes = { elements: [], spaces: [] };
  for (const kind of ["elements", "spaces"]) {
    for (const [id, steps] of Object.entries(calendar[kind])) {
      const [was, is] = [stateAt(steps, before), stateAt(steps, after)];
      if (was !== is) changes[kind].push([id, was, is]);
    }
  }
  return changes;
}

// What a change of states comes to: of elements whether they stand, of rooms whether they are open.
function kindOf(was, is, isRoom) {
  if (isRoom) {
    if (is === "blocked" || (was === "reached" && is === "no_way")) return "closed";
    return "opened";
  }
  const [stood, stands] = [was, is].map((at) => at !== "not_started" && at !== "removed");
  return stood === stands ? "state" : stands ? "came" : "went";
}

/**
 * Rooms whose state changes after a date and until another, by date; null while the calendar is not there.
 * @param {string} from
 * @param {string} to
 * @returns {{id: string, at: string, after: string}[] | null}
 */
export function roomsBetween(from, to) {
  if (!hasCalendar()) return null;
  const { dates } = state.site;
  const list = [];
  for (const [id, steps] of Object.entries(state.calendar.spaces)) {
    for (const [stop, after] of steps.slice(1)) {
      const { at } = dates[stop];
      if (at !== null && from < at && at <= to) list.push({ id, at, after });
    }
  }
  return list.sort((a, b) => milliseconds(a.at) - milliseconds(b.at) || byName(nameOf(a.id), nameOf(b.id)));
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
  const { doc, previousDoc, stop, site, compare } = state;
  if (kept.doc === doc && kept.compare === compare && kept.changes !== null) return kept.changes;
  let changes = null;
  const [before, now] = [comparedStop(), shownStop()];
  if (before !== null) {
    if (doc && hasCalendar() && now !== null) changes = { since: compare, ...fromStops(state.calendar, before, now) };
  } else if (site.live && doc && previousDoc) {
    changes = { since: previousDoc.at, ...fromDocuments(previousDoc, doc) };
  } else if (doc && hasCalendar() && stop > 0) {
    byStop ??= fromCalendar(state.calendar);
    changes = { since: site.dates[stop - 1].at, elements: [], spaces: [], ...byStop[stop] };
  }
  /** @type {Map<string, string>} */
  const kinds = new Map();
  for (const [id, was, is] of changes?.elements ?? []) kinds.set(id, kindOf(was, is, false));
  for (const [id, was, is] of changes?.spaces ?? []) kinds.set(id, kindOf(was, is, true));
  kept = { doc, compare, changes, ids: new Set(kinds.keys()), kinds };
  return changes;
}

/**
 * Of two dates compared, what became of each room and element that changed: `came`, `went`, `state`, `opened`, `closed`.
 * @returns {Map<string, string> | null} null where no dates are compared
 */
export function comparedKinds() {
  if (state.compare === null) return null;
  currentChanges();
  return kept.kinds;
}

export function changedIds() {
  currentChanges();
  return kept.ids;
}

function showChanges() {
  if (state.tab !== "changes" && state.sheet !== "changes") return;
  const panel = byId("panel-changes");
  const changes = currentChanges();
  const head = [h("h2", {}, t("changes")), chooser()];
  if (changes === null) {
    const why = state.site.live ? "changesLive" : state.stop === 0 ? "changesFirst" : "changesWait";
    show(panel, head, h("p", { class: "quiet" }, t(why)));
    return;
  }
  if (state.compare !== null) {
    show(panel, head, compared(changes));
    return;
  }
  const nothing = changes.elements.length + changes.spaces.length === 0;
  show(
    panel,
    head,
    h("p", { class: "quiet" }, t("changesSince", { date: shortDate(changes.since) })),
    nothing ? h("p", {}, t("changesNone")) : null,
    rooms(changes.spaces, "reached", "roomsReached"),
    rooms(changes.spaces, "no_way", "roomsNoWay"),
    rooms(changes.spaces, "open", "roomsOpened"),
    rooms(changes.spaces, "blocked", "roomsClosed"),
    [...byTask(changes.elements)].map(([task, elements]) => taskBlock(task, elements)),
  );
}

// Any date to compare the one shown with.
function chooser() {
  const { dates } = state.site;
  if (dates.length < 2) return null;
  const select = h(
    "select",
    { id: "compare", onchange: (event) => update({ compare: event.target.value || null }) },
    h("option", { value: "" }, t("compareBefore")),
    dates.map(({ at }) => (at === null ? null : h("option", { value: at }, shortDate(at)))),
  );
  select.value = state.compare ?? "";
  return h("label", { class: "field" }, h("span", {}, t("compareWith")), select);
}

function compared(changes) {
  const { compare, doc } = state;
  const of = (kind) => changes.elements.filter(([id]) => kept.kinds.get(id) === kind);
  const doors = doorChanges();
  return [
    h("p", { class: "quiet note" }, t("compared", { from: shortDate(compare), to: shortDate(doc.at) })),
    comparedStop() === shownStop() ? h("p", {}, t("compareSame")) : null,
    rooms(changes.spaces, "reached", "roomsReached"),
    rooms(changes.spaces, "no_way", "roomsNoWay"),
    rooms(changes.spaces, "open", "roomsOpened"),
    rooms(changes.spaces, "blocked", "roomsClosed"),
    h("p", { class: "quiet note" }, t(doors === null ? "doorsNotCompared" : "doorsThatHang")),
    doorList(doors?.opened ?? [], "doorsOpened", "passable"),
    doorList(doors?.closed ?? [], "doorsClosed", "blocked"),
    ["came", "went", "changed"].map((kind) => kindBlock(kind, of(kind === "changed" ? "state" : kind))),
  ];
}

function doorList(doors, title, tag) {
  if (doors.length === 0) return null;
  return h(
    "section",
    { class: "block" },
    h("h3", {}, t(title), h("span", { class: "count" }, String(doors.length))),
    h("ul", { class: "links" }, doors.map(([id, , after]) => h("li", {}, link(id, nameOf(id), word("p", after), tag)))),
  );
}

// Elements of one kind, by task.
function kindBlock(kind, elements) {
  if (elements.length === 0) return null;
  return h(
    "details",
    { class: "block", open: true, "data-kind": kind },
    h(
      "summary",
      {},
      h("span", { class: `key key-${kind}` }),
      t(`ch_${kind}`),
      h("span", { class: "count" }, String(elements.length)),
    ),
    [...byTask(elements)].map(([task, list]) => taskBlock(task, list)),
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
