// Starts the page: loads the site, shows the date of the link, then what can come later.

import { byId, h, show } from "./dom.js";
import { createAnswers } from "./answers.js";
import { createCalendar } from "./calendar.js";
import { createChanges } from "./changes.js";
import { createCompare } from "./compare.js";
import { createDetails } from "./details.js";
import { createFilterPanel } from "./filter_panel.js";
import { createFindings } from "./findings.js";
import { createLayers } from "./layers.js";
import { createLegend } from "./legend.js";
import { askDate, createLive, say } from "./live.js";
import { createMeasure } from "./measure.js";
import { createMissions } from "./missions.js";
import { createPlan } from "./plan.js";
import { createPrint } from "./print.js";
import { createSearch } from "./search.js";
import { createShell } from "./shell.js";
import { createTaskStore } from "./task_store.js";
import { createTasks } from "./tasks.js";
import { createTimeline } from "./timeline.js";
import { createViews } from "./views.js";
import { createView3d } from "./view3d.js";
import { createWay } from "./way.js";
import { linkDate, stopValidAt } from "./link_date.js";
import { forgetDates, loadCalendar, loadChangedSite, loadDate, loadSite } from "./source.js";
import { fromFragment, isEnd, keepFragment, onChange, state, toFragment, update } from "./state.js";
import { prefetchStop } from "./tiles.js";
import { resetSite } from "./site.js";
import { milliseconds, t, translate } from "./texts.js";

const linkedDate = dateOfLink(); // what the address named when the page was opened
const EMPTY_CALENDAR = { elements: {}, spaces: {} };

start();

async function start() {
  translate(document);
  try {
    const site = await loadSite();
    update(firstState(site));
    const dateShown = site.live ? null : loadDate(state.date).catch(() => null); // on its way while the plan is made
    createShell();
    createPlan();
    // The plan asks for its tiles before the panels are made.
    if ((await dateShown) !== null) await showDate(state.date);
    createPanels();
    keepFragment(sayIfGone);
    history.replaceState(null, "", toFragment());
    if (!site.live) sayIfGone(linkedDate);
    if (!site.live) {
      onChange(["date"], () => showDate(state.date));
      if (state.doc === null) await showDate(state.date); // it failed before: now there is a place to say so
    }
    document.body.dataset.ready = "true";
    loadLater();
  } catch (error) {
    fail(error);
  }
}

function dateOfLink() {
  return new URLSearchParams(location.hash.slice(1)).get("date");
}

// A date of a link for which there are no maps is not shown, and that is said.
function sayIfGone(wanted) {
  if (wanted === null) return;
  const { site } = state;
  const gone = site.live ? state.doc !== null && linkDate(state.doc.at) !== wanted : stopValidAt(site.dates, wanted) === null;
  if (gone) say(t(site.live ? "linkDateLive" : "linkDateGone", { date: wanted }), true);
}

/**
 * What the link says, else the storey with the entrance, or the lowest one that is not below ground, and what stands today.
 * @param {import("./types.js").Site} site
 * @returns {Partial<import("./types.js").State>}
 */
function firstState(site) {
  const wanted = fromFragment(site);
  const entrance = site.storeys.find((s) => s.index === site.entrance);
  const storey = wanted.storey ?? (entrance ?? site.storeys.find((s) => s.floor_z_m >= -0.01) ?? site.storeys[0]).index;
  const date = site.live ? null : (wanted.date ?? presentDate(site.dates).key);
  const tab = wanted.tab ?? (wanted.from && wanted.to ? "way" : "details");
  return { ...wanted, site, storey, date, tab, stop: date === null ? null : stopOf(site, date) };
}

// The last stop that is not in the future, else the first.
function presentDate(dates) {
  const now = Date.now();
  return dates.findLast((date) => date.at === null || milliseconds(date.at) <= now) ?? dates[0];
}

const stopOf = (site, key) => site.dates.findIndex((date) => date.key === key);

function createPanels() {
  createAnswers();
  createLayers();
  createTimeline(setStop);
  createTaskStore();
  createCompare();
  createChanges();
  createTasks();
  createFilterPanel();
  createMeasure();
  createViews();
  createFindings();
  createDetails();
  createWay();
  createMissions();
  createSearch();
  createCalendar(setStop);
  createLegend();
  createView3d();
  createPrint();
  createLive({ onDate: showLiveDate, onSite: reloadSite });
}

// A person asks for a stop: shown at once from files, asked for in a live site.
function setStop(stop) {
  if (state.site.live) {
    if (state.site.control) askDate(stop);
    return;
  }
  update({ date: state.site.dates[stop].key, stop });
}

// Loads and shows the document of a date; when another date was asked for meanwhile, that one is shown.
async function showDate(key) {
  if (key === null) return;
  const stop = stopOf(state.site, key);
  if (stop >= 0) update({ stop });
  try {
    const doc = await loadDate(key);
    if (state.date !== key) return;
    update({ doc, previousDoc: state.doc });
    if (stop >= 0) [stop + 1, stop - 1].forEach(prefetchStop);
  } catch (error) {
    if (state.date === key) say(t("failed", { what: error.message }));
  }
}

// The newest date that a live site told of; documents of older ones that come late are not shown.
let newest = null;
async function showLiveDate({ key, stop }) {
  newest = key;
  try {
    const doc = await loadDate(key);
    if (newest !== key || doc === state.doc) return;
    const isFirst = state.doc === null;
    update({ doc, previousDoc: state.doc, stop, date: key });
    if (isFirst) sayIfGone(linkedDate);
  } catch (error) {
    say(t("failed", { what: error.message }));
  }
}

async function loadLater() {
  const calendar = await loadCalendar().catch((error) => {
    say(t("failed", { what: error.message }));
    return EMPTY_CALENDAR;
  });
  update({ calendar });
}

// The model or the schedule of a live site may have changed: if so, everything that came from it is read again.
async function reloadSite() {
  try {
    const site = await loadChangedSite();
    if (site === null) return;
    forgetDates();
    resetSite();
    const known = (id) => id !== null && (Object.hasOwn(site.elements, id) || Object.hasOwn(site.spaces, id));
    const storey = site.storeys.some((s) => s.index === state.storey) ? state.storey : site.storeys[0].index;
    const keep = (id) => (known(id) ? id : null);
    update({
      site,
      storey,
      select: keep(state.select),
      from: isEnd(site, state.from) ? state.from : null,
      to: isEnd(site, state.to) ? state.to : null,
      doc: null,
      previousDoc: null,
    });
    if (newest !== null) await showLiveDate({ key: newest, stop: state.stop });
    await loadLater();
  } catch (error) {
    say(t("failed", { what: error.message }));
  }
}

function fail(error) {
  console.error(error);
  show(
    byId("alerts"),
    h(
      "p",
      {},
      h("span", {}, t("failed", { what: error.message })),
      h("button", { type: "button", class: "button small", onclick: () => location.reload() }, t("retry")),
    ),
  );
}
