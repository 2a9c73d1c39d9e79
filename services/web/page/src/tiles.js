// Map layers as tiles named by the hash of their content: a tile that did not change is the same address and comes
// from the browser's cache. A step in time changes the addresses of the images in place, so nothing flickers.

import L from "leaflet";
import { hasLayer, onChange, state } from "./state.js";
import { loadDate, reloadIfChanged, tileUrl } from "./source.js";
import { storeyOf } from "./site.js";
import { boundsOfStorey } from "./storey_bounds.js";

const MAPS = ["planning", "semantic", "keepout", "localization"]; // drawn in this order

/** @type {any} what Leaflet's `extend` makes has no types */
const Tiles = L.GridLayer.extend({
  // `level` 0 is one pixel per cell; Leaflet counts zooms up, levels count down.
  createTile({ x, y, z }, done) {
    const image = document.createElement("img");
    image.alt = "";
    image.addEventListener("load", () => done(null, image));
    image.addEventListener("error", () => done(new Error("tile"), image));
    image.src = tileUrl(this.storey, this.name, this.hash, -z, x, y);
    return image;
  },
  showHash(hash) {
    this.hash = hash;
    for (const { coords, el } of Object.values(this._tiles)) {
      el.src = tileUrl(this.storey, this.name, hash, -coords.z, coords.x, coords.y);
    }
  },
});

let map = null;
const shown = new Map(); // layer name -> Tiles on the map

export function createTiles(leafletMap) {
  map = leafletMap;
  onChange(["doc", "storey", "layers"], showTiles);
  onChange(["doc", "storey", "layers"], keepSheet);
  keepSheet();
  showTiles();
}

function hashOf(doc, name) {
  return doc?.storeys.find((s) => s.index === state.storey)?.layers[name] ?? null;
}

function showTiles() {
  for (const [order, name] of MAPS.entries()) {
    const hash = hasLayer(name) ? hashOf(state.doc, name) : null;
    const layer = shown.get(name);
    if (layer && (hash === null || layer.storey !== state.storey)) {
      layer.remove();
      shown.delete(name);
    }
    if (hash === null) continue;
    if (shown.has(name)) {
      if (shown.get(name).hash !== hash) shown.get(name).showHash(hash);
    } else {
      shown.set(name, addLayer(name, hash, order));
    }
  }
}

function addLayer(name, hash, order) {
  const { size, levels } = state.site.tiles;
  const layer = new Tiles({
    tileSize: size,
    minNativeZoom: -(levels - 1),
    maxNativeZoom: 0,
    minZoom: -20,
    maxZoom: 20,
    bounds: boundsOfStorey(storeyOf(state.storey)),
    noWrap: true,
    zIndex: order + 1,
    className: `tiles-${name}`,
    keepBuffer: 1,
  });
  Object.assign(layer, { name, hash, storey: state.storey });
  if (!state.site.live) layer.on("tileerror", reloadIfChanged);
  return layer.addTo(map);
}

// Loads what the stops beside the present one would show here, so that a step finds everything in the cache.
export function prefetchStop(stop) {
  const date = state.site.dates[stop];
  if (!date) return;
  loadDate(date.key).then(
    (doc) => {
      for (const [name, layer] of shown) {
        const hash = hashOf(doc, name);
        if (hash === null || hash === layer.hash || layer.storey !== state.storey) continue;
        for (const { coords, current } of Object.values(layer._tiles)) {
          if (current) new Image().src = tileUrl(layer.storey, name, hash, -coords.z, coords.x, coords.y);
        }
      }
    },
    () => {},
  ); // the step itself tells that a date cannot be loaded
}

// The print's own tiles of the storey, kept loaded: Ctrl-P leaves a page no time to load any.
const SHEET_PX_MAX = 2560; // pixels of the longer side, enough for an A3 sheet
const SHEET_DELAY_MS = 300; // dates that are passed in play are not loaded
let sheet = { key: null, tiles: [] };
let sheetTimer = 0;

function keepSheet() {
  clearTimeout(sheetTimer);
  sheetTimer = setTimeout(loadSheet, SHEET_DELAY_MS);
}

// Asks for the tiles of the maps that are shown, unless they are there.
export function loadSheet() {
  const names = MAPS.filter((name) => hasLayer(name) && hashOf(state.doc, name) !== null);
  const key = [state.storey, ...names.map((name) => hashOf(state.doc, name))].join(" ");
  if (sheet.key === key) return;
  sheet = { key, tiles: names.flatMap((name) => tilesOfSheet(name, hashOf(state.doc, name))) };
}

// Tiles of a map at the level that suits the sheet: {image, x0, y0, x1, y1} in metres, lower left and upper right corner.
function tilesOfSheet(name, hash) {
  const { size, levels, origin_m: origin } = state.site.tiles;
  const { origin_m: corner, size_cells: cells } = storeyOf(state.storey);
  const { resolution_m: cell } = state.site;
  const needed = Math.ceil(Math.log2(Math.max(...cells) / SHEET_PX_MAX));
  const level = Math.max(0, Math.min(levels - 1, needed));
  const span = size * 2 ** level * cell;
  const place = (metres) => Math.floor(metres / span + 1e-6);
  const [x0, x1] = [corner[0], corner[0] + cells[0] * cell - cell / 2].map((x) => place(x - origin[0]));
  const [y0, y1] = [corner[1] + cells[1] * cell - cell / 2, corner[1] + cell / 2].map((y) => place(origin[1] - y));
  const tiles = [];
  for (let row = y0; row <= y1; row++) {
    for (let column = x0; column <= x1; column++) {
      const image = new Image();
      image.src = tileUrl(state.storey, name, hash, level, column, row);
      const [left, top] = [origin[0] + column * span, origin[1] - row * span];
      tiles.push({ image, x0: left, y0: top - span, x1: left + span, y1: top });
    }
  }
  return tiles;
}

/**
 * Draws the maps on the sheet.
 * @param {import("./types.js").Pen} pen
 */
export function drawSheet(pen) {
  if (!document.body.classList.contains("printing")) return;
  loadSheet();
  pen.pixels();
  pen.ctx.fillStyle = pen.colour("map-unknown");
  pen.ctx.fillRect(0, 0, pen.size.x, pen.size.y);
  pen.ctx.imageSmoothingEnabled = false;
  for (const { image, x0, y0, x1, y1 } of sheet.tiles) {
    if (image.naturalWidth === 0) continue;
    const [left, top] = [pen.x(x0), pen.y(y1)];
    pen.ctx.drawImage(image, left, top, pen.x(x1) - left, pen.y(y0) - top);
  }
}

// True when every tile of the sheet has its picture.
export function sheetReady() {
  loadSheet();
  return sheet.tiles.every(({ image }) => image.complete && image.naturalWidth > 0);
}
