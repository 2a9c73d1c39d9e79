// Where the data comes from: documents by fetch, or, in an exported page, by injected scripts that call
// `groundplanData(name, value)`, because file:// allows no fetch. Also the live events and the two controls.

import { kindOf } from "./waypoint_kinds.js";

const FILES = document.documentElement.dataset.source === "files";
const DATES_KEPT = 24;
const RETRY_MS = 500;
const ANSWER_TRIES = 20;

const waiting = new Map(); // name -> {resolve, reject}, scripts on their way
const dates = new Map(); // key -> promise of the document, oldest first

if (FILES) {
  globalThis.groundplanData = (name, value) => waiting.get(name)?.resolve(value);
}

function byScript(name) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    const settle = (end) => (value) => {
      waiting.delete(name);
      script.remove();
      end(value);
    };
    waiting.set(name, { resolve: settle(resolve), reject: settle(reject) });
    const missing = () => waiting.get(name)?.reject(new Error(`data/${name}.js`));
    script.addEventListener("error", missing);
    script.addEventListener("load", missing); // it ran and did not call
    script.src = `data/${name}.js`;
    document.head.append(script);
  });
}

async function byFetch(path) {
  for (;;) {
    const answer = await fetch(`data/${path}`);
    if (answer.ok) return answer;
    if (answer.status === 409) return reload();
    if (answer.status !== 503) throw new Error(`data/${path}: ${await answer.text()}`);
    // The daemons have just been started, and have no whole set of maps yet.
    await new Promise((resume) => setTimeout(resume, RETRY_MS));
  }
}

// The maps in the folder are others now: the page begins anew with them. Nothing of what was asked for is answered.
function reload() {
  location.reload();
  return new Promise(() => {});
}

// A picture that is gone: the page begins anew if the maps are others. In a live site events tell of that.
let looking = false;
export async function reloadIfChanged() {
  if (FILES || looking) return;
  looking = true;
  try {
    const answer = await fetch("data/site.json");
    if (answer.ok && (await answer.text()) !== siteText) await reload();
  } catch {
    // A server that is gone is told by what is asked for next.
  }
  looking = false;
}

async function document_(name) {
  return FILES ? byScript(name) : (await byFetch(`${name}.json`)).json();
}

let siteText = null; // as it came, to see whether a site changed

/** @returns {Promise<import("./types.js").Site>} */
export async function loadSite() {
  if (FILES) return byScript("site");
  siteText = await (await byFetch("site.json")).text();
  return JSON.parse(siteText);
}

/**
 * The site document of a live site if it is another one than before, else null.
 * @returns {Promise<import("./types.js").Site | null>}
 */
export async function loadChangedSite() {
  const before = siteText;
  const site = await loadSite();
  return siteText === before ? null : site;
}

/** @type {() => Promise<import("./types.js").Tasks>} */
export const loadTasks = () => document_("tasks");

/** @type {(key: string) => Promise<import("./types.js").Summary>} */
export const loadSummary = (key) => document_(`summary/${key}`);

/** @type {() => Promise<import("./types.js").Calendar>} */
export const loadCalendar = () => document_("calendar");

/**
 * The document of a date. Documents stay loaded, up to a limit; one that failed is asked for again.
 * @param {string} key
 * @returns {Promise<import("./types.js").DateDocument>}
 */
export function loadDate(key) {
  let promise = dates.get(key);
  dates.delete(key);
  promise ??= document_(`dates/${key}`)
    .then((date) => {
      date.waypoints.forEach(kindOf);
      return date;
    })
    .catch((error) => {
      dates.delete(key);
      throw error;
    });
  dates.set(key, promise);
  if (dates.size > DATES_KEPT) dates.delete(dates.keys().next().value);
  return promise;
}

// A new site document makes all dates stale.
export function forgetDates() {
  dates.clear();
}

/**
 * The answer of a live site to a question: what it is about, and names of rooms, doors or points. An error has the words of the
 * server, which names what comes nearest to a wrong name.
 * @param {string[]} path
 * @returns {Promise<{answer: any, text: string}>}
 */
export async function loadAnswer(path) {
  for (let tries = 1; ; tries++) {
    const answer = await fetch(`data/${path.map(encodeURIComponent).join("/")}`);
    if (answer.ok) return answer.json();
    // Between two dates there is no whole set of maps.
    if (answer.status !== 503 || tries === ANSWER_TRIES) throw new Error(await answer.text());
    await new Promise((resume) => setTimeout(resume, RETRY_MS));
  }
}

/**
 * The GLB of a model as an ArrayBuffer.
 * @param {string} hash
 * @returns {Promise<ArrayBuffer>}
 */
export async function loadModel(hash) {
  if (!FILES) return (await byFetch(`models/${hash}.glb`)).arrayBuffer();
  const text = atob(await byScript(`models/${hash}`));
  return Uint8Array.from(text, (letter) => letter.charCodeAt(0)).buffer;
}

/**
 * @param {number} storey
 * @param {string} layer
 * @param {string} hash
 * @param {number} level
 * @param {number} column
 * @param {number} row
 */
export function tileUrl(storey, layer, hash, level, column, row) {
  return `data/tiles/${storey}/${layer}/${hash}/${level}/${column}/${row}.png`;
}

/** @type {(hash: string) => string} */
export const slamUrl = (hash) => `data/slam/${hash}.png`;

/**
 * Live events: `on(name, value)` for each, `connected(bool, full)` when the connection is lost or there again; `full` if there
 * are too many viewers for this one.
 * EventSource tries again by itself, except after an answer that is not a stream: then we open a new one.
 * @param {(name: string, value: any) => void} on
 * @param {(connected: boolean, full: boolean) => void} connected
 */
export function followEvents(on, connected) {
  const retryMs = 2000;
  const open = () => {
    const events = new EventSource("data/events");
    events.addEventListener("open", () => connected(true, false));
    events.addEventListener("error", async () => {
      const refused = events.readyState === EventSource.CLOSED;
      connected(false, refused && (await isFull()));
      if (refused) setTimeout(open, retryMs);
    });
    for (const name of ["date", "site", "status", "robot", "fleet", "slam", "deviations"]) {
      events.addEventListener(name, (event) => on(name, event.data === "" ? null : JSON.parse(event.data)));
    }
  };
  open();
}

// True if the server says that it has no place for another viewer: an EventSource does not tell why it was refused.
async function isFull() {
  const ended = new AbortController();
  try {
    const answer = await fetch("data/events", { signal: ended.signal });
    return answer.headers.get("X-Groundplan") === "too-many-viewers";
  } catch {
    return false;
  } finally {
    ended.abort();
  }
}

async function post(path, body) {
  const answer = await fetch(`data/control/${path}`, {
    method: "POST",
    headers: { "Content-Type": "application/json", "X-Groundplan": "1" },
    body: JSON.stringify(body),
  });
  if (answer.ok) return;
  const told = await answer.json().catch(() => ({}));
  throw new Error(told.error ?? `${answer.status}`);
}

/** @type {(at: string) => Promise<void>} */
export const postDate = (at) => post("date", { at });
/** @type {(globalId: string) => Promise<void>} */
export const postConfirm = (globalId) => post("confirm", { global_id: globalId });
