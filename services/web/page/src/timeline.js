// The slider over the dates at which something changes, its marks, and play, previous and next.
// The track is true to time: a stop lies where its date lies, so that the calendar below lines up with it.

import { buttonById, byId, h, icon, inputById, show } from "./dom.js";
import { stopValidAt } from "./link_date.js";
import { say } from "./live.js";
import { onChange, state, update } from "./state.js";
import { dayDate, longDate, mediumDate, milliseconds, monthDate, shortDate, t } from "./texts.js";

const PLAY_MS = 900;

let places = []; // 0..1 along the track for each stop
/** @type {(stop: number) => void} */
let goTo = () => {};

// Places of the stops: by time, or evenly where dates are missing. The last stop keeps room to its right, because
// what it shows goes on.
function placesOf(dates) {
  const times = dates.map((date) => (date.at === null ? null : milliseconds(date.at)));
  if (dates.length < 2 || times.includes(null))
    return dates.map((_, k) => (dates.length === 1 ? 0.5 : (0.96 * k) / (dates.length - 1)));
  const span = times.at(-1) - times[0] || 1;
  return times.map((time) => (0.96 * (time - times[0])) / span);
}

export const placeOf = (stop) => places[stop] ?? 0;

// Place of the date shown; a live site may stand between two stops.
export function placeNow() {
  const { site, stop, doc } = state;
  if (stop !== null && !isBetween()) return placeOf(stop);
  const after = doc?.at ? site.dates.findIndex((date) => date.at !== null && date.at > doc.at) : -1;
  if (after === -1) return places.at(-1) ?? 0;
  if (after === 0) return 0;
  const [from, to] = [milliseconds(site.dates[after - 1].at), milliseconds(site.dates[after].at)];
  return places[after - 1] + ((places[after] - places[after - 1]) * (milliseconds(doc.at) - from)) / (to - from);
}

// `setStop(stop)` is what the page does when a person asks for a stop.
export function createTimeline(setStop) {
  goTo = setStop;
  const slider = byId("slider");
  slider.addEventListener("keydown", byKey);
  wirePointer(slider);
  byId("previous").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  byId("play").addEventListener("click", () => update({ playing: !state.playing }));
  byId("date-field").addEventListener("change", goToDate);
  onChange(["playing"], play);
  onChange(["site"], showTrack);
  onChange(["site", "stop", "doc"], showStop);
  showTrack();
  showStop();
}

const lastStop = () => state.site.dates.length - 1;
const isFixed = () => state.site.live && !state.site.control;

// True if a live site stands at a date that is not that of a stop.
function isBetween() {
  const { site, stop, doc } = state;
  return site.live && doc !== null && (stop === null || site.dates[stop]?.at !== doc.at);
}

// The stop shown, or the last one before a date between two stops.
function stopNow() {
  if (!isBetween()) return state.stop ?? 0;
  return Math.max(
    0,
    places.findLastIndex((place) => place <= placeNow()),
  );
}

function step(by) {
  const between = isBetween();
  // Back from between two stops is to the first of them.
  const stop = Math.max(0, Math.min(lastStop(), stopNow() + by + (between && by < 0 ? 1 : 0)));
  if (lastStop() >= 0 && (between || stop !== state.stop) && !isFixed()) goTo(stop);
}

// Goes to the stop whose maps hold at the date of the field, and says if there is none.
function goToDate(event) {
  const { value } = event.target;
  if (value === "" || isFixed()) return;
  const stop = stopValidAt(state.site.dates, value);
  if (stop === null) say(t("noDate", { date: shortDate(value) }));
  else if (stop !== state.stop || isBetween()) goTo(stop);
  showStop();
}

function byKey(event) {
  const by = {
    ArrowLeft: -1,
    ArrowDown: -1,
    ArrowRight: 1,
    ArrowUp: 1,
    PageDown: -5,
    PageUp: 5,
    Home: -Infinity,
    End: Infinity,
  }[event.key];
  if (by === undefined) return;
  event.preventDefault();
  update({ playing: false });
  step(by);
}

// Dragging goes to the nearest stop under the pointer. In a live site the date is set when the pointer is released.
function wirePointer(slider) {
  const nearest = (event) => {
    const { left, width } = byId("track").getBoundingClientRect();
    const at = (event.clientX - left) / width;
    return places.reduce((best, place, k) => (Math.abs(place - at) < Math.abs(places[best] - at) ? k : best), 0);
  };
  let dragging = false;
  slider.addEventListener("pointerdown", (event) => {
    if (isFixed()) say(t("liveDate"));
    if (isFixed() || event.button !== 0) return;
    dragging = true;
    slider.setPointerCapture(event.pointerId);
    update({ playing: false });
    if (!state.site.live) goTo(nearest(event));
    slider.focus();
  });
  slider.addEventListener("pointermove", (event) => {
    if (dragging && !state.site.live) goTo(nearest(event));
  });
  slider.addEventListener("pointerup", (event) => {
    if (dragging && state.site.live) goTo(nearest(event));
    dragging = false;
  });
  slider.addEventListener("pointercancel", () => (dragging = false));
}

let timer = 0;
function play() {
  clearInterval(timer);
  const button = byId("play");
  const name = t(state.playing ? "pause" : "play");
  button.setAttribute("aria-label", name);
  button.title = name;
  show(button, icon(state.playing ? "pause" : "play"));
  if (!state.playing) return;
  if (state.stop === lastStop()) goTo(0);
  timer = setInterval(() => {
    // The next stop waits until the present one is shown.
    if (state.doc?.key !== state.date) return;
    if (state.stop >= lastStop()) update({ playing: false });
    else step(1);
  }, PLAY_MS);
}

// Marks of all stops in one path, whatever their number; months below them.
function showTrack() {
  const { dates } = state.site;
  places = placesOf(dates);
  byId("time").classList.toggle("single", dates.length < 2);
  const marks = places.map((place) => `M${(1000 * place).toFixed(2)} 0V10`).join("");
  byId("marks").setAttribute("d", marks);
  show(
    byId("months"),
    monthsOf(dates).map(([place, text]) => {
      const label = h("span", {}, text);
      label.style.left = `${100 * place}%`;
      return label;
    }),
  );
  const slider = byId("slider");
  slider.setAttribute("aria-valuemin", "0");
  slider.setAttribute("aria-valuemax", String(Math.max(0, lastStop())));
}

// The first days of months between the first and the last date; days where the span is short.
function monthsOf(dates) {
  if (dates.length < 2 || dates.some((date) => date.at === null)) return [];
  const [first, last] = [milliseconds(dates[0].at), milliseconds(dates.at(-1).at)];
  const place = (ms) => (0.96 * (ms - first)) / (last - first);
  const labels = [];
  const cursor = new Date(first);
  if (last - first < 45 * 86400000) {
    const days = Math.max(1, Math.round((last - first) / 86400000 / 6));
    for (let ms = first; ms <= last; ms += days * 86400000) labels.push([place(ms), dayDate(ms)]);
    return labels;
  }
  const months = Math.max(1, Math.round((last - first) / (30 * 86400000) / 8));
  cursor.setUTCHours(0, 0, 0, 0);
  cursor.setUTCDate(1);
  for (
    cursor.setUTCMonth(cursor.getUTCMonth() + 1);
    cursor.getTime() <= last;
    cursor.setUTCMonth(cursor.getUTCMonth() + months)
  ) {
    labels.push([place(cursor.getTime()), monthDate(cursor.getTime())]);
  }
  return labels;
}

function showStop() {
  const { site, stop } = state;
  const shown = site.live ? state.doc : site.dates[stop];
  if (!shown) return;
  const slider = byId("slider");
  const until =
    shown.at === null ? "" : shown.until === null ? t("noLater") : t("until", { date: shortDate(shown.until) });
  slider.title = isFixed() ? t("liveDate") : "";
  const place = placeNow();
  byId("thumb").style.left = byId("past").style.width = `${100 * place}%`;
  slider.setAttribute("aria-valuenow", String(stopNow()));
  slider.setAttribute("aria-valuetext", [longDate(shown.at), until, slider.title].filter(Boolean).join(", "));
  slider.setAttribute("aria-disabled", String(isFixed()));
  const field = inputById("date-field");
  field.hidden = shown.at === null;
  field.disabled = isFixed();
  if (shown.at !== null && document.activeElement !== field) field.value = shown.at.slice(0, 16);
  byId("date").textContent = mediumDate(shown.at);
  byId("until").textContent = until;
  byId("stop-number").textContent =
    stop === null || isBetween() ? "" : t("stopOf", { k: stop + 1, n: site.dates.length });
  buttonById("previous").disabled = isFixed() || (stop === 0 && !isBetween());
  buttonById("next").disabled = isFixed() || stopNow() >= lastStop();
  buttonById("play").disabled = site.live || site.dates.length < 2;
}
