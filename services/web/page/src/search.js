// Search of rooms and elements by name, class, type, task, material or GlobalId, in small or capital letters.

import { byId, closestTo, h, inputById, show } from "./dom.js";
import { onChange, state, update } from "./state.js";
import { nameOf, taskName } from "./site.js";
import { t, word } from "./texts.js";

const RESULTS_MAX = 30;

let index = null; // [{id, lower, name, text, kind, more: [text]}], texts as `plain` makes them

export function createSearch() {
  const box = byId("search");
  const list = byId("results");
  box.addEventListener("input", showResults);
  box.addEventListener("focus", showResults);
  box.addEventListener("keydown", (event) => {
    if (event.key === "ArrowDown") focusResult(event, list.querySelector("button"));
    if (event.key === "Enter") list.querySelector("button")?.click();
    if (event.key === "Escape") close();
  });
  list.addEventListener("keydown", (event) => {
    const item = document.activeElement.closest("li");
    if (event.key === "ArrowDown") focusResult(event, item?.nextElementSibling?.querySelector("button"));
    if (event.key === "ArrowUp") focusResult(event, item?.previousElementSibling?.querySelector("button") ?? box);
    if (event.key === "Escape") {
      close();
      box.focus();
    }
  });
  document.addEventListener("pointerdown", (event) => {
    if (closestTo(event, ".search") === null) close();
  });
  onChange(["site"], () => (index = null));
}

function focusResult(event, node) {
  if (!node) return;
  event.preventDefault();
  node.focus();
}

function close() {
  byId("results").hidden = true;
  byId("search-count").textContent = "";
}

// Small letters without marks, so that "kuche" finds "Küche".
const plain = (text) => text.normalize("NFD").replace(/\p{M}/gu, "").toLowerCase();

function entries() {
  const { spaces, elements } = state.site;
  index ??= [
    ...Object.keys(spaces).map((id) => ({ id, name: nameOf(id), kind: t("room"), more: [] })),
    ...Object.entries(elements).map(([id, part]) => ({
      id,
      name: nameOf(id),
      kind: word("c", part.class),
      more: moreOf(part),
    })),
  ].map((entry) => ({
    ...entry,
    text: plain(entry.name),
    lower: entry.id.toLowerCase(),
    more: entry.more.filter(Boolean).map((text) => [plain(text), text]),
  }));
  return index;
}

// What else an element is found by: its class in both languages, type, task and materials.
function moreOf({ class: cls, type, schedule, attributes }) {
  const task = schedule?.task ? taskName(schedule.task) : null;
  return [word("c", cls), cls?.replace("_", " "), type, attributes?.predefined_type, task, ...(attributes?.materials ?? [])];
}

// A GlobalId alone, in its own letters before others; then names of which a word begins with what was typed, names and
// GlobalIds that hold it, and what has it in another fact, which the result shows. Rooms before elements.
function find(typed) {
  const [wanted, lower] = [plain(typed), typed.toLowerCase()];
  const all = entries();
  const own = all.filter((entry) => entry.lower === lower);
  if (own.length > 0) return [...own.filter((entry) => entry.id === typed), ...own.filter((entry) => entry.id !== typed)];
  const [begins, holds, others] = [[], [], []];
  for (const entry of all) {
    const at = entry.text.indexOf(wanted);
    const fact = entry.more.find(([text]) => text.includes(wanted));
    if (at === 0 || (at > 0 && entry.text.includes(` ${wanted}`))) begins.push(entry);
    else if (at > 0 || entry.lower.startsWith(lower)) holds.push(entry);
    else if (fact) others.push({ ...entry, fact: fact[1] });
  }
  return [...begins, ...holds, ...others];
}

function showResults() {
  const typed = inputById("search").value.trim();
  if (typed === "") return close();
  const found = find(typed);
  const list = byId("results");
  list.hidden = false;
  byId("search-count").textContent = found.length === 0 ? t("searchNone") : t("searchFound", { n: found.length });
  show(
    list,
    found
      .slice(0, RESULTS_MAX)
      .map((entry) =>
        h(
          "li",
          {},
          h(
            "button",
            { type: "button", class: "link", onclick: () => choose(entry.id) },
            h(
              "span",
              { class: "link-name" },
              entry.name,
              entry.fact ? h("span", { class: "link-note" }, entry.fact) : null,
            ),
            h("span", { class: "tag tag-plain" }, entry.kind),
          ),
        ),
      ),
    found.length === 0 ? h("li", { class: "quiet" }, t("searchNone")) : null,
    found.length > RESULTS_MAX ? h("li", { class: "quiet" }, t("searchFound", { n: found.length })) : null,
  );
  return undefined;
}

function choose(id) {
  close();
  inputById("search").value = "";
  update({ select: id, tab: "details", sheet: "details" });
  byId("plan").focus({ preventScroll: true });
}
