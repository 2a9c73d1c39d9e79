// The line of a list that stands for a room or an element.

import { h } from "./dom.js";
import { state, update } from "./state.js";

// A button that selects a room or an element, with its state at the right.
export function link(id, name, tag = null, kind = null) {
  return h(
    "button",
    {
      type: "button",
      class: "link",
      onclick: () => update({ select: id, tab: "details", sheet: state.sheet && "details" }),
    },
    h("span", { class: "link-name" }, name),
    tag === null ? null : h("span", { class: `tag tag-${kind ?? "plain"}` }, tag),
  );
}
