// Lines of an answer. What they say is written by the server; GlobalIds in it become links.

import { h } from "./dom.js";
import { element, nameOf, space } from "./site.js";
import { update } from "./state.js";
import { sentence, t } from "./texts.js";

const GLOBAL_ID = /\(?([0-9A-Za-z_$]{22})\)?/;

/**
 * The lines behind the first, which names what the answer is about.
 * @param {import("./types.js").Told | null} told
 */
export function answerBlock(told) {
  if (told === null) return null;
  return [h("h3", {}, t("answer")), answerLines(told.answer === null ? [told.text] : linesOf(told).slice(1))];
}

/** @param {import("./types.js").Told} told */
export const linesOf = (told) => told.text.trim().split("\n").map((line) => sentence(line.trim()));

/** @param {string[]} lines */
export const answerLines = (lines) => h("ul", { class: "plain answer" }, lines.map((line) => h("li", {}, parts(line))));

/**
 * A name before its GlobalId in brackets is the text of the link.
 * @param {string} line
 * @returns {import("./dom.js").Child[]}
 */
function parts(line) {
  const found = line.match(GLOBAL_ID);
  if (found === null) return [line];
  const [whole, id] = found;
  const [before, after] = [line.slice(0, found.index), line.slice(found.index + whole.length)];
  if (!space(id) && !element(id)) return [before + whole, ...parts(after)];
  const name = nameOf(id);
  const text = before.endsWith(`${name} `) ? before.slice(0, -name.length - 1) : before;
  const link = h(
    "button",
    { type: "button", class: "link inline", onclick: () => update({ select: id, tab: "details" }) },
    name,
  );
  return [text, link, ...parts(after)];
}
