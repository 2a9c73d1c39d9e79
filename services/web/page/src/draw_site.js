// Draws rooms, elements, what changed and what is selected.

import { hasLayer, state } from "./state.js";
import { elementState, featuresOf, isClosed, passageOf, roomState, space } from "./site.js";
import { changedIds, comparedKinds } from "./changes.js";
import { isShown } from "./filter.js";
import { elementsOfTask } from "./task_store.js";
import { labelPoint } from "./geometry.js";

const SMALL_PX = 1.5; // features smaller than this on the screen are left out

// Paths are made once, in metres from the tiles' origin, where single precision is fine enough.
function pathOf(feature) {
  if (feature.path) return feature.path;
  const [left, top] = state.site.tiles.origin_m;
  feature.path = new Path2D();
  for (const ring of feature.polygon.flat(1)) {
    ring.forEach(([x, y], i) =>
      i === 0 ? feature.path.moveTo(x - left, y - top) : feature.path.lineTo(x - left, y - top),
    );
    feature.path.closePath();
  }
  return feature.path;
}

function isVisible({ box }, pen) {
  const view = pen.box;
  if (box.x1 < view.x0 || box.x0 > view.x1 || box.y1 < view.y0 || box.y0 > view.y1) return false;
  return Math.max(box.x1 - box.x0, box.y1 - box.y0) * pen.scale >= SMALL_PX;
}

function visible(pen, kind) {
  return featuresOf(state.storey).filter((feature) => feature.kind === kind && isVisible(feature, pen) && isShown(feature.id));
}

// Inks of the states of rooms.
export const ROOM_INKS = { reached: "room-open", no_way: "room-no-way", blocked: "room-blocked", open: "room-unjudged" };

/** @param {import("./types.js").Pen} pen */
export function drawRooms(pen) {
  if (!hasLayer("rooms")) return;
  const { ctx } = pen;
  pen.metres();
  ctx.lineWidth = 1 / pen.scale;
  for (const feature of visible(pen, "room")) {
    ctx.fillStyle = pen.colour(ROOM_INKS[roomState(feature.id)]);
    ctx.strokeStyle = pen.colour("room-edge");
    ctx.fill(pathOf(feature), "evenodd");
    ctx.stroke(pathOf(feature));
  }
}

// Classes that lie over or under a room: only their outline, or they would hide everything.
const FLAT = new Set(["slab", "beam", "other"]);

/** @param {import("./types.js").Pen} pen */
export function drawElements(pen) {
  if (!hasLayer("elements")) return;
  const { ctx } = pen;
  pen.metres();
  for (const feature of visible(pen, "element")) {
    const style = styleOf(feature);
    if (style === null) continue;
    ctx.lineWidth = (feature.class === "door" ? 2 : 1) / pen.scale;
    ctx.setLineDash(style.dash ? [4 / pen.scale, 3 / pen.scale] : []);
    ctx.strokeStyle = pen.colour(style.ink);
    if (style.fill > 0) {
      ctx.globalAlpha = style.fill;
      ctx.fillStyle = pen.colour(style.ink);
      ctx.fill(pathOf(feature), "evenodd");
    }
    ctx.globalAlpha = style.line;
    ctx.stroke(pathOf(feature));
    ctx.globalAlpha = 1;
  }
  ctx.setLineDash([]);
}

function styleOf(feature) {
  const at = elementState(feature.id);
  const flat = FLAT.has(feature.class);
  if (at === "removed") return null;
  if (at === "not_started") return { ink: "not-started", fill: 0, line: flat ? 0.25 : 0.55, dash: true };
  if (at === "in_progress") return { ink: "in-progress", fill: flat ? 0.08 : 0.6, line: 1, dash: false };
  if (at === "being_removed") return { ink: "being-removed", fill: flat ? 0.08 : 0.6, line: 1, dash: true };
  if (feature.class === "door") {
    const closed = isClosed(passageOf(feature.id, state.storey));
    return { ink: closed ? "door-closed" : "door-open", fill: 0.75, line: 1, dash: false };
  }
  return { ink: feature.class.replace("_", "-"), fill: flat ? 0 : 0.45, line: flat ? 0.35 : 0.9, dash: false };
}

/**
 * A halo around what changed since the previous stop.
 * @param {import("./types.js").Pen} pen
 */
export function drawChanges(pen) {
  const kinds = comparedKinds();
  if (kinds !== null) {
    drawCompared(pen, kinds);
    return;
  }
  const ids = changedIds();
  if (ids.size === 0) return;
  outline(
    pen,
    featuresOf(state.storey).filter((f) => ids.has(f.id) && f.class !== "slab" && isVisible(f, pen)),
    "changed",
    3.5,
    0.85,
  );
}

/** Inks of what became of elements and rooms between two dates. */
export const COMPARED_INKS = { opened: "opened", closed: "closed", state: "changed", went: "went", came: "came" };

// Each kind in its colour: rooms below, flat elements by their outline alone.
function drawCompared(pen, kinds) {
  const seen = featuresOf(state.storey).filter((f) => kinds.has(f.id) && isVisible(f, pen) && isShown(f.id));
  for (const [kind, ink] of Object.entries(COMPARED_INKS)) {
    const of = seen.filter((f) => kinds.get(f.id) === kind);
    const isFlat = (f) => FLAT.has(f.class);
    outline(pen, of.filter(isFlat), ink, 1.5, 0.5);
    outline(pen, of.filter((f) => !isFlat(f)), ink, 2, 0.95, kind === "opened" || kind === "closed" ? 0.28 : 0.55);
  }
}

/**
 * The elements of the task chosen.
 * @param {import("./types.js").Pen} pen
 */
export function drawTask(pen) {
  if (state.task === null) return;
  const ids = elementsOfTask(state.task);
  outline(pen, featuresOf(state.storey).filter((f) => ids.has(f.id) && isShown(f.id)), "task", 3, 1, 0.35);
}

/** @param {import("./types.js").Pen} pen */
export function drawSelection(pen) {
  if (state.select === null) return;
  const features = featuresOf(state.storey).filter((f) => f.id === state.select);
  outline(pen, features, "selected-edge", 6, 1);
  outline(pen, features, "selected", 3, 1, 0.18);
}

export function outline(pen, features, ink, width, line, fill = 0) {
  const { ctx } = pen;
  pen.metres();
  ctx.lineJoin = "round";
  ctx.lineWidth = width / pen.scale;
  ctx.strokeStyle = ctx.fillStyle = pen.colour(ink);
  for (const feature of features) {
    ctx.globalAlpha = line;
    ctx.stroke(pathOf(feature));
    if (fill > 0) {
      ctx.globalAlpha = fill;
      ctx.fill(pathOf(feature), "evenodd");
    }
  }
  ctx.globalAlpha = 1;
  ctx.lineJoin = "miter";
}

/**
 * Names where they fit into the room: both lines, or the short one, or none.
 * @param {import("./types.js").Pen} pen
 */
export function drawLabels(pen) {
  if (!hasLayer("rooms")) return;
  const { ctx } = pen;
  pen.pixels();
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.lineJoin = "round";
  for (const feature of visible(pen, "room")) {
    const room = space(feature.id);
    feature.label ??= labelPoint(feature.polygon, feature.box);
    const { x, y, half, height } = feature.label;
    const lines = linesFor(ctx, room, 2 * half * pen.scale - 6, height * pen.scale - 4);
    lines.forEach(([text, font], k) => {
      ctx.font = font;
      ctx.strokeStyle = pen.colour("label-halo");
      ctx.lineWidth = 3;
      const line = pen.y(y) + (k - (lines.length - 1) / 2) * 14;
      ctx.strokeText(text, pen.x(x), line);
      ctx.fillStyle = pen.colour(k === 0 ? "label" : "label-second");
      ctx.fillText(text, pen.x(x), line);
    });
  }
}

const FAMILY = '"Segoe UI", Roboto, "Helvetica Neue", Arial, "Liberation Sans", sans-serif';

function linesFor(ctx, room, width, height) {
  const lines = [];
  const add = (text, font) => {
    ctx.font = font;
    if (text && ctx.measureText(text).width <= width && height >= 14 * (lines.length + 1)) lines.push([text, font]);
  };
  add(room.name, `600 12px ${FAMILY}`);
  add(room.long_name, `11px ${FAMILY}`);
  return lines;
}
