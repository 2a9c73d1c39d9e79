// The panel of the room or the element selected. Without a selection: lists to choose from, so that the keyboard
// reaches what the pointer clicks.

import { byId, h, icon, show } from "./dom.js";
import { areasBlock } from "./areas.js";
import { elementDetails } from "./details_element.js";
import { link } from "./link.js";
import { roomDetails } from "./details_room.js";
import { onChange, state, update } from "./state.js";
import { noWayReason } from "./reasons.js";
import { elementState, featuresOf, nameOf, roomState, space } from "./site.js";
import { byName, t, word } from "./texts.js";
import { zoomTo } from "./plan.js";

const LISTED = 150;

export function createDetails() {
  const showDetails = (changed) => {
    if (state.tab !== "details" && state.sheet !== "details") return;
    if (state.select === null) showLists(changed);
    else showSelected(changed);
  };
  onChange(["select", "doc", "storey", "tab", "sheet", "deviations", "site", "about", "tasks", "summary"], showDetails);
  showDetails([]);
}

function showSelected(changed) {
  const panel = byId("panel-details");
  const { select: id } = state;
  const open = [.../** @type {NodeListOf<HTMLElement>} */ (panel.querySelectorAll("details[open]"))].map((node) => node.dataset.part);
  show(
    panel,
    h(
      "div",
      { class: "panel-top" },
      h(
        "button",
        { type: "button", class: "button small", onclick: () => update({ select: null }) },
        icon("back"),
        t("back"),
      ),
      h("button", { type: "button", class: "button small", onclick: () => zoomTo(id) }, icon("target"), t("zoomTo")),
    ),
    space(id) ? roomDetails(id) : elementDetails(id),
  );
  for (const part of open) panel.querySelector(`details[data-part="${part}"]`)?.setAttribute("open", "");
  if (changed.includes("select")) panel.scrollTop = 0;
}

// Rooms and elements of the storey, by name.
function showLists(changed) {
  const panel = byId("panel-details");
  const open = /** @type {HTMLDetailsElement | null} */ (panel.querySelector('details[data-part="elements"]'))?.open ?? false;
  const rooms = namesOf("room");
  const nElements = featuresOf(state.storey).filter((f) => f.kind === "element").length;
  // The long list is made when it is opened, not at every step in time.
  const elements = h("div", {}, open ? list(namesOf("element"), elementState) : null);
  const fillOnce = (event) =>
    event.target.open && elements.childElementCount === 0 && show(elements, list(namesOf("element"), elementState));
  const scroll = changed.includes("storey") || changed.includes("select") ? 0 : panel.scrollTop;
  show(
    panel,
    h("p", { class: "quiet" }, t("nothingSelected")),
    areasBlock(),
    h("h3", {}, t("roomsHere"), h("span", { class: "count" }, String(rooms.length))),
    list(rooms, roomState, noWayReason),
    h(
      "details",
      { class: "block", open, "data-part": "elements", ontoggle: fillOnce },
      h("summary", {}, t("elementsHere"), h("span", { class: "count" }, String(nElements))),
      elements,
    ),
  );
  panel.scrollTop = scroll;
}

/**
 * @param {"room" | "element"} kind
 * @returns {[string, string][]} GlobalIds and names
 */
function namesOf(kind) {
  /** @type {[string, string][]} */
  const names = featuresOf(state.storey)
    .filter((f) => f.kind === kind)
    .map(({ id }) => [id, nameOf(id)]);
  return names.sort(([, a], [, b]) => byName(a, b));
}

/**
 * @param {[string, string][]} items GlobalIds and names
 * @param {(id: string) => string} stateOf
 * @param {(id: string) => string | null} noteOf
 */
function list(items, stateOf, noteOf = () => null) {
  return h(
    "ul",
    { class: "links" },
    items.slice(0, LISTED).map(([id, name]) => h("li", {}, link(id, name, word("s", stateOf(id)), stateOf(id), noteOf(id)))),
    items.length > LISTED ? h("li", { class: "quiet" }, t("more", { n: items.length - LISTED })) : null,
  );
}
