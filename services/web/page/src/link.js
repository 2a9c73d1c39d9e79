// The line of a list that stands for a room or an element.

import { h } from "./dom.js";
import { state, update } from "./state.js";

/**
 * A button that selects a room or an element, with its state at the right.
 * `note` is a line below the name.
 * @param {string} id GlobalId
 * @param {string} name
 * @param {string | null} tag
 * @param {string | null} kind
 * @param {string | null} note
 */
export function link(id, name, tag = null, kind = null, note = null) {
  return h(
    "button",
    {
      type: "button",
      class: "link",
      onclick: () => update({ select: id, tab: "details", sheet: state.sheet && "details" }),
    },
    h("span", { class: "link-name" }, name, note === null ? null : h("span", { class: "link-note" }, note)),
    tag === null ? null : h("span", { class: `tag tag-${kind ?? "plain"}` }, tag),
  );
}
