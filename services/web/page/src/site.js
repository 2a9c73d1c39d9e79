// Indexes of the site document: what lies on a storey, what things are called, which rooms lie beside a room,
// and in which state something is at the date shown.

import { areaOf, boundsOf } from "./geometry.js";
import { state } from "./state.js";
import { t } from "./texts.js";

/** @type {Map<number, import("./types.js").Feature[]>} by storey, lowest drawn first */
let features = new Map();
/** @type {Map<string, {door: string, room: string | null}[]> | null} by the GlobalId of a room */
let doorsBetween = null;

export function resetSite() {
  features = new Map();
  doorsBetween = null;
}

// Rooms first, then elements by class, so that what is small and asked for lies on top.
const DRAWN = [
  "slab",
  "beam",
  "other",
  "stair",
  "ramp",
  "furniture",
  "mep",
  "railing",
  "curtain_wall",
  "wall",
  "column",
  "window",
  "door",
];

/**
 * Features of a storey, lowest drawn first.
 * @param {number} storey
 */
export function featuresOf(storey) {
  let list = features.get(storey);
  if (!list) {
    list = collect(storey);
    features.set(storey, list);
  }
  return list;
}

/**
 * @param {number} storey
 * @returns {import("./types.js").Feature[]}
 */
function collect(storey) {
  const feature = (id, kind, cls, polygon) => ({
    id,
    kind,
    class: cls,
    polygon,
    box: boundsOf(polygon),
    area: areaOf(polygon),
    path: null,
    label: null,
  });
  const rooms = Object.entries(state.site.spaces)
    .filter(([, space]) => space.storey === storey && space.polygon_m?.length)
    .map(([id, space]) => feature(id, "room", "room", space.polygon_m));
  const elements = Object.entries(state.site.elements)
    .filter(([, element]) => element.footprints?.[storey]?.length)
    .map(([id, element]) => feature(id, "element", element.class, element.footprints[storey]));
  elements.sort((a, b) => DRAWN.indexOf(a.class) - DRAWN.indexOf(b.class));
  return [...rooms, ...elements];
}

/** @type {(id: string) => import("./types.js").SiteElement | null} */
export const element = (id) => (Object.hasOwn(state.site.elements, id) ? state.site.elements[id] : null);
/** @type {(id: string) => import("./types.js").Space | null} */
export const space = (id) => (Object.hasOwn(state.site.spaces, id) ? state.site.spaces[id] : null);
/** @type {(index: number) => import("./types.js").Storey | null} */
export const storeyOf = (index) => state.site.storeys.find((s) => s.index === index) ?? null;

/** @param {number} index */
export function storeyName(index) {
  const storey = storeyOf(index);
  return storey ? storey.name || `${t("storey")} ${index}` : "";
}

/**
 * "G.03 Server room"; the GlobalId where a model gives no name.
 * @param {string} id GlobalId
 */
export function nameOf(id) {
  const room = space(id);
  if (room) return [room.name, room.long_name].filter(Boolean).join(" ") || id;
  return element(id)?.name || id;
}

/**
 * A task as people know it: its name if the site document has it, else its id.
 * @param {string} task
 */
export function taskName(task) {
  const name = state.site.tasks?.[task]?.name;
  return name ? `${task} ${name}` : task;
}

/**
 * The storey on which something is best shown: the present one if it is there.
 * @param {string} id GlobalId
 */
export function storeyFor(id) {
  const room = space(id);
  if (room) return room.storey;
  const storeys = element(id)?.storeys ?? [];
  return storeys.includes(state.storey) ? state.storey : (storeys[0] ?? state.storey);
}

/** @param {string} id GlobalId */
export function elementState(id, doc = state.doc) {
  return doc?.elements[id] ?? "built";
}

/** @param {string} id GlobalId */
export function spaceState(id) {
  return state.doc?.spaces[id] ?? null;
}

/**
 * State of a room: "reached" and "no_way" where the schedule has it open, "blocked" by the schedule, "open" where nobody looked for a way.
 * @type {(id: string) => string}
 */
export const roomState = (id) => spaceState(id)?.state ?? "open";

/**
 * How the robot comes to a storey at the date shown; null where it does not.
 * @type {(storey: number) => string | null}
 */
export const entryOf = (storey) => state.doc?.entries?.[storey] ?? null;

/**
 * Whether a robot passes a door on a storey; null where the date says nothing.
 * @param {string} id GlobalId
 * @param {number} storey
 */
export function passageOf(id, storey) {
  const passages = state.doc?.passages?.[id];
  if (!passages) return null;
  return passages[storey] ?? Object.values(passages)[0] ?? null;
}

/**
 * A door that is not there yet leaves an opening.
 * @type {(passage: string | null) => boolean}
 */
export const isClosed = (passage) => passage !== null && passage !== "passable" && passage !== "absent";

/** @param {string} id GlobalId */
export function isStanding(id) {
  return !["not_started", "removed"].includes(elementState(id));
}

/**
 * Rooms beside a room, each with the door between (room: null leads outside).
 * @param {string} id GlobalId
 */
export function neighbours(id) {
  doorsBetween ??= collectDoors();
  return doorsBetween.get(id) ?? [];
}

/** @returns {Map<string, {door: string, room: string | null}[]>} */
function collectDoors() {
  const between = new Map();
  const add = (from, door, room) => {
    if (!from) return;
    if (!between.has(from)) between.set(from, []);
    between.get(from).push({ door, room });
  };
  for (const [id, door] of Object.entries(state.site.elements)) {
    if (!door.attributes?.spaces) continue;
    const [a, b] = door.attributes.spaces;
    add(a, id, b ?? null);
    if (a !== b) add(b, id, a ?? null);
  }
  return between;
}
