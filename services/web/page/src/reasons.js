// Why a room or a door is closed to the robot, in words.

import { state } from "./state.js";
import { nameOf, spaceState, taskName } from "./site.js";
import { reasonText, sentence, word } from "./texts.js";

/**
 * Why no way leads the robot to a room, or why it has no waypoint there, or null.
 * @param {string} id GlobalId
 * @returns {string | null}
 */
export function reachReason(id) {
  const now = spaceState(id);
  if (now?.state === "blocked") return roomReasons(id);
  return noWayReason(id) ?? (now?.reason ? inWords(now.reason) : null);
}

/**
 * What keeps the robot from a room that the schedule has open, as the plan of its ways found it; null where it gets there.
 * @param {string} id GlobalId
 * @returns {string | null}
 */
export function noWayReason(id) {
  const now = spaceState(id);
  return now?.no_way ? inWords(now.no_way) : null;
}

// Sentences of the reports, in which GlobalIds become names.
function inWords(text) {
  const sentences = text.split("; ").map(sentence).join("; ");
  return sentences.replace(/[0-9A-Za-z_$]{22}/g, (found) => nameOf(found));
}

/** @param {string} id GlobalId */
export function roomReasons(id) {
  return (spaceState(id)?.why ?? []).map((why) => reasonText(why, taskName)).join(", ");
}

/**
 * Every reason of the report, or the word for the passage where the report has none.
 * @param {string} id GlobalId
 * @param {string} passage
 */
export function doorReasons(id, passage) {
  const reasons = (state.doc?.doors ?? []).filter((door) => door.global_id === id).flatMap((door) => door.reasons);
  const texts = reasons.map((reason) => reason.text).filter((text, i, all) => all.indexOf(text) === i);
  return texts.length > 0 ? texts.map(sentence).join("; ") : word("p", passage);
}
