// The findings of the conversion: what it warns of, assumes, replaces and leaves out, each with a link to what it is about.

import { byId, h, show } from "./dom.js";
import { link } from "./link.js";
import { onChange, state, update } from "./state.js";
import { element, nameOf, space, storeyName, taskName } from "./site.js";
import { has, sentence, t, word } from "./texts.js";

const KINDS = ["errors", "warnings", "assumptions", "substitutions", "left_out"];
const LISTED = 100; // findings of a kind that are listed at once

export function createFindings() {
  byId("findings-toggle").addEventListener("click", () =>
    update({ tab: "findings", sheet: "findings" }),
  );
  onChange(["site"], showCount);
  onChange(["site", "tab", "sheet"], showFindings);
  showCount();
  showFindings();
}

// The findings of a kind; storeys with an assumed floor are among the assumptions.
function findingsOf(kind) {
  const { n, list } = state.site.findings?.[kind] ?? { n: 0, list: [] };
  if (kind !== "assumptions") return { n, list };
  const storeys = state.site.storeys
    .filter((storey) => storey.floor === "assumed")
    .map((storey) => ({ code: "assumed_storey", text: null, global_id: null, name: storeyName(storey.index), place: null }));
  return { n: n + storeys.length, list: [...storeys, ...list] };
}

// The button of the frame: only where there is something to be known.
function showCount() {
  const count = KINDS.reduce((sum, kind) => sum + findingsOf(kind).n, 0);
  const button = byId("findings-toggle");
  button.hidden = count === 0;
  button.textContent = t("findingsCount", { n: count });
}

function showFindings() {
  if (state.tab !== "findings" && state.sheet !== "findings") return;
  const blocks = KINDS.map(block).filter(Boolean);
  show(
    byId("panel-findings"),
    h("h2", {}, t("findings")),
    blocks.length === 0 ? h("p", { class: "quiet" }, t("findingsNone")) : blocks,
  );
}

function block(kind) {
  const { n, list } = findingsOf(kind);
  if (n === 0) return null;
  const lines = list.slice(0, LISTED).map((finding) => h("li", {}, line(finding)));
  const rest = n - lines.length;
  return h(
    "section",
    { class: "block" },
    h("h3", {}, t(`findings_${kind}`), h("span", { class: "count" }, String(n))),
    h("ul", { class: "links" }, lines, rest > 0 ? h("li", { class: "quiet" }, t("findingsMore", { n: rest })) : null),
  );
}

// A finding about an element or a room of the site is a link to it.
function line({ code, text, global_id: id, name, place }) {
  const said = [has(`n_${code}`) ? word("n", code) : null, text ? sentence(text) : null].filter(Boolean).join(": ");
  const what = said || code;
  if (id !== null && (element(id) || space(id))) return link(id, nameOf(id), null, null, what);
  const of = [name ?? (id !== null ? taskName(id) : null), place].filter(Boolean).join(", ");
  return h("p", { class: "finding" }, of === "" ? what : `${of}: ${what}`);
}
