// The canvas over the tiles: rooms, elements, missions, ways and what is live, drawn by a list of painters.
// One canvas redrawn whole costs a few milliseconds for thousands of elements; nodes per element would not.

import L from "leaflet";
import { onChange, state } from "./state.js";
import { drawChanges, drawElements, drawLabels, drawRooms, drawSelection, drawTask } from "./draw_site.js";
import { drawMeasure } from "./draw_measure.js";
import { drawGraph, drawScan, drawTour, drawWaypoints, drawWay } from "./draw_mission.js";
import { drawSheet } from "./tiles.js";
import { drawDeviations, drawFleet, drawRobot, drawSlam } from "./draw_live.js";

const PAINTERS = [
  drawSheet,
  drawRooms,
  drawElements,
  drawSlam,
  drawChanges,
  drawTask,
  drawDeviations,
  drawScan,
  drawSelection,
  drawLabels,
  drawGraph,
  drawTour,
  drawWay,
  drawWaypoints,
  drawFleet,
  drawRobot,
  drawMeasure,
];

// Drawn by the processor: it is fast enough for what is drawn here, and without a graphics card a drawing by WebGL is slow.
const CPU = { willReadFrequently: true };
const PRINT_RATIO = 2.5; // 240 dots per inch on paper

/** @type {any} Leaflet's classes made by `extend` have no type */
let layer = null;
/** @type {Record<string, string>} */
let colours = {};

export function createDrawing(map) {
  readColours();
  layer = new Canvas({ padding: 0.2 });
  layer.addTo(map);
  onChange(
    [
      "doc",
      "storey",
      "layers",
      "select",
      "waypoint",
      "from",
      "to",
      "wayAnswer",
      "calendar",
      "robot",
      "fleet",
      "slam",
      "slamShown",
      "deviations",
      "compare",
      "task",
      "tasks",
      "filter",
      "hidden",
      "only",
      "measured",
    ],
    redraw,
  );
  document.addEventListener("themechange", () => {
    readColours();
    redraw();
  });
}

// Draws in the next frame, once for all changes until then.
let requested = 0;
export function redraw() {
  cancelAnimationFrame(requested);
  requested = requestAnimationFrame(() => layer?.paint());
}

// Draws at once, the maps too: tiles below would be cleared, because Chromium prints what was drawn just before as vectors, the
// clearing too, and they may not be there yet.
export function drawForPrint() {
  layer.paint();
}

// Colours come from the style sheet (`--ink-wall`), so that themes are kept in one place.
function readColours() {
  const style = getComputedStyle(document.documentElement);
  colours = new Proxy(
    {},
    {
      /** @type {(known: Record<string, string>, name: string) => string} */
      get: (known, name) => (known[name] ??= style.getPropertyValue(`--ink-${name}`).trim() || "#888"),
    },
  );
}

// Leaflet's own renderer base moves and scales the canvas while the map is dragged or zoomed; what is inside of it has no types.
/** @type {any} */
const Renderer = L.Renderer;
const Canvas = Renderer.extend({
  _initContainer() {
    this._container = document.createElement("canvas");
    this._container.setAttribute("aria-hidden", "true");
  },
  _destroyContainer() {
    this._container.remove();
    delete this._container;
  },
  _updatePaths() {},
  _update() {
    if (this._map._animatingZoom && this._bounds) return;
    Renderer.prototype._update.call(this);
    this.paint();
  },
  paint() {
    if (!this._map || !this._bounds) return;
    const canvas = this._container;
    const printing = document.body.classList.contains("printing");
    const ratio = printing ? PRINT_RATIO : Math.min(window.devicePixelRatio || 1, 2);
    const size = this._bounds.getSize();
    const [width, height] = [Math.round(size.x * ratio), Math.round(size.y * ratio)];
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
      canvas.style.width = `${size.x}px`;
      canvas.style.height = `${size.y}px`;
    }
    L.DomUtil.setPosition(canvas, this._bounds.min);
    const pen = penOf(this._map, canvas.getContext("2d", CPU), this._bounds, ratio);
    pen.pixels();
    pen.ctx.clearRect(0, 0, size.x, size.y);
    for (const painter of PAINTERS) painter(pen);
  },
});

/** @returns {import("./types.js").Pen} */
function penOf(map, ctx, bounds, ratio) {
  const [left, top] = state.site.tiles.origin_m;
  const scale = 2 ** map.getZoom() / state.site.resolution_m;
  const corner = map.getPixelOrigin().add(bounds.min);
  const size = bounds.getSize();
  const x = (metres) => (metres - left) * scale - corner.x;
  const y = (metres) => (top - metres) * scale - corner.y;
  return {
    ctx,
    scale,
    x,
    y,
    size,
    colour: (name) => colours[name],
    redraw,
    pixels: () => ctx.setTransform(ratio, 0, 0, ratio, 0, 0),
    metres: () => ctx.setTransform(scale * ratio, 0, 0, -scale * ratio, -corner.x * ratio, -corner.y * ratio),
    box: {
      x0: left + corner.x / scale,
      x1: left + (corner.x + size.x) / scale,
      y0: top - (corner.y + size.y) / scale,
      y1: top - corner.y / scale,
    },
  };
}
