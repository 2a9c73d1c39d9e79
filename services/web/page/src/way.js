// "Way from here to there": two rooms, the length and the doors passed, or what closes the way. A live site answers it itself,
// also between points; of files it is found on the route graph.

import { answerLines, linesOf } from "./answer_text.js";
import { byId, h, icon, inputById, show } from "./dom.js";
import { findObstacles, findWay, nodesOf } from "./graph.js";
import { link } from "./link.js";
import { doorReasons, reachReason, roomReasons } from "./reasons.js";
import { onChange, state, update } from "./state.js";
import { element, nameOf, space, storeyName } from "./site.js";
import { byName, number, t, word } from "./texts.js";

let kept = { key: null, way: null };
/** @type {{of: import("./types.js").Told | null, way: import("./types.js").DrawnWay | null}} */
let drawn = { of: null, way: null };

export function createWay() {
  onChange(["from", "to"], () => {
    if (state.from !== null && state.to !== null) update({ tab: "way", sheet: state.sheet && "way" });
  });
  onChange(["site"], makePanel);
  onChange(["doc", "from", "to", "tab", "sheet", "site", "wayAnswer", "picking"], showWay);
  makePanel();
  showWay();
}

// The lists of rooms are long on large sites: they are made once, a step in time only changes the result.
function makePanel() {
  show(
    byId("panel-way"),
    h("h2", {}, t("wayHint")),
    h("div", { class: "way-ends" }, chooser("from"), chooser("to")),
    h(
      "div",
      { class: "row way-tools" },
      h(
        "button",
        { type: "button", class: "button", onclick: () => update({ from: state.to, to: state.from }) },
        icon("swap"),
        t("swap"),
      ),
      h("button", { type: "button", class: "button", onclick: () => update({ from: null, to: null }) }, t("clear")),
    ),
    h("div", { id: "way-result", "aria-live": "polite" }),
  );
}

/**
 * The way asked for at the date shown, as the plan draws it.
 * @returns {import("./types.js").DrawnWay | null}
 */
export function currentWay() {
  if (state.site.live) return answeredWay();
  const way = wayOfGraph();
  if (way === null) return null;
  const closed = (way.obstacles ?? []).flatMap((obstacle) => (obstacle.kind === "edge" ? [] : [obstacle.id]));
  return { edges: way.edges ?? null, nodes: way.nodes ?? [], closed };
}

// The way of the answer: legs over storeys, or what is missing.
function answeredWay() {
  const told = state.wayAnswer;
  if (drawn.of !== told) drawn = { of: told, way: told?.answer ? wayOf(told.answer) : null };
  return drawn.way;
}

/** @returns {import("./types.js").DrawnWay} */
function wayOf({ exists, legs, missing }) {
  const point = (storey, [x_m, y_m]) => ({ storey, x_m, y_m });
  const nodes = legs.flatMap((leg) => {
    const { storey, to_storey: next, points_m: points } = leg;
    return [point(storey, points[0]), ...points.slice(1, -1).map((p) => point(storey, p)), point(next, points.at(-1))];
  });
  const edges = legs.map((leg) => ({ edge: { line_m: leg.points_m.map(([x, y]) => [x, y]) }, storeys: [leg.storey, leg.to_storey] }));
  const closed = missing.flatMap((what) => what.global_id ?? []);
  return { edges: exists ? edges : null, nodes, closed };
}

/**
 * Of files: {length_m, edges, ...}, {obstacles} or null.
 * @returns {(Partial<import("./types.js").Way> & {obstacles?: import("./types.js").Obstacle[] | null}) | null}
 */
function wayOfGraph() {
  const { doc, from, to } = state;
  if (!doc?.graph || from === null || to === null || from === to) return null;
  const key = `${doc.key} ${from} ${to}`;
  if (kept.key !== key) {
    const way = findWay(doc.graph, from, to) ?? { obstacles: findObstacles(state.site, doc.graph, from, to) };
    kept = { key, way };
  }
  return kept.way;
}

function showWay() {
  if (state.tab !== "way" && state.sheet !== "way") return;
  for (const end of ["from", "to"]) showEnd(end);
  show(byId("way-result"), result());
}

// A point is a choice of its own, behind the rooms.
function showEnd(end) {
  const select = inputById(`way-${end}`);
  select.querySelector("[data-point]")?.remove();
  const at = state[end];
  if (at !== null && !space(at)) {
    const [x, y, storey] = at.split(",").map(Number);
    const name = t("point", { x: number(x, 2), y: number(y, 2), storey: storeyName(storey) });
    select.append(h("option", { value: at, "data-point": true }, name));
  }
  select.value = at ?? "";
  byId(`way-${end}-point`)?.setAttribute("aria-pressed", String(state.picking === end));
}

// The next click on the plan sets an end; of files only rooms are known.
function pointButton(end) {
  if (!state.site.live) return null;
  return h(
    "button",
    {
      type: "button",
      id: `way-${end}-point`,
      class: "button small",
      "aria-pressed": "false",
      onclick: () => update({ picking: state.picking === end ? null : end, sheet: null }),
    },
    icon("target"),
    t("pointOnPlan"),
  );
}

function chooser(end) {
  const rooms = Object.entries(state.site.spaces);
  const select = h(
    "select",
    { id: `way-${end}`, onchange: (event) => update({ [end]: event.target.value || null, picking: null }) },
    h("option", { value: "" }, t("choose")),
    state.site.storeys.map((storey) => {
      const here = rooms.filter(([, room]) => room.storey === storey.index);
      if (here.length === 0) return null;
      const options = here.map(([id]) => h("option", { value: id }, nameOf(id)));
      options.sort((a, b) => byName(a.textContent, b.textContent));
      return h("optgroup", { label: storeyName(storey.index) }, options);
    }),
  );
  return h("div", {}, h("label", { class: "field" }, h("span", {}, t(end)), select), pointButton(end));
}

function result() {
  const { from, to } = state;
  if (from === null || to === null) return null;
  if (from === to) return h("p", {}, t("sameRoom"));
  if (state.site.live) return answered(state.wayAnswer);
  const way = wayOfGraph();
  if (way === null) return null;
  return way.edges ? found(way) : notFound(way.obstacles);
}

/** @param {import("./types.js").Told | null} told */
function answered(told) {
  if (told === null) return null;
  const [first, ...rest] = linesOf(told);
  const isFound = told.answer?.exists === true;
  return [h("p", { class: isFound ? "figure figure-told" : "figure figure-bad" }, first), answerLines(rest)];
}

function found(way) {
  const storeys = way.nodes.map((node) => node.storey).filter((s, i, all) => all.indexOf(s) === i);
  return [
    h("p", { class: "figure" }, t("wayLength", { m: number(way.length_m) })),
    storeys.length > 1 ? h("p", { class: "quiet" }, storeys.map((s) => storeyName(s)).join(" → ")) : null,
    h("h3", {}, t("doorsPassed")),
    way.doors.length === 0
      ? h("p", { class: "quiet" }, t("noDoors"))
      : h(
          "ol",
          { class: "links" },
          way.doors.map((id) => h("li", {}, link(id, nameOf(id)))),
        ),
    h("h3", {}, t("roomsPassed")),
    h(
      "ol",
      { class: "links" },
      way.rooms.map((id) => h("li", {}, link(id, nameOf(id)))),
    ),
  ];
}

function notFound(obstacles) {
  const { doc, from, to } = state;
  const lines =
    obstacles === null
      ? [h("li", {}, t("notConnected"))]
      : obstacles.map((obstacle) => h("li", {}, obstacleLine(obstacle)));
  // Rooms that have no node at all: the page says why, in the words of the report.
  for (const room of [from, to]) {
    if (nodesOf(doc.graph, room).length > 0) continue;
    const reason = reachReason(room);
    const told = obstacles?.some((o) => o.kind === "door" || o.id === room);
    if (!told) lines.push(h("li", {}, t("notInGraph", { room: nameOf(room) }), reason ? `: ${reason}` : ""));
  }
  if (lines.length === 0 && reachReason(to)) lines.push(h("li", {}, reachReason(to)));
  return [h("p", { class: "figure figure-bad" }, t("noWay")), h("ul", { class: "plain" }, lines)];
}

function obstacleLine(obstacle) {
  if (obstacle.kind === "edge") {
    const { edge, a, b } = obstacle;
    const known = edge.of && element(edge.of) ? edge.of : null;
    const what = [word("e", edge.class), known && nameOf(known)].filter(Boolean).join(" ");
    const text = t("unusable", { what, a: nameOf(a), b: nameOf(b) });
    return known ? link(known, text) : text;
  }
  const { id } = obstacle;
  const why = obstacle.kind === "door" ? doorReasons(id, obstacle.passage) : roomReasons(id);
  const text = t(obstacle.kind === "door" ? "closes" : "blocks", { door: nameOf(id), room: nameOf(id), why });
  return h(
    "button",
    { type: "button", class: "link", onclick: () => update({ select: id }) },
    h("span", { class: "link-name" }, text),
  );
}
