// Search of rooms and elements by name or GlobalId.

import { byId, h, show } from "./dom.js";
import { onChange, state, update } from "./state.js";
import { nameOf } from "./site.js";
import { t, word } from "./texts.js";

const RESULTS_MAX = 30;

let index = null; // [{id, name, text (lower case), kind}]

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
    if (!event.target.closest(".search")) close();
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

// Small letters without marks, so that "kuche" finds "Küche"; GlobalIds are compared exactly.
const plain = (text) => text.normalize("NFD").replace(/\p{M}/gu, "").toLowerCase();

function entries() {
  const { spaces, elements } = state.site;
  index ??= [
    ...Object.keys(spaces).map((id) => ({ id, name: nameOf(id), kind: t("room") })),
    ...Object.entries(elements).map(([id, { class: cls }]) => ({ id, name: nameOf(id), kind: word("c", cls) })),
  ].map((entry) => ({ ...entry, text: plain(entry.name) }));
  return index;
}

// Names of which a word begins with what was typed come first, then the others; rooms before elements.
function find(typed) {
  const wanted = plain(typed);
  const begins = [];
  const holds = [];
  for (const entry of entries()) {
    if (entry.id === typed) return [entry];
    const at = entry.text.indexOf(wanted);
    if (at === 0 || (at > 0 && entry.text.includes(` ${wanted}`))) begins.push(entry);
    else if (at > 0 || entry.id.startsWith(typed)) holds.push(entry);
  }
  return [...begins, ...holds];
}

function showResults() {
  const typed = byId("search").value.trim();
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
            h("span", { class: "link-name" }, entry.name),
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
  byId("search").value = "";
  update({ select: id, tab: "details", sheet: "details" });
  byId("plan").focus({ preventScroll: true });
}
