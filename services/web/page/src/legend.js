// The legend: what the colours of the layers that are switched on mean. Also the legend of the print.

import { h, show, byId } from "./dom.js";
import { hasLayer, onChange, state } from "./state.js";
import { featuresOf, roomState } from "./site.js";
import { inkOf } from "./draw_live.js";
import { COMPARED_INKS, ROOM_INKS } from "./draw_site.js";
import { t, word } from "./texts.js";
import { waypointKinds } from "./waypoint_kinds.js";

export function createLegend() {
  onChange(["layers", "storey", "slam", "slamShown", "deviations", "site", "doc", "from", "to", "compare", "task"], showLegend);
  showLegend();
}

const swatch = (ink, text, shape = "box") => {
  const sample = h("span", { class: `swatch swatch-${shape}`, "aria-hidden": "true" });
  sample.style.setProperty("--swatch", `var(--ink-${ink})`);
  return h("li", {}, sample, h("span", {}, text));
};

// Classes of the elements of the storey, in the order in which they are drawn.
function classesHere() {
  return new Set(
    featuresOf(state.storey)
      .filter((f) => f.kind === "element")
      .map((f) => f.class),
  );
}

// The three states that rooms have, and that of rooms of which nobody looked for a way, where there are any.
function roomStates() {
  const unjudged = featuresOf(state.storey).some((f) => f.kind === "room" && roomState(f.id) === "open");
  return ["reached", "no_way", "blocked", ...(unjudged ? ["open"] : [])];
}

// [ink, text, shape] of each entry of what is shown.
function entries() {
  const list = [];
  if (hasLayer("planning"))
    list.push(["map-occupied", t("l_occupied")], ["map-free", t("l_free")], ["map-unknown", t("l_unknown")]);
  if (hasLayer("semantic")) {
    for (const cls of classesHere()) list.push([`sem-${cls.replace("_", "-")}`, `${t("l_map")}: ${word("c", cls)}`]);
  }
  if (hasLayer("keepout")) list.push(["map-keepout", t("l_keepout")]);
  if (hasLayer("localization")) list.push(["map-localization", t("l_localization")]);
  if (hasLayer("rooms"))
    list.push(...roomStates().map((at) => [ROOM_INKS[at], `${t("room")}: ${word("l_room", at)}`]));
  if (hasLayer("elements")) {
    const classes = classesHere();
    if (classes.has("door")) list.push(["door-open", t("l_doorOpen")], ["door-closed", t("l_doorClosed")]);
    classes.delete("door");
    for (const cls of classes)
      list.push([
        cls.replace("_", "-"),
        word("c", cls),
        cls === "slab" || cls === "beam" || cls === "other" ? "outline" : "box",
      ]);
    list.push(["in-progress", word("s", "in_progress")], ["not-started", word("s", "not_started"), "dashed"]);
  }
  for (const [kind, { layer, ink, mark }] of waypointKinds())
    if (hasLayer(layer)) list.push([ink, word("kind", kind), mark]);
  if (hasLayer("tour")) list.push(["tour", t("layer_tour"), "line"]);
  if (hasLayer("graph")) list.push(["graph", t("l_usable"), "line"], ["graph-unusable", t("l_unusable"), "dashline"]);
  if (state.from !== null && state.to !== null) list.push(["way", t("l_way"), "line"]);
  if (state.compare !== null)
    list.push(...Object.entries(COMPARED_INKS).map(([kind, ink]) => [ink, t(`l_${kind}`)]));
  else if (state.site.dates.length > 1) list.push(["changed", t("l_changed"), "halo"]);
  if (state.task !== null) list.push(["task", t("l_task"), "halo"]);
  if (state.slam && state.slamShown) list.push(["slam", t("slam")]);
  for (const verdict of new Set(Object.values(state.deviations?.elements ?? {}).map((told) => told.verdict))) {
    list.push([inkOf(verdict), `${t("deviation")}: ${word("v", verdict)}`]);
  }
  return list;
}

function showLegend() {
  const list = entries();
  for (const id of ["legend", "print-legend"])
    show(
      byId(id),
      list.map((entry) => swatch(...entry)),
    );
}
