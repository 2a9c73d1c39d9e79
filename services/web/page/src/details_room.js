// Describes a room: state and why, whether the robot gets there, its doors and the rooms behind them.

import { answerBlock } from "./answer_text.js";
import { fact, h } from "./dom.js";
import { heading, properties, shownButtons } from "./details_parts.js";
import { link } from "./link.js";
import { say } from "./live.js";
import { state, update } from "./state.js";
import { element, entryOf, isClosed, nameOf, neighbours, passageOf, roomState, space, spaceState, storeyName } from "./site.js";
import { labelOf, taskOf, tasksOfRoom } from "./task_store.js";
import { number, shortDate, t, word } from "./texts.js";
import { doorReasons, reachReason, roomReasons } from "./reasons.js";

export function roomDetails(id) {
  const room = space(id);
  const now = spaceState(id);
  const beside = neighbours(id);
  return [
    heading(id, t("room"), now?.state),
    h(
      "dl",
      { class: "facts" },
      state.site.live ? null : closedFacts(id, now),
      fact(t("storey"), storeyName(room.storey)),
      fact(t("area"), room.area_m2 ? `${number(room.area_m2, 2)} m²` : null),
      fact(t("height"), room.height_m ? `${number(room.height_m, 2)} m` : null),
      fact(
        t("floor"),
        room.floor_z_m === null || room.floor_z_m === undefined ? null : `${number(room.floor_z_m, 2)} m`,
      ),
      fact(
        t("coverage"),
        now?.coverage === null || now?.coverage === undefined ? null : `${number(100 * now.coverage, 0)} %`,
      ),
      fact("GlobalId", h("code", {}, id)),
    ),
    answerBlock(state.about?.path[1] === id ? state.about : null),
    wayButtons(id),
    closingTasks(id),
    beside.length === 0 ? null : h("h3", {}, t("doors")),
    beside.length === 0
      ? null
      : h(
          "ul",
          { class: "links" },
          beside.map((way) => h("li", {}, doorAndRoom(way, room.storey))),
        ),
    shownButtons(id),
    properties(room.property_sets),
  ];
}

function closingTasks(id) {
  const tasks = tasksOfRoom(id).map(taskOf);
  if (tasks.length === 0) return null;
  const dates = ({ start, finish }) =>
    start === null || finish === null ? t("noDates") : t("k_both", { from: shortDate(start), to: shortDate(finish) });
  const row = (task) =>
    h(
      "button",
      {
        type: "button",
        class: "link",
        "data-task": task.global_id,
        onclick: () => update({ task: task.global_id, tab: "tasks", sheet: state.sheet && "tasks" }),
      },
      h("span", { class: "link-name" }, labelOf(task), h("span", { class: "link-note" }, dates(task))),
    );
  return [h("h3", {}, t("roomTasks")), h("ul", { class: "links" }, tasks.map((task) => h("li", {}, row(task))))];
}

// Of files; a live site answers that itself.
function closedFacts(id, now) {
  return [
    fact(t("why"), roomReasons(id)),
    fact(t("reach"), reachOf(id, now)),
    now?.door ? fact(t("closedBy"), doorLine(now.door)) : null,
  ];
}

// Whether the robot gets here, and from where; of a blocked room "why" says it.
function reachOf(id, now) {
  if (!now || now.state === "blocked") return null;
  const reason = reachReason(id);
  if (now.state !== "reached") return reason ?? t("notJudged");
  const waypoint = reason === null ? t("reached") : t("reachedWithout", { why: reason });
  return entryOf(space(id).storey) === "placed" ? `${waypoint}; ${t("placedThere")}` : waypoint;
}

function doorLine(id) {
  const storey = element(id)?.attributes?.storey ?? state.storey;
  return link(id, `${nameOf(id)}: ${doorReasons(id, passageOf(id, storey) ?? "absent")}`);
}

// A door of the room, what it is for the robot, and the room behind it.
function doorAndRoom({ door, room }, storey) {
  const passage = passageOf(door, storey);
  const closed = isClosed(passage);
  return h(
    "div",
    { class: "beside" },
    link(
      door,
      nameOf(door),
      passage === null ? null : word("p", passage),
      closed ? "blocked" : passage === "absent" ? "plain" : "passable",
    ),
    room === null
      ? h("span", { class: "quiet" }, t("leadsTo", { room: t("outside") }))
      : h(
          "button",
          { type: "button", class: "link inset", onclick: () => update({ select: room }) },
          h("span", { class: "link-name" }, t("leadsTo", { room: nameOf(room) })),
          h("span", {
            class: `dot dot-${roomState(room)}`,
            title: word("s", roomState(room)),
          }),
        ),
  );
}

// The next click on the plan may name the room at the other end.
function beginWay(end, id) {
  const other = end === "from" ? "to" : "from";
  const picking = state[other] === null || state[other] === id ? /** @type {"from-room" | "to-room"} */ (`${other}-room`) : null;
  update({ [end]: id, ...(picking ? { [other]: null } : {}), picking, tab: "way", sheet: picking ? null : state.sheet && "way" });
  if (picking) say(t("pickRoom"));
}

function wayButtons(id) {
  return h(
    "div",
    { class: "row" },
    h(
      "button",
      { type: "button", class: "button", onclick: () => beginWay("from", id) },
      t("wayFrom"),
    ),
    h(
      "button",
      { type: "button", class: "button", onclick: () => beginWay("to", id) },
      t("wayTo"),
    ),
  );
}
