// The map of the plan: Leaflet with one pixel per cell at zoom 0 (latlng is [y_m, x_m]), its controls, the
// coordinates under the pointer, and clicks on rooms, elements and waypoints.

import L from "leaflet";
import { byId } from "./dom.js";
import { createTiles } from "./tiles.js";
import { createDrawing } from "./drawing.js";
import { pick, pickWaypoint } from "./pick.js";
import { onChange, state, update } from "./state.js";
import { featuresOf, nameOf, storeyFor, storeyOf } from "./site.js";
import { boundsOfStorey } from "./storey_bounds.js";
import { say } from "./live.js";
import { measureAt } from "./measure.js";
import { elementsOfTask } from "./task_store.js";
import { number, t } from "./texts.js";
import { currentWay } from "./way.js";

const ZOOM_MAX = 4;

/** @type {import("leaflet").Map} */
let map = null;

// Pixels from metres as the tiles are cut: right from the left edge, down from the top edge.
function crsOf(site) {
  const [left, top] = site.tiles.origin_m;
  const perMetre = 1 / site.resolution_m;
  return L.Util.extend({}, L.CRS.Simple, {
    transformation: new L.Transformation(perMetre, -left * perMetre, -perMetre, top * perMetre),
    scale: (zoom) => 2 ** zoom,
    zoom: (scale) => Math.log2(scale),
  });
}

export function createPlan() {
  const container = byId("plan");
  map = L.map(container, {
    crs: crsOf(state.site),
    attributionControl: false,
    zoomControl: false,
    doubleClickZoom: false, // a second click goes on to what lies below
    zoomSnap: 0.25,
    zoomDelta: 0.75,
    wheelPxPerZoomLevel: 90,
    maxZoom: ZOOM_MAX,
    minZoom: -(state.site.tiles.levels + 1),
    maxBoundsViscosity: 0.8,
  });
  L.control.scale({ imperial: false, maxWidth: 140, position: "bottomleft" }).addTo(map);
  fitStorey();
  const isLinked = state.centre !== null;
  showPart();
  createTiles(map);
  createDrawing(map);
  wireControls();
  wirePointer();
  keepSize(container);
  onChange(["storey"], showStorey);
  onChange(["select", "sheet"], panToSelection);
  onChange(["from", "to", "sheet", "wayAnswer"], showWay);
  onChange(["task", "tasks"], panToTask);
  onChange(["picking"], () => container.classList.toggle("picking", state.picking !== null));
  onChange(["centre", "zoom"], showPart);
  map.on("moveend", keepPart);
  if (!isLinked) panToSelection();
  return map;
}

export const planMap = () => map;

let fitting = false; // while the map moves there
let fitted = null; // the view that shows all of the storey, while nobody has moved it

// Shows all of the storey, as large as it fits.
function fitStorey() {
  const snap = map.options.zoomSnap;
  fitting = true;
  map.options.zoomSnap = 0;
  map.fitBounds(boundsOfStorey(storeyOf(state.storey)), { padding: [6, 6], animate: false });
  map.options.zoomSnap = snap;
  fitting = false;
  fitted = { center: map.getCenter(), zoom: map.getZoom() };
}

function isFitted() {
  return fitted !== null && fitted.zoom === map.getZoom() && fitted.center.equals(map.getCenter(), 1e-6);
}

// Shows the part of the plan that a link names.
function showPart() {
  const { centre, zoom } = state;
  if (centre === null) {
    if (!isFitted()) fitStorey();
    return;
  }
  const wanted = L.latLng(centre[1], centre[0]);
  const at = zoom ?? map.getZoom();
  if (middleOf(map.getCenter()).equals(wanted, 2e-5) && Math.abs(map.getZoom() - at) < 2e-5) return;
  // Leaflet rounds down to whole pixels, of which the middle is one but for the last digits of its numbers.
  const inside = map.project(wanted, at).add([0.25, 0.25]);
  map.setView(map.unproject(inside, at), at, { animate: false });
}

// The middle of the plan whose corner lies on a whole pixel, as Leaflet draws it.
function middleOf(centre) {
  const half = map.getSize().divideBy(2);
  return map.unproject(map.project(centre).subtract(half).add([0.1, 0.1]).floor().add(half));
}

// Keeps the part of the plan that is seen, for links.
function keepPart() {
  if (fitting || document.body.classList.contains("printing") || map.getSize().x === 0) return;
  const { lat: y, lng: x } = middleOf(map.getCenter());
  // Fine enough that a link gives the same pixels.
  const round = (value) => Math.round(1e5 * value) / 1e5;
  if (isFitted()) update({ centre: null, zoom: null });
  else update({ centre: [round(x), round(y)], zoom: round(map.getZoom()) });
}

// A storey of another size may lie outside of the view; one that is in it keeps the view, to compare.
function showStorey() {
  const storey = boundsOfStorey(storeyOf(state.storey));
  map.setMaxBounds(storey.pad(1));
  if (isFitted() || !map.getBounds().intersects(storey)) fitStorey();
  keepPart();
}

function wireControls() {
  byId("zoom-in").addEventListener("click", () => map.zoomIn());
  byId("zoom-out").addEventListener("click", () => map.zoomOut());
  byId("fit").addEventListener("click", () => {
    fitStorey();
    keepPart();
  });
}

function wirePointer() {
  map.getContainer().addEventListener("keydown", (event) => {
    if (event.key === "Escape") update({ select: null, waypoint: null, picking: null });
  });
  const readout = byId("coordinates");
  let last = null;
  map.on("mousemove", ({ latlng }) => {
    const { lat: y, lng: x } = latlng;
    const hit = pick(x, y)[0] ?? null;
    const at = `x ${number(x, 2)}  y ${number(y, 2)} m`;
    readout.textContent = hit ? `${at}  ·  ${nameOf(hit.id)}` : at;
    map.getContainer().classList.toggle("over-feature", hit !== null || pickWaypoint(map, latlng) !== null);
  });
  map.on("mouseout", () => (readout.textContent = ""));
  map.getContainer().addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || !state.measuring) return;
    const { lat: y, lng: x } = map.getCenter();
    measureAt(x, y, metresPerPixel());
  });
  map.on("click", ({ latlng, containerPoint }) => {
    const { lat: y, lng: x } = latlng;
    if (state.measuring) {
      measureAt(x, y, metresPerPixel());
      return;
    }
    if (state.picking === "from-room" || state.picking === "to-room") {
      pickRoomAt(x, y, state.picking === "from-room" ? "from" : "to");
      return;
    }
    if (state.picking !== null) {
      update({ [state.picking]: `${x.toFixed(2)},${y.toFixed(2)},${state.storey}`, picking: null, tab: "way", sheet: "way" });
      return;
    }
    const waypoint = pickWaypoint(map, latlng);
    if (waypoint !== null) {
      update({ waypoint: waypoint.id, tab: "mission", sheet: state.sheet && "mission" });
      return;
    }
    // Clicks on the same spot go down through what lies there.
    const hits = pick(latlng.lng, latlng.lat);
    const again = last !== null && last.distanceTo(containerPoint) < 4;
    const now = hits.findIndex((hit) => hit.id === state.select);
    const hit = hits[again && now >= 0 ? (now + 1) % hits.length : 0] ?? null;
    last = containerPoint;
    update({ select: hit?.id ?? null, waypoint: null, tab: "details", sheet: hit ? "details" : null });
  });
}

const metresPerPixel = () => state.site.resolution_m / 2 ** map.getZoom();

// The end of a way is the room that is clicked.
function pickRoomAt(x, y, end) {
  const room = pick(x, y).find((hit) => hit.kind === "room");
  if (!room) say(t("noRoomThere"));
  else update({ [end]: room.id, picking: null, tab: "way", sheet: state.sheet && "way" });
}

// Elements of the task chosen: the storey with most of them, unless this one has any, and all of them in the view.
function panToTask() {
  if (state.task === null) return;
  const ids = elementsOfTask(state.task);
  const on = (storey) => featuresOf(storey).filter((f) => ids.has(f.id));
  let here = on(state.storey);
  if (here.length === 0) {
    const counts = state.site.storeys.map(({ index }) => ({ index, n: on(index).length }));
    const best = counts.reduce((a, b) => (b.n > a.n ? b : a));
    if (best.n === 0) return;
    update({ storey: best.index });
    here = on(best.index);
  }
  const box = here.reduce((all, { box: b }) => all.extend([b.y0, b.x0]).extend([b.y1, b.x1]), L.latLngBounds([]));
  const { free, covered } = visiblePart();
  const corners = [box.getNorthWest(), box.getSouthEast()].map((corner) => map.latLngToContainerPoint(corner));
  if (corners.every((corner) => free.contains(corner))) return;
  map.fitBounds(box.pad(0.1), { paddingBottomRight: [0, covered], maxZoom: map.getZoom() });
}

// A selection made elsewhere (search, lists, 3D) is brought into the view.
function panToSelection() {
  if (state.select === null) return;
  const storey = storeyFor(state.select);
  if (storey !== state.storey) update({ storey });
  const feature = featuresOf(storey).find((f) => f.id === state.select);
  if (!feature) return;
  const { x0, y0, x1, y1 } = feature.box;
  const box = L.latLngBounds([y0, x0], [y1, x1]);
  bringIntoView(box.getCenter());
}

// A way that was asked for is brought into the view as a whole, on the storey where it begins if it does not touch this one.
function showWay() {
  const way = currentWay();
  if (!way?.edges) return;
  if (!way.nodes.some((node) => node.storey === state.storey)) update({ storey: way.nodes[0].storey });
  const box = L.latLngBounds(
    way.nodes.filter((node) => node.storey === state.storey).map((node) => [node.y_m, node.x_m]),
  );
  const { free, covered } = visiblePart();
  const corners = [box.getNorthWest(), box.getSouthEast()].map((corner) => map.latLngToContainerPoint(corner));
  if (corners.every((corner) => free.contains(corner))) return;
  map.fitBounds(box.pad(0.1), { paddingBottomRight: [0, covered], maxZoom: map.getZoom() });
}

// Moves the plan if a point is outside of what is visible, that is, of the plan above an open sheet.
function bringIntoView(latlng) {
  const { free } = visiblePart();
  const point = map.latLngToContainerPoint(latlng);
  if (!free.contains(point)) map.panBy(point.subtract(free.getCenter()).round());
}

// Pixels of the plan that an open sheet covers, and the rectangle that is left.
function visiblePart() {
  const size = map.getSize();
  /** @type {HTMLElement | null} */
  const sheet = document.querySelector("[data-sheet=maps] #left, [data-sheet=tabs] #right");
  const covered = sheet !== null && getComputedStyle(byId("sheet-bar")).display !== "none" ? sheet.offsetHeight : 0;
  return { covered, free: L.bounds([24, 24], [size.x - 24, size.y - covered - 24]) };
}

export function zoomTo(id) {
  const feature = featuresOf(state.storey).find((f) => f.id === id);
  if (!feature) return;
  const { x0, y0, x1, y1 } = feature.box;
  map.fitBounds(L.latLngBounds([y0, x0], [y1, x1]).pad(0.8), {
    maxZoom: 1.5,
    paddingBottomRight: [0, visiblePart().covered],
  });
}

export function panTo(x, y) {
  bringIntoView(L.latLng(y, x));
}

// Panels open and close: the map follows its container, and a plan that showed everything still does.
function keepSize(container) {
  new ResizeObserver(() => {
    if (document.body.classList.contains("printing")) return;
    const whole = isFitted();
    map.invalidateSize({ pan: true, animate: false });
    if (whole) fitStorey();
    keepPart();
  }).observe(container);
}
