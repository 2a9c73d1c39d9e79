// The switches of the filter beside the layers, and the note over the plan that says that not everything is shown.

import { byId, h, inputById, show } from "./dom.js";
import { isFiltering, isShown, showAll } from "./filter.js";
import { onChange, state, update } from "./state.js";
import { taskName } from "./site.js";
import { labelOf } from "./task_store.js";
import { byName, t, word } from "./texts.js";

let wasOn = false; // what is filtered is opened once, and may be closed
const STATES = ["not_started", "in_progress", "built", "being_removed", "removed"];

export function createFilterPanel() {
  byId("show-all").addEventListener("click", showAll);
  onChange(["site", "tasks"], makeSwitches);
  onChange(["filter", "hidden", "only", "byState", "site", "tasks"], showSwitches);
  onChange(["filter", "hidden", "only", "doc", "storey", "site", "tasks"], showNote);
  makeSwitches();
  showSwitches();
  showNote();
}

function makeSwitches() {
  const classes = [...new Set(Object.values(state.site.elements).map((part) => part.class))];
  classes.sort((a, b) => byName(word("c", a), word("c", b)));
  show(
    byId("filters"),
    group("filterClass", "classes", classes, "c"),
    group("filterState", "states", STATES, "s"),
    h(
      "label",
      { class: "field" },
      h("span", {}, t("filterTask")),
      h(
        "select",
        {
          id: "filter-task",
          onchange: (event) => update({ filter: { ...state.filter, task: event.target.value || null } }),
        },
        h("option", { value: "" }, t("anyTask")),
        tasks().map(([id, name]) => h("option", { value: id }, name)),
      ),
    ),
    toggle("filter-storey", t("filterStorey"), (on) => update({ filter: { ...state.filter, storey: on } })),
    toggle("by-state", t("byState"), (on) => update({ byState: on })),
  );
}

// Of the schedule once it is loaded; until then those that elements name.
function tasks() {
  const listed = state.tasks?.tasks.map((task) => [task.global_id, labelOf(task)]);
  return listed ?? Object.keys(state.site.tasks ?? {}).sort(byName).map((id) => [id, taskName(id)]);
}

function group(title, key, values, prefix) {
  const flip = (value) => {
    const list = state.filter[key];
    update({ filter: { ...state.filter, [key]: list.includes(value) ? list.filter((v) => v !== value) : [...list, value] } });
  };
  return h(
    "fieldset",
    {},
    h("legend", {}, t(title)),
    h(
      "div",
      { class: "chips" },
      values.map((value) =>
        h(
          "button",
          { type: "button", class: "chip chip-switch", "data-filter": `${key}:${value}`, onclick: () => flip(value) },
          word(prefix, value),
        ),
      ),
    ),
  );
}

const toggle = (id, text, set) =>
  h(
    "label",
    { class: "switch" },
    h("input", { type: "checkbox", id, onchange: (event) => set(event.target.checked) }),
    h("span", {}, text),
  );

function showSwitches() {
  for (const node of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-filter]"))) {
    const [key, value] = node.dataset.filter.split(":");
    node.setAttribute("aria-pressed", String(state.filter[key].includes(value)));
  }
  inputById("filter-task").value = state.filter.task ?? "";
  inputById("filter-storey").checked = state.filter.storey;
  inputById("by-state").checked = state.byState;
}

function showNote() {
  const on = isFiltering();
  if (on && !wasOn) /** @type {HTMLDetailsElement} */ (byId("filter-box")).open = true;
  wasOn = on;
  byId("shown-note").hidden = !on;
  if (!on) return;
  const all = Object.keys(state.site.elements);
  byId("shown-text").textContent = t("someHidden", { n: all.filter(isShown).length, of: all.length });
}
