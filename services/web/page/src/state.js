// The one store of the page: what is shown, what is loaded, and who wants to know of changes.
// The URL's fragment keeps what a link must carry: storey, date, layers, selection, view, from and to.

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

export const state = {
  site: null, // data/site.json
  calendar: null, // data/calendar.json
  doc: null, // document of the date shown
  previousDoc: null, // the one shown before it (live: there the calendar may be empty)
  storey: null,
  date: null, // key of the date wanted; doc.key once it is loaded
  stop: null, // index into site.dates, null between the stops of a live site
  layers: ["planning", "rooms", "elements"],
  select: null, // GlobalId of a room or an element
  waypoint: null, // id of the waypoint chosen in the mission
  view: "plan",
  from: null,
  to: null,
  tab: "details",
  sheet: null, // phones: which panel is open below the plan
  calendarOpen: false,
  playing: false,
  connected: true, // live: what the events told last
  full: false, // live: there are too many viewers for this one
  status: null,
  robot: null,
  slam: null,
  slamShown: true,
  deviations: null,
};

const listeners = [];
const queue = [];
let delivering = false;

// Calls `listener(changedKeys)` after an update that touches any of `keys`.
export function onChange(keys, listener) {
  listeners.push({ keys, listener });
}

// Changes the store. Updates made by listeners are delivered after the running one.
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

// What the fragment says, as a patch; wrong values are left out.
export function fromFragment(site) {
  const fields = new URLSearchParams(location.hash.slice(1));
  const patch = {};
  const storey = Number(fields.get("storey"));
  if (fields.has("storey") && site.storeys.some((s) => s.index === storey)) patch.storey = storey;
  if (site.dates.some((d) => d.key === fields.get("date"))) patch.date = fields.get("date");
  if (fields.has("layers")) {
    const wanted = fields.get("layers").split(",");
    patch.layers = LAYERS.filter((name) => wanted.includes(name));
  }
  if (fields.has("view")) patch.view = fields.get("view") === "3d" ? "3d" : "plan";
  const known = (id) => Object.hasOwn(site.elements, id) || Object.hasOwn(site.spaces, id);
  if (fields.has("select") && known(fields.get("select"))) patch.select = fields.get("select");
  for (const end of ["from", "to"]) {
    if (fields.has(end) && Object.hasOwn(site.spaces, fields.get(end))) patch[end] = fields.get(end);
  }
  return patch;
}

export function toFragment() {
  const fields = new URLSearchParams();
  fields.set("storey", state.storey);
  if (state.date !== null) fields.set("date", state.date);
  fields.set("layers", state.layers.join(","));
  for (const key of ["select", "from", "to"]) if (state[key] !== null) fields.set(key, state[key]);
  fields.set("view", state.view);
  // Commas and the $ of GlobalIds are allowed in a fragment, and read better than %2C and %24.
  return `#${fields.toString().replaceAll("%2C", ",").replaceAll("%24", "$")}`;
}

// Writes the fragment after every change of what it keeps, without filling the history.
export function keepFragment() {
  onChange(["storey", "date", "layers", "select", "view", "from", "to"], () => {
    const fragment = toFragment();
    if (fragment !== location.hash) history.replaceState(null, "", fragment);
  });
  window.addEventListener("hashchange", () => {
    const cleared = { select: null, from: null, to: null };
    if (location.hash !== toFragment()) update({ ...cleared, ...fromFragment(state.site) });
  });
}
