// Parts of a description: the heading with the state, and the properties of the model.

import { fact, h } from "./dom.js";
import { hide, isolate } from "./filter.js";
import { nameOf } from "./site.js";
import { t, word } from "./texts.js";

const VALUE_MAX = 400; // characters of a property that are shown

export function heading(id, kind, at) {
  return [
    h("p", { class: "kind" }, kind),
    h("h2", {}, nameOf(id)),
    at ? h("p", {}, h("span", { class: `tag tag-${at}` }, word("s", at))) : null,
  ];
}

/**
 * Buttons that hide a room or an element, or show it alone.
 * @param {string} id GlobalId
 */
export function shownButtons(id) {
  return h(
    "div",
    { class: "row" },
    h("button", { type: "button", class: "button small", onclick: () => hide(id) }, t("hide")),
    h("button", { type: "button", class: "button small", onclick: () => isolate(id) }, t("isolate")),
  );
}

export function properties(sets) {
  const list = Object.entries(sets ?? {});
  if (list.length === 0) return null;
  return h(
    "details",
    { class: "block", "data-part": "properties" },
    h("summary", {}, t("properties"), h("span", { class: "count" }, String(list.length))),
    list.map(([set, values]) => [
      h("h4", {}, set),
      h(
        "dl",
        { class: "facts" },
        Object.entries(values).map(([name, value]) => fact(name, valueText(value))),
      ),
    ]),
  );
}

export function valueText(value) {
  const text = value === null ? "–" : typeof value === "object" ? JSON.stringify(value) : String(value);
  return text.length > VALUE_MAX ? `${text.slice(0, VALUE_MAX)}…` : text;
}
