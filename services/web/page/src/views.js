// Saved views, in the browser's storage and as a file, and topics of BCF: the one shown is written, those of a file are listed.

import { readBcf, TooMany } from "./bcf_read.js";
import { writeBcf } from "./bcf_write.js";
import { byId, closestTo, h, icon, inputById, show } from "./dom.js";
import { linkDate, stopValidAt } from "./link_date.js";
import { say } from "./live.js";
import { nameOf, storeyName } from "./site.js";
import { state, toFragment, update } from "./state.js";
import { longDate, shortDate, t } from "./texts.js";
import { patchOf, viewpointNow } from "./topic_view.js";

const FILE_BYTES_MAX = 64e6;
const VIEWS_MAX = 200;
const NAME_MAX = 120;
const LINK_MAX = 20000;
const FILES = ".json,.bcf,.bcfzip,.zip";

/** @type {{name: string, link: string}[]} */
let views = [];
let isStored = true;
/** @type {(import("./bcf_read.js").ReadTopic & {address: string | null})[]} */
let topics = [];

const storageKey = () => `groundplan-views ${state.site.title}`;

export function createViews() {
  views = stored();
  show(
    byId("panel-views"),
    h("h2", {}, t("savedViews")),
    nameField("view-name", t("viewName"), saveView),
    h("div", { class: "row" }, button("save-view", t("saveView"), saveView), button("save-views", t("saveFile"), saveFile)),
    h("ul", { class: "links", id: "view-list" }),
    h("h3", {}, t("topics")),
    nameField("topic-title", t("topicTitle"), saveTopic),
    h("div", { class: "row" }, button("save-topic", t("saveTopic"), saveTopic)),
    h(
      "label",
      { class: "button file-button" },
      t("readFile"),
      h("input", { type: "file", id: "read-file", "aria-label": t("readFile"), accept: FILES, onchange: readFile }),
    ),
    h("ul", { class: "links", id: "topic-list" }),
  );
  byId("view-list").addEventListener("click", useView);
  showViews();
}

function nameField(id, name, save) {
  const onkeydown = (event) => {
    if (event.key === "Enter") save();
  };
  return h("input", { id, class: "text-field", maxlength: NAME_MAX, "aria-label": name, placeholder: name, onkeydown });
}

const button = (id, text, onclick) => h("button", { type: "button", class: "button small", id, onclick }, text);

// What the storage holds, as far as it is of this page; without storage nothing.
function stored() {
  try {
    return checked(JSON.parse(localStorage.getItem(storageKey()) ?? "[]"));
  } catch {
    isStored = false;
    return [];
  }
}

/** @returns {{name: string, link: string}[]} */
function checked(list) {
  if (!Array.isArray(list)) return [];
  const isView = (view) => typeof view?.name === "string" && typeof view.link === "string" && view.link.startsWith("#");
  return list
    .filter((view) => isView(view) && view.link.length <= LINK_MAX)
    .slice(0, VIEWS_MAX)
    .map(({ name, link }) => ({ name: name.slice(0, NAME_MAX), link }));
}

function keep() {
  try {
    localStorage.setItem(storageKey(), JSON.stringify(views));
    isStored = true;
  } catch {
    isStored = false;
  }
  showViews();
}

function showViews() {
  const row = ({ name }, k) =>
    h(
      "li",
      { class: "saved" },
      h("button", { type: "button", class: "link", "data-saved": k }, h("span", { class: "link-name" }, name)),
      h("button", { type: "button", class: "tool", "data-remove": k, "aria-label": t("remove", { name }) }, icon("close")),
    );
  show(
    byId("view-list"),
    views.map(row),
    views.length === 0 ? h("li", { class: "quiet" }, t("viewsNone")) : null,
    isStored ? null : h("li", { class: "quiet" }, t("viewsNotStored")),
  );
}

function useView(event) {
  const used = closestTo(event, "[data-saved]");
  const removed = closestTo(event, "[data-remove]");
  if (used) {
    location.hash = views[Number(used.dataset.saved)].link;
    update({ sheet: null });
  } else if (removed) {
    views = views.filter((_, k) => k !== Number(removed.dataset.remove));
    keep();
  }
}

function saveView() {
  const field = inputById("view-name");
  const name = field.value.trim() || t("viewUnnamed", { n: views.length + 1 });
  if (views.length >= VIEWS_MAX) {
    say(t("fileTooMany", { n: VIEWS_MAX }));
    return;
  }
  views = [...views.filter((view) => view.name !== name), { name, link: toFragment() }];
  field.value = "";
  keep();
  say(t("viewSaved", { name }));
}

function download(name, bytes, type) {
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

// A name of a file of letters that every system takes.
const fileName = (text, ending) => `${text.replace(/[^\p{L}\p{N} ._-]+/gu, "_").slice(0, 60).trim() || "groundplan"}${ending}`;

function saveFile() {
  const text = JSON.stringify({ groundplan_views: 1, site: state.site.title, views }, null, 1);
  download(fileName(`${state.site.title} views`, ".json"), text, "application/json");
}

function saveTopic() {
  const field = inputById("topic-title");
  const at = state.doc?.at ?? null;
  const about = state.select === null ? storeyName(state.storey) : nameOf(state.select);
  const title = field.value.trim() || [about, at === null ? "" : shortDate(at)].filter(Boolean).join(", ");
  const { viewpoint, picture } = viewpointNow();
  const description = [state.site.title, storeyName(state.storey), `${t("printDate")}: ${longDate(at)}`].join("\n");
  const files = state.site.sources.map((source) => source.file);
  const link = `${location.href.split("#")[0]}${toFragment()}`;
  const bytes = writeBcf({ title, description, link, files, viewpoint, picture }, new Date());
  const file = fileName(title, ".bcf");
  download(file, bytes, "application/octet-stream");
  field.value = "";
  say(t(picture === null ? "topicNoPicture" : "topicSaved", { file }));
}

async function readFile(event) {
  const [file] = event.target.files;
  if (!file) return;
  try {
    if (file.size > FILE_BYTES_MAX) throw new Error(t("fileTooLarge", { n: FILE_BYTES_MAX / 1e6 }));
    const bytes = new Uint8Array(await file.arrayBuffer());
    if (bytes[0] === 0x50 && bytes[1] === 0x4b) readTopics(file.name, bytes);
    else readViews(new TextDecoder().decode(bytes));
  } catch (error) {
    const why = error instanceof TooMany ? t("fileTooMany", { n: error.message }) : error.message;
    say(t("fileWrong", { file: file.name, why }));
  }
  event.target.value = "";
}

function readViews(text) {
  let document = null;
  try {
    document = JSON.parse(text);
  } catch {
    // Said below.
  }
  if (document?.groundplan_views !== 1) throw new Error(t("fileNoViews"));
  const read = checked(document.views);
  const names = new Set(read.map((view) => view.name));
  views = [...views.filter((view) => !names.has(view.name)), ...read].slice(0, VIEWS_MAX);
  keep();
  say(t("viewsRead", { n: read.length }));
}

function readTopics(name, bytes) {
  const { topics: read, skipped } = readBcf(bytes);
  if (read.length === 0) throw new Error(t("fileNoViews"));
  for (const { address } of topics) if (address !== null) URL.revokeObjectURL(address);
  topics = read.map((topic) => ({ ...topic, address: pictureAddress(topic.picture) }));
  show(byId("topic-list"), topics.map(topicRow));
  say(skipped > 0 ? t("topicsSkipped", { n: skipped, file: name }) : t("topicsRead", { n: topics.length }));
}

// Pictures alone, by how they begin.
function pictureAddress(picture) {
  if (picture === null) return null;
  const isPng = picture[0] === 0x89 && picture[1] === 0x50;
  const isJpeg = picture[0] === 0xff && picture[1] === 0xd8;
  return isPng || isJpeg ? URL.createObjectURL(new Blob([picture], { type: isPng ? "image/png" : "image/jpeg" })) : null;
}

function topicRow(topic) {
  const note = topic.description ? h("span", { class: "link-note" }, topic.description) : null;
  return h(
    "li",
    {},
    h(
      "button",
      { type: "button", class: "link topic", onclick: () => goTo(topic) },
      h("span", { class: "link-name" }, topic.title, note),
    ),
    topic.address === null ? null : h("img", { class: "topic-picture", src: topic.address, alt: topic.title }),
  );
}

function goTo({ viewpoint, link }) {
  if (viewpoint === null) {
    say(t("topicNoView"));
    return;
  }
  const { patch, missing } = patchOf(viewpoint);
  // A topic of this page names its date; others have none.
  const date = link?.includes("#") ? new URLSearchParams(link.slice(link.indexOf("#") + 1)).get("date") : null;
  const stop = date === null || state.site.live ? null : stopValidAt(state.site.dates, date);
  if (stop !== null && linkDate(state.site.dates[stop].at) === date) patch.date = state.site.dates[stop].key;
  update({ ...patch, sheet: null });
  if (missing > 0) say(t("topicUnknown", { n: missing }));
}
