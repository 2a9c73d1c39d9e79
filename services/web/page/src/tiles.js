// Map layers as tiles named by the hash of their content: a tile that did not change is the same address and comes
// from the browser's cache. A step in time changes the addresses of the images in place, so nothing flickers.

import L from "leaflet";
import { hasLayer, onChange, state } from "./state.js";
import { loadDate, reloadIfChanged, tileUrl } from "./source.js";
import { storeyOf } from "./site.js";
import { boundsOfStorey } from "./plan.js";

const MAPS = ["planning", "semantic", "keepout", "localization"]; // drawn in this order

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

// True when every tile on the map has its picture: what a print waits for.
export function tilesReady() {
  return [...shown.values()].every((layer) => Object.values(layer._tiles).every(({ el }) => el.complete));
}
