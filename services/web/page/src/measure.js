// Measuring on the plan: two points, each on a corner of what is drawn nearby, else on a corner of a cell, and what lies between.

import { byId } from "./dom.js";
import { isShown } from "./filter.js";
import { featuresOf, nameOf } from "./site.js";
import { hasLayer, onChange, state, update } from "./state.js";
import { number, t } from "./texts.js";

const SNAP_PX = 14;

export function createMeasure() {
  byId("measure").addEventListener("click", () => update({ measuring: !state.measuring, measured: [], picking: null }));
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && state.measuring) update({ measuring: false, measured: [] });
  });
  onChange(["view"], () => update({ measuring: false, measured: [] }));
  onChange(["storey"], () => update({ measured: [] }));
  onChange(["measuring", "measured"], showMeasure);
  showMeasure();
}

/**
 * Takes a point of the plan; a third one begins anew.
 * @param {number} x metres
 * @param {number} y
 * @param {number} metresPerPixel
 */
export function measureAt(x, y, metresPerPixel) {
  const point = snapped(x, y, SNAP_PX * metresPerPixel);
  update({ measured: state.measured.length === 1 ? [state.measured[0], point] : [point] });
}

/** @returns {import("./types.js").MeasuredPoint} */
function snapped(x, y, within) {
  let best = null;
  let least = within;
  for (const feature of featuresOf(state.storey)) {
    const { box, kind, id } = feature;
    if (!hasLayer(kind === "room" ? "rooms" : "elements") || !isShown(id)) continue;
    if (x < box.x0 - within || x > box.x1 + within || y < box.y0 - within || y > box.y1 + within) continue;
    for (const ring of feature.polygon.flat(1)) {
      for (const [cx, cy] of ring) {
        const distance = Math.hypot(cx - x, cy - y);
        if (distance < least) [best, least] = [{ x: cx, y: cy, snap: "corner", of: id }, distance];
      }
    }
  }
  if (best !== null) return best;
  const cell = state.site.resolution_m;
  const [left, top] = state.site.tiles.origin_m;
  const near = (value, origin) => origin + Math.round((value - origin) / cell) * cell;
  return { x: near(x, left), y: near(y, top), snap: "cell", of: null };
}

/** Length between both points in metres; null before there are two. */
export function measuredLength() {
  const [a, b] = state.measured;
  return b === undefined ? null : Math.hypot(b.x - a.x, b.y - a.y);
}

const pointText = ({ snap, of }) => t(`snap_${snap}`, { name: of === null ? "" : nameOf(of) });

function showMeasure() {
  const { measuring, measured } = state;
  byId("measure").setAttribute("aria-pressed", String(measuring));
  byId("plan").classList.toggle("measuring", measuring);
  const [a, b] = measured;
  const length = measuredLength();
  const text = !a
    ? t("measureHint")
    : length === null
      ? t("measureSecond", { a: pointText(a) })
      : t("measured", { m: number(length, 2), a: pointText(a), b: pointText(b) });
  byId("measure-text").textContent = measuring ? text : "";
}
