// The calendar: a strip per room over all stops with its states, and the date shown marked. A live site knows the ways of the
// date shown alone: there the strips say what the schedule says. It has the same scale
// as the slider below it. A click on a strip goes to the date there.

import { byId, closestTo, h, show, svg } from "./dom.js";
import { hasCalendar } from "./changes.js";
import { onChange, state, update } from "./state.js";
import { nameOf, space } from "./site.js";
import { placeNow, placeOf } from "./timeline.js";
import { byName, shortDate, t, word } from "./texts.js";

const ROWS_MAX = 300; // strips at once; those of the storey shown come first

export function createCalendar(setStop) {
  const rows = byId("calendar-rows");
  byId("calendar-toggle").addEventListener("click", () => update({ calendarOpen: !state.calendarOpen }));
  rows.addEventListener("click", (event) => {
    const strip = closestTo(event, ".strip");
    if (strip) setStop(stopAt(strip, event.clientX));
  });
  rows.addEventListener("keydown", byKey);
  onChange(["calendarOpen", "calendar", "site", "storey"], () => {
    byId("calendar").hidden = !state.calendarOpen;
    byId("calendar-toggle").setAttribute("aria-expanded", String(state.calendarOpen));
    if (state.calendarOpen) showRows();
  });
  onChange(["stop", "doc", "calendarOpen", "calendar"], showNow);
  onChange(["select", "calendarOpen", "calendar"], showChosen);
}

// The last stop at or before the place that was clicked.
function stopAt(strip, clientX) {
  const { left, width } = strip.getBoundingClientRect();
  const at = (clientX - left) / width;
  let stop = 0;
  while (stop + 1 < state.site.dates.length && placeOf(stop + 1) <= at) stop += 1;
  return stop;
}

// Rooms of the storey shown come first; names go up and down with the arrow keys.
function showRows() {
  const rows = byId("calendar-rows");
  if (!hasCalendar()) {
    show(rows, h("p", { class: "quiet" }, t("calendarNone")));
    return;
  }
  const rooms = Object.entries(state.calendar.spaces).filter(([id]) => space(id));
  const here = (id) => (space(id).storey === state.storey ? 0 : 1);
  rooms.sort(([a], [b]) => here(a) - here(b) || byName(nameOf(a), nameOf(b)));
  const rest = rooms.length - ROWS_MAX;
  const states = state.site.live ? ["open", "blocked"] : ["reached", "no_way", "blocked"];
  show(
    rows,
    h(
      "p",
      { class: "strip-legend" },
      states.map((at) => [h("span", { class: `dot dot-${at}`, "aria-hidden": "true" }), ` ${word("l_room", at)} `]),
    ),
    rooms.slice(0, ROWS_MAX).map(([id, steps], k) => row(id, steps, k === 0)),
    rest > 0 ? h("p", { class: "quiet" }, t("moreRooms", { n: rest })) : null,
  );
}

function row(id, steps, first) {
  const paths = { blocked: "", open: "", no_way: "", reached: "" };
  steps.forEach(([stop, at], i) => {
    const from = 1000 * placeOf(stop);
    const to = i + 1 < steps.length ? 1000 * placeOf(steps[i + 1][0]) : 1000;
    paths[at] += `M${from.toFixed(2)} 0H${to.toFixed(2)}V10H${from.toFixed(2)}Z`;
  });
  return h(
    "div",
    { class: "calendar-row", "data-room": id },
    h(
      "button",
      {
        type: "button",
        class: "link",
        tabindex: first ? 0 : -1,
        onclick: () => update({ select: id, tab: "details", sheet: null }),
      },
      nameOf(id),
    ),
    h(
      "div",
      { class: "strip", role: "img", "aria-label": `${nameOf(id)}: ${spoken(steps)}` },
      svg(
        "svg",
        { viewBox: "0 0 1000 10", preserveAspectRatio: "none", "aria-hidden": "true" },
        Object.entries(paths).map(([at, d]) => svg("path", { class: `strip-${at}`, d })),
      ),
    ),
  );
}

// The strip in words for those who do not see it, e.g. "blocked from .., open from ..".
function spoken(steps) {
  return steps.map(([stop, at]) => `${word("s", at)} ${shortDate(state.site.dates[stop]?.at ?? null)}`).join("; ");
}

function byKey(event) {
  const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
  const buttons = [...byId("calendar-rows").querySelectorAll("button")];
  const now = buttons.findIndex((button) => button === document.activeElement);
  const next = buttons[now + by];
  if (by === undefined || !next) return;
  event.preventDefault();
  buttons[now].tabIndex = -1;
  next.tabIndex = 0;
  next.focus();
}

function showNow() {
  if (!state.calendarOpen) return;
  byId("calendar").style.setProperty("--now", String(placeNow()));
}

function showChosen() {
  for (const line of /** @type {Iterable<HTMLElement>} */ (byId("calendar-rows").children)) {
    line.classList.toggle("chosen", line.dataset.room !== undefined && line.dataset.room === state.select);
  }
}
