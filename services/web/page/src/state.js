// The one store of the page: what is shown, what is loaded, and who wants to know of changes.
// The URL's fragment keeps what a link must carry: storey, date, layers, selection, view, tab, from and to, the part of the plan
// that is seen, the task, the look-ahead, the date compared with, filters and what is hidden, and in 3D the camera and the cut.

import { linkDate, stopValidAt } from "./link_date.js";

export const LAYERS = [
  "planning",
  "semantic",
  "keepout",
  "localization",
  "rooms",
  "elements",
  "waypoints",
  "scans",
  "tour",
  "graph",
];

export const TABS = ["details", "changes", "tasks", "way", "mission", "views", "findings"];

/** GlobalIds that a link holds of what is hidden or isolated. */
export const LINKED_MAX = 300;

/** @type {import("./types.js").Filter} */
export const NO_FILTER = { classes: [], states: [], task: null, storey: false };

/** @type {import("./types.js").State} what is shown, and what is loaded */
export const state = {
  site: null,
  calendar: null,
  doc: null,
  previousDoc: null,
  storey: null,
  date: null,
  stop: null,
  layers: ["planning", "rooms", "elements"],
  select: null,
  waypoint: null,
  view: "plan",
  centre: null,
  zoom: null,
  camera: null,
  cut: null,
  from: null,
  to: null,
  picking: null,
  about: null,
  wayAnswer: null,
  tab: "details",
  sheet: null,
  calendarOpen: false,
  playing: false,
  connected: true,
  full: false,
  status: null,
  robot: null,
  fleet: null,
  slam: null,
  slamShown: true,
  deviations: null,
  tasks: null,
  summary: null,
  task: null,
  look: null,
  compare: null,
  compareDoc: null,
  filter: NO_FILTER,
  hidden: [],
  only: [],
  byState: false,
  measuring: false,
  measured: [],
};

/** The longest look-ahead. */
export const LOOK_WEEKS_MAX = 12;

const listeners = [];
const queue = [];
let delivering = false;

/**
 * Calls `listener(changedKeys)` after an update that touches any of `keys`.
 * @param {(keyof import("./types.js").State)[]} keys
 * @param {(changed: string[]) => void} listener
 */
export function onChange(keys, listener) {
  listeners.push({ keys, listener });
}

/**
 * Changes the store. Updates made by listeners are delivered after the running one.
 * @param {Partial<import("./types.js").State>} patch
 */
export function update(patch) {
  const changed = Object.keys(patch).filter((key) => state[key] !== patch[key]);
  if (changed.length === 0) return;
  Object.assign(state, patch);
  queue.push(changed);
  if (delivering) return;
  delivering = true;
  try {
    while (queue.length > 0) deliver(queue.shift());
  } finally {
    delivering = false;
  }
}

function deliver(changed) {
  for (const { keys, listener } of listeners) {
    if (keys.some((key) => changed.includes(key))) listener(changed);
  }
}

export function hasLayer(layer) {
  return state.layers.includes(layer);
}

export function toggleLayer(layer, on) {
  update({ layers: LAYERS.filter((name) => (name === layer ? on : state.layers.includes(name))) });
}

/**
 * What the fragment says, as a patch; wrong values are left out.
 * @param {import("./types.js").Site} site
 */
export function fromFragment(site) {
  const fields = new URLSearchParams(location.hash.slice(1));
  /** @type {Partial<import("./types.js").State>} */
  const patch = {};
  const storey = Number(fields.get("storey"));
  if (fields.has("storey") && site.storeys.some((s) => s.index === storey)) patch.storey = storey;
  const stop = fields.has("date") && !site.live ? stopValidAt(site.dates, fields.get("date")) : null;
  if (stop !== null) patch.date = site.dates[stop].key;
  if (fields.has("layers")) {
    const wanted = fields.get("layers").split(",");
    patch.layers = LAYERS.filter((name) => wanted.includes(name));
  }
  if (fields.has("view")) patch.view = fields.get("view") === "3d" ? "3d" : "plan";
  const known = (id) => Object.hasOwn(site.elements, id) || Object.hasOwn(site.spaces, id);
  if (fields.has("select") && known(fields.get("select"))) patch.select = fields.get("select");
  for (const end of ["from", "to"]) if (isEnd(site, fields.get(end))) patch[end] = fields.get(end);
  if (TABS.includes(fields.get("tab"))) patch.tab = fields.get("tab");
  const words = (key) => (fields.get(key) ?? "").split(",").filter(Boolean).slice(0, LINKED_MAX);
  patch.task = fields.get("task");
  const look = Number(fields.get("look"));
  patch.look = Number.isInteger(look) && 1 <= look && look <= LOOK_WEEKS_MAX ? look : null;
  const compared = fields.has("compare") ? stopValidAt(site.dates, fields.get("compare")) : null;
  patch.compare = compared === null ? null : site.dates[compared].at;
  patch.filter = {
    classes: words("classes"),
    states: words("states"),
    task: fields.get("only-task"),
    storey: fields.get("only-storey") === "yes",
  };
  patch.hidden = words("hide").filter(known);
  patch.only = words("only").filter(known);
  patch.byState = fields.get("colours") === "states";
  const numbers = (key, n) => {
    const list = fields.has(key) ? fields.get(key).split(",").map(Number) : [];
    return list.length === n && list.every(Number.isFinite) ? list : null;
  };
  patch.centre = /** @type {[number, number] | null} */ (numbers("centre", 2));
  patch.zoom = patch.centre && (numbers("zoom", 1)?.[0] ?? null);
  patch.camera = numbers("camera", 6);
  patch.cut = numbers("cut", 1)?.[0] ?? null;
  return patch;
}

/**
 * Whether a way can begin or end there: at a room, or in a live site at a point of a storey.
 * @param {import("./types.js").Site} site
 * @param {string | null} end
 */
export function isEnd(site, end) {
  if (end === null) return false;
  const point = end.split(",").map(Number);
  const isPoint = site.live && point.length === 3 && point.every(Number.isFinite) && site.storeys.some((s) => s.index === point[2]);
  return isPoint || Object.hasOwn(site.spaces, end);
}

export function toFragment() {
  const fields = new URLSearchParams();
  fields.set("storey", String(state.storey));
  const shown = state.site.live ? state.doc : state.site.dates[state.stop];
  if (shown) fields.set("date", linkDate(shown.at));
  fields.set("layers", state.layers.join(","));
  for (const key of ["select", "from", "to"]) if (state[key] !== null) fields.set(key, state[key]);
  fields.set("view", state.view);
  if (state.tab !== "details") fields.set("tab", state.tab);
  if (state.task !== null) fields.set("task", state.task);
  if (state.look !== null) fields.set("look", String(state.look));
  if (state.compare !== null) fields.set("compare", linkDate(state.compare));
  const { filter } = state;
  const lists = { classes: filter.classes, states: filter.states, hide: state.hidden, only: state.only };
  for (const [key, list] of Object.entries(lists)) if (list.length > 0) fields.set(key, list.slice(0, LINKED_MAX).join(","));
  if (filter.task !== null) fields.set("only-task", filter.task);
  if (filter.storey) fields.set("only-storey", "yes");
  if (state.byState) fields.set("colours", "states");
  if (state.centre !== null) fields.set("centre", state.centre.join(","));
  if (state.centre !== null && state.zoom !== null) fields.set("zoom", String(state.zoom));
  if (state.view === "3d" && state.camera !== null) fields.set("camera", state.camera.join(","));
  if (state.view === "3d" && state.cut !== null) fields.set("cut", String(state.cut));
  // Commas, colons and the $ of GlobalIds are allowed in a fragment, and read better than %2C, %3A and %24.
  return `#${fields.toString().replaceAll("%2C", ",").replaceAll("%3A", ":").replaceAll("%24", "$")}`;
}

// Writes the fragment after every change of what it keeps, without filling the history.
// `onLink(date)` is told of a link that was followed in this page, with the date that it names.
export function keepFragment(onLink) {
  /** @type {(keyof import("./types.js").State)[]} */
  const kept = ["storey", "date", "stop", "doc", "layers", "select", "view", "tab", "from", "to", "centre", "zoom", "camera", "cut"];
  kept.push("task", "look", "compare", "filter", "hidden", "only", "byState");
  onChange(kept, () => {
    const fragment = toFragment();
    if (fragment !== location.hash) history.replaceState(null, "", fragment);
  });
  window.addEventListener("hashchange", () => {
    const cleared = { select: null, from: null, to: null, tab: "details" };
    if (location.hash === toFragment()) return;
    const date = new URLSearchParams(location.hash.slice(1)).get("date");
    update({ ...cleared, ...fromFragment(state.site) });
    onLink(date);
  });
}
