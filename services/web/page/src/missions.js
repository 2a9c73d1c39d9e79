// The mission panel: coverage, duration, the stops of the tour.

import { byId, fact, h, show, svg } from "./dom.js";
import { onChange, state, update } from "./state.js";
import { nameOf } from "./site.js";
import { number, t, word } from "./texts.js";
import { panTo } from "./plan.js";
import { kindOf } from "./waypoint_kinds.js";

export function createMissions() {
  onChange(["doc", "tab", "sheet", "waypoint", "storey"], showMission);
  onChange(["waypoint"], goToWaypoint);
  // Ids belong to a date: the choice does not outlive it.
  onChange(["doc"], () => update({ waypoint: null }));
  showMission();
}

function goToWaypoint() {
  const waypoint = state.doc?.waypoints.find((w) => w.id === state.waypoint);
  if (!waypoint) return;
  const { layer } = kindOf(waypoint);
  const layers = state.layers.includes(layer) ? state.layers : [...state.layers, layer];
  update({ storey: waypoint.storey, layers });
  panTo(waypoint.x_m, waypoint.y_m);
}

function showMission() {
  if (state.tab !== "mission" && state.sheet !== "mission") return;
  const panel = byId("panel-mission");
  const { doc } = state;
  if (!doc || doc.waypoints.length === 0) {
    show(panel, h("h2", {}, t("mission")), h("p", { class: "quiet" }, t("missionNone")));
    return;
  }
  show(
    panel,
    h("h2", {}, t("mission")),
    figures(doc.mission),
    curve(doc.mission?.curve ?? []),
    h("h3", {}, t("tourList"), h("span", { class: "count" }, String(doc.waypoints.length))),
    h("ol", { class: "links tour" }, [...doc.waypoints].sort((a, b) => a.order - b.order).map(stop)),
  );
  const current = panel.querySelector('[aria-pressed="true"]');
  current?.scrollIntoView({ block: "nearest" });
}

const minutes = (seconds) => t("minutes", { n: number(seconds / 60, 0) });

function figures(mission) {
  if (!mission) return null;
  return h(
    "dl",
    { class: "facts" },
    fact(t("coverage"), mission.coverage === null ? null : `${number(100 * mission.coverage, 0)} %`),
    fact(t("missionScans"), String(mission.scans)),
    fact(t("missionTime"), minutes(mission.mission_s)),
    fact(t("missionDriving"), minutes(mission.driving_s)),
    fact(t("missionScanning"), minutes(mission.scanning_s)),
  );
}

// Coverage over the number of scans.
function curve(points) {
  if (points.length < 2) return null;
  const last = points.at(-1).scans;
  const path = points
    .map(({ scans, coverage }, i) => `${i === 0 ? "M" : "L"}${(280 * scans) / last} ${60 - 56 * coverage}`)
    .join(" ");
  return h(
    "figure",
    { class: "curve" },
    svg(
      "svg",
      { viewBox: "0 0 280 64", role: "img", "aria-label": t("missionCurve") },
      svg("path", { class: "curve-grid", d: "M0 4H280M0 32H280M0 60H280" }),
      svg("path", { class: "curve-line", d: path }),
    ),
    h("figcaption", {}, t("missionCurve")),
  );
}

function stop(waypoint) {
  const chosen = waypoint.id === state.waypoint;
  const notes = chosen
    ? [
        t("clearance", { m: number(waypoint.clearance_m, 2) }),
        kindOf(waypoint).sees_area ? t("covers", { m: number(waypoint.covers_m2) }) : null,
      ]
        .filter(Boolean)
        .join(" · ")
    : null;
  return h(
    "li",
    {},
    h(
      "button",
      {
        type: "button",
        class: "link",
        "aria-pressed": String(chosen),
        id: `waypoint-${waypoint.id}`,
        onclick: () => update({ waypoint: chosen ? null : waypoint.id }),
      },
      h("span", { class: `mark mark-${waypoint.kind}` }, String(waypoint.order + 1)),
      h(
        "span",
        { class: "link-name" },
        waypoint.space ? nameOf(waypoint.space) : (waypoint.name ?? t("outside")),
        h(
          "small",
          {},
          [word("kind", waypoint.kind), waypoint.leg_m ? t("leg", { m: number(waypoint.leg_m) }) : null]
            .filter(Boolean)
            .join(" · "),
        ),
        notes ? h("small", {}, notes) : null,
      ),
    ),
  );
}
