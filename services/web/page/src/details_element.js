// Describes an element: its dates and where they come from, a door for the robot, what was observed.

import { answerBlock } from "./answer_text.js";
import { fact, h } from "./dom.js";
import { heading, properties, shownButtons, valueText } from "./details_parts.js";
import { link } from "./link.js";
import { askConfirm, deviationOf, deviationText } from "./live.js";
import { progressOfElement, progressTable } from "./progress.js";
import { state, update } from "./state.js";
import { labelOf, taskOf, tasksOfElement } from "./task_store.js";
import { element, elementState, isClosed, nameOf, passageOf, roomState, storeyName, taskName } from "./site.js";
import { longDate, number, t, word } from "./texts.js";
import { doorReasons } from "./reasons.js";

export function elementDetails(id) {
  const part = element(id);
  const attributes = part.attributes ?? {};
  const schedule = part.schedule;
  return [
    heading(id, word("c", part.class), elementState(id)),
    deviation(id),
    h(
      "dl",
      { class: "facts" },
      fact(t("type"), [part.type, attributes.predefined_type].filter(Boolean).join(" · ")),
      fact(
        t("storey"),
        part.storeys
          .map((s) => storeyName(s))
          .filter(Boolean)
          .join(", "),
      ),
      doorFacts(id, part),
      fact(t("material"), attributes.materials?.join(", ")),
      fact("GlobalId", h("code", {}, id)),
    ),
    answerBlock(state.about?.path[1] === id ? state.about : null),
    doorRooms(attributes.spaces),
    schedule ? h("h3", {}, t("schedule")) : null,
    schedule ? h("dl", { class: "facts" }, scheduleFacts(id, schedule)) : null,
    schedule ? h("h3", {}, t("progress")) : null,
    schedule ? progressTable(progressOfElement(id)) : null,
    shownButtons(id),
    properties(attributes.property_sets),
    others(attributes),
  ];
}

function scheduleFacts(id, schedule) {
  const at = (label, value) => fact(t(label), value ? longDate(value) : null);
  return [
    tasksOfElement(id).map((task) => fact(t("task"), taskLink(task))),
    at("start", schedule.start),
    at("finish", schedule.finish),
    at("removalStart", schedule.removal_start),
    at("removalFinish", schedule.removal_finish),
    at("plannedStart", schedule.planned_start),
    at("plannedFinish", schedule.planned_finish),
    fact(t("dateSource"), schedule.source ? word("f", schedule.source) : null),
    fact(t("rule"), schedule.rule),
    fact(t("file"), schedule.file),
    fact(
      t("float"),
      schedule.total_float_h === null || schedule.total_float_h === undefined
        ? null
        : t("hours", { n: number(schedule.total_float_h, 0) }),
    ),
  ];
}

// To the task in the list of tasks.
function taskLink(id) {
  const task = taskOf(id);
  return h(
    "button",
    {
      type: "button",
      class: "link inline",
      "data-task": id,
      onclick: () => update({ task: id, tab: "tasks", sheet: state.sheet && "tasks" }),
    },
    task ? labelOf(task) : taskName(id),
  );
}

function doorFacts(id, { class: cls, attributes, storeys }) {
  // A live site answers that itself.
  if (cls !== "door" || !attributes || state.site.live) return null;
  const passage = passageOf(id, attributes.storey ?? storeys[0]);
  return [
    fact(t("passage"), passage === null ? null : isClosed(passage) ? doorReasons(id, passage) : word("p", passage)),
    fact(t("clearWidth"), attributes.clear_width_m ? `${number(attributes.clear_width_m, 2)} m` : null),
    fact(t("clearWidthFrom"), attributes.clear_width_from ? word("cw", attributes.clear_width_from) : null),
  ];
}

function doorRooms(spaces) {
  if (!spaces) return null;
  return [
    h("h3", {}, t("between")),
    h(
      "ul",
      { class: "links" },
      spaces.map((room) =>
        h(
          "li",
          {},
          room === null
            ? h("span", { class: "quiet" }, t("outside"))
            : link(room, nameOf(room), word("s", roomState(room)), roomState(room)),
        ),
      ),
    ),
  ];
}

// Planned against observed: the deviation, and the button that confirms it where that is allowed.
function deviation(id) {
  const told = deviationOf(id);
  if (!told) return null;
  return h(
    "div",
    { class: "notice" },
    h("strong", {}, `${t("deviation")}: ${word("v", told.verdict)}`),
    h("p", {}, `${t("observed")}: ${deviationText(told)}`),
    told.waiting && state.site.control
      ? h("button", { type: "button", class: "button primary", onclick: () => askConfirm(id) }, t("confirm"))
      : null,
  );
}

const TOLD = new Set([
  "predefined_type",
  "materials",
  "spaces",
  "property_sets",
  "clear_width_m",
  "clear_width_from",
  "storey",
]);

// Attributes that have no line of their own, under their names in the files.
function others(attributes) {
  const list = Object.entries(attributes).filter(
    ([name, value]) => !TOLD.has(name) && value !== null && value !== undefined,
  );
  if (list.length === 0) return null;
  return h(
    "details",
    { class: "block", "data-part": "more" },
    h("summary", {}, t("moreFacts"), h("span", { class: "count" }, String(list.length))),
    h(
      "dl",
      { class: "facts" },
      list.map(([name, value]) => fact(name, element(value) ? link(value, nameOf(value)) : valueText(value))),
    ),
  );
}
