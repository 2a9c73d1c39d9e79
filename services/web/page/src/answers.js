// Answers of a live site about the room or door selected and about the way asked for. The server makes them of the maps shown;
// files have none.

import { loadAnswer } from "./source.js";
import { element, space } from "./site.js";
import { onChange, state, update } from "./state.js";

/** @type {Record<"about" | "wayAnswer", string | null>} what was asked last */
const asked = { about: null, wayAnswer: null };

export function createAnswers() {
  const ask = () => {
    askFor("about", aboutPath(state.select));
    const { from, to } = state;
    askFor("wayAnswer", from !== null && to !== null && from !== to ? ["way", from, to] : null);
  };
  onChange(["select", "from", "to", "doc", "status", "site"], ask);
  ask();
}

/** @type {(id: string | null) => string[] | null} */
function aboutPath(id) {
  if (id === null) return null;
  if (space(id)) return ["room", id];
  return element(id)?.attributes?.clear_width_m === undefined ? null : ["door", id];
}

/**
 * Asks once for each date and each word on whether the maps may be used; what comes late is not shown.
 * @param {"about" | "wayAnswer"} field
 * @param {string[] | null} path
 */
async function askFor(field, path) {
  const { site, doc, status } = state;
  const wanted = site.live && doc !== null ? path : null;
  const key = wanted && [doc.key, status?.why ?? "", ...wanted].join("\n");
  if (asked[field] === key) return;
  asked[field] = key;
  if (wanted === null) {
    update({ [field]: null });
    return;
  }
  const told = await loadAnswer(wanted).catch((error) => ({ answer: null, text: error.message }));
  if (asked[field] === key) update({ [field]: { path: wanted, ...told } });
}
