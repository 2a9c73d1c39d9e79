// The print: an A3 sheet with the plan to a round scale, the title block, the legend and the north arrow; from the 3D view too,
// and then the sheet says so.
// Before a print the page takes the sheet's form on the screen, so that Leaflet draws the plan in its size.

import { byId, fact, h, show, svg } from "./dom.js";
import { drawForPrint } from "./drawing.js";
import { planMap } from "./plan.js";
import { state } from "./state.js";
import { storeyName, storeyOf } from "./site.js";
import { boundsOfStorey } from "./storey_bounds.js";
import { sheetReady } from "./tiles.js";
import { longDate, shortDate, t, today } from "./texts.js";

const SCALES = [20, 25, 50, 100, 200, 250, 500, 1000, 2000, 5000, 10000];
const PX_PER_M = 96 / 0.0254; // CSS pixels of a metre on paper
const TILES_WAIT_MS = 4000;

let before = null; // the view to come back to

export function createPrint() {
  byId("print").addEventListener("click", printSheet);
  window.addEventListener("beforeprint", layOut);
  window.addEventListener("afterprint", comeBack);
}

// With the button there is time to load the maps; Ctrl-P prints those that were loaded when the plan was shown.
async function printSheet() {
  layOut();
  const start = performance.now();
  while (!sheetReady() && performance.now() - start < TILES_WAIT_MS) await new Promise((next) => setTimeout(next, 50));
  drawForPrint();
  showBlock(scaleFor(planMap()));
  window.print();
  comeBack();
}

function layOut() {
  if (before !== null) return;
  const map = planMap();
  // A zoom that is under way ends at once: until then Leaflet keeps what is drawn in its old size.
  /** @type {any} */ (map)._onZoomTransitionEnd();
  const { theme } = document.documentElement.dataset;
  before = { center: map.getCenter(), zoom: map.getZoom(), theme };
  showTheme("light");
  document.body.classList.add("printing");
  map.invalidateSize({ pan: false, animate: false });
  const scale = scaleFor(map);
  // One pixel per cell at zoom 0: a cell is resolution / scale metres wide on paper.
  const zoom = Math.log2((state.site.resolution_m / scale) * PX_PER_M);
  moveTo(map, boundsOfStorey(storeyOf(state.storey)).getCenter(), zoom);
  showBlock(scale);
  drawForPrint();
}

// The largest round scale at which the storey fits into the plan's frame.
function scaleFor(map) {
  const size = map.getSize();
  const { size_cells: cells } = storeyOf(state.storey);
  const fits = (scale) =>
    cells.every((n, axis) => (n * state.site.resolution_m * PX_PER_M) / scale <= (axis === 0 ? size.x : size.y) - 8);
  return SCALES.find(fits) ?? SCALES.at(-1);
}

function comeBack() {
  if (before === null) return;
  const map = planMap();
  document.body.classList.remove("printing");
  map.invalidateSize({ pan: false, animate: false });
  moveTo(map, before.center, before.zoom);
  showTheme(before.theme);
  before = null;
}

// As Leaflet moves while it zooms by pinching: to any zoom at once, and tiles that are there stay. `setView` would
// throw them away, and a print does not wait for new ones.
function moveTo(map, center, zoom) {
  map._moveStart(true, false);
  map._move(center, zoom);
  map._moveEnd(true);
}

function showTheme(theme) {
  document.documentElement.dataset.theme = theme;
  document.dispatchEvent(new Event("themechange"));
}

function showBlock(scale) {
  const { site, doc, stop } = state;
  const at = doc ?? site.dates[stop ?? 0];
  const until = at.at === null ? null : at.until === null ? t("noLater") : t("until", { date: shortDate(at.until) });
  const files = (list) =>
    (list ?? []).map(({ file, sha256 }) => [file, sha256 ? ` (${sha256.slice(0, 12)})` : ""].join("")).join(", ");
  show(
    byId("print-block"),
    h("p", { class: "print-kind" }, t(state.view === "3d" ? "printPlanOf3d" : "printTitle")),
    sheetReady() ? null : h("p", { class: "print-missing" }, t("printMissing")),
    h("p", { class: "print-title" }, site.title),
    h(
      "dl",
      {},
      fact(t("storey"), storeyName(state.storey)),
      fact(t("printDate"), [longDate(at.at), until].filter(Boolean).join(", ")),
      fact(t("printScale"), `1 : ${scale} (A3)`),
      state.compare === null ? null : fact(t("compareWith"), longDate(state.compare)),
      fact(t("printLayers"), state.layers.map((layer) => t(`layer_${layer}`)).join(", ")),
      fact(t("printModel"), files(site.sources)),
      fact(t("printSchedule"), site.schedule_ignored ? t("scheduleIgnored") : files(site.schedule_sources)),
      fact(t("printRobot"), site.robot?.name),
      fact(t("printed"), today()),
    ),
    scaleBar(scale),
    h("p", { class: "print-maker" }, "groundplan"),
  );
}

const BAR_MM_MAX = 70;
const BAR_STEPS_M = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500];

// A bar of so many metres, in five parts, in its length on paper.
function scaleBar(scale) {
  const metres = BAR_STEPS_M.findLast((m) => (1000 * m) / scale <= BAR_MM_MAX) ?? BAR_STEPS_M[0];
  const mm = (1000 * metres) / scale;
  const part = (k) => svg("rect", { class: k % 2 === 0 ? "bar-dark" : "bar-light", x: 20 * k, y: 0, width: 20, height: 8 });
  const drawn = { height: "2.4mm", viewBox: "0 0 100 8", preserveAspectRatio: "none", role: "img" };
  return h(
    "div",
    { class: "scale-bar", "data-metres": metres, "data-mm": mm },
    svg("svg", { ...drawn, width: `${mm}mm`, "aria-label": t("scaleBar") }, [0, 1, 2, 3, 4].map(part)),
    h("span", {}, `${metres} m`),
  );
}
