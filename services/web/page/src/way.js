// "Way from here to there": two rooms, the length and the doors passed, or what closes the way.

import { byId, h, icon, inputById, show } from "./dom.js";
import { findObstacles, findWay, nodesOf } from "./graph.js";
import { link } from "./link.js";
import { doorReasons, reachReason, roomReasons } from "./reasons.js";
import { onChange, state, update } from "./state.js";
import { element, nameOf, storeyName } from "./site.js";
import { byName, number, t, word } from "./texts.js";

let kept = { key: null, way: null };

export function createWay() {
  onChange(["from", "to"], () => {
    if (state.from !== null && state.to !== null) update({ tab: "way", sheet: state.sheet && "way" });
  });
  onChange(["site"], makePanel);
  onChange(["doc", "from", "to", "tab", "sheet", "site"], showWay);
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
 * The way asked for at the date shown: {length_m, edges, ...}, {obstacles} or null.
 * @returns {(Partial<import("./types.js").Way> & {obstacles?: import("./types.js").Obstacle[] | null}) | null}
 */
export function currentWay() {
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
  for (const end of ["from", "to"]) inputById(`way-${end}`).value = state[end] ?? "";
  show(byId("way-result"), result());
}

function chooser(end) {
  const rooms = Object.entries(state.site.spaces);
  const select = h(
    "select",
    { id: `way-${end}`, onchange: (event) => update({ [end]: event.target.value || null }) },
    h("option", { value: "" }, t("choose")),
    state.site.storeys.map((storey) => {
      const here = rooms.filter(([, room]) => room.storey === storey.index);
      if (here.length === 0) return null;
      const options = here.map(([id]) => h("option", { value: id }, nameOf(id)));
      options.sort((a, b) => byName(a.textContent, b.textContent));
      return h("optgroup", { label: storeyName(storey.index) }, options);
    }),
  );
  return h("label", { class: "field" }, h("span", {}, t(end)), select);
}

function result() {
  const { from, to } = state;
  if (from === null || to === null) return null;
  if (from === to) return h("p", {}, t("sameRoom"));
  const way = currentWay();
  if (way === null) return null;
  return way.edges ? found(way) : notFound(way.obstacles);
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
