// What is open, in square metres: rooms by state and free cells of each storey and of all, as the server counted them.

import { h } from "./dom.js";
import { summaryNow } from "./task_store.js";
import { state } from "./state.js";
import { storeyName } from "./site.js";
import { number, t } from "./texts.js";

const ROWS = [
  ["reached", "areaReached"],
  ["no_way", "areaNoWay"],
  ["open", "areaOpen"],
  ["blocked", "areaBlocked"],
];

/** The table for the storey shown and the sum of all. */
export function areasBlock() {
  const summary = summaryNow();
  if (summary === null) return null;
  const here = summary.storeys[state.storey] ?? { free_m2: null, rooms: {} };
  const cell = (area) => h("td", {}, area === null || area === undefined ? "–" : t("m2", { n: number(area, 2) }));
  const rows = ROWS.filter(([key]) => summary.sum.rooms[key]);
  return h(
    "section",
    { class: "block", id: "areas" },
    h("h3", {}, t("areas")),
    h(
      "table",
      { class: "areas" },
      h("thead", {}, h("tr", {}, ["", storeyName(state.storey), t("areaSum")].map((text) => h("th", { scope: "col" }, text)))),
      h(
        "tbody",
        {},
        rows.map(([key, text]) =>
          h(
            "tr",
            { "data-area": key },
            h("th", { scope: "row" }, `${t("areaRooms")}: ${t(text)}`),
            cell(here.rooms[key]?.area_m2),
            cell(summary.sum.rooms[key].area_m2),
          ),
        ),
        h("tr", { "data-area": "free" }, h("th", { scope: "row" }, t("areaFree")), cell(here.free_m2), cell(summary.sum.free_m2)),
      ),
    ),
  );
}
