// Why a room or a door is closed to the robot, in words.

import { state } from "./state.js";
import { nameOf, spaceState, taskName } from "./site.js";
import { reasonText, sentence, word } from "./texts.js";

// Why the robot has no waypoint in a room, or null. GlobalIds in the sentence become names.
export function reachReason(id) {
  const now = spaceState(id);
  if (!now?.reason) return null;
  if (now.state === "blocked") return roomReasons(id);
  return sentence(now.reason).replace(/[0-9A-Za-z_$]{22}/g, (found) => nameOf(found));
}

export function roomReasons(id) {
  return (spaceState(id)?.why ?? []).map((why) => reasonText(why, taskName)).join(", ");
}

// Every reason of the report, or the word for the passage where the report has none.
export function doorReasons(id, passage) {
  const reasons = (state.doc?.doors ?? []).filter((door) => door.global_id === id).flatMap((door) => door.reasons);
  const texts = reasons.map((reason) => reason.text).filter((text, i, all) => all.indexOf(text) === i);
  return texts.length > 0 ? texts.map(sentence).join("; ") : word("p", passage);
}
