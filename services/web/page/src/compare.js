// The date that the one shown is compared with: its stop, and of files its document, which has the doors.

import { onChange, state, update } from "./state.js";
import { say } from "./live.js";
import { loadDate } from "./source.js";
import { element } from "./site.js";
import { t } from "./texts.js";

export function createCompare() {
  onChange(["compare", "site"], loadCompared);
  loadCompared();
}

async function loadCompared() {
  const stop = comparedStop();
  const key = stop === null ? null : state.site.dates[stop].key;
  if (state.compareDoc !== null && state.compareDoc.key !== key) update({ compareDoc: null });
  if (key === null || state.compareDoc !== null) return;
  try {
    const doc = await loadDate(key);
    if (comparedStop() === stop) update({ compareDoc: doc });
  } catch (error) {
    say(t("failed", { what: error.message }));
  }
}

/** The stop compared with, or null. */
export function comparedStop() {
  if (state.compare === null) return null;
  const stop = state.site.dates.findIndex((date) => date.at === state.compare);
  return stop < 0 ? null : stop;
}

/** The stop whose states hold at the date shown; a live site may stand between two. */
export function shownStop() {
  const { site, stop, doc } = state;
  if (stop !== null) return stop;
  const at = doc?.at ?? null;
  if (at === null) return null;
  const held = site.dates.findLastIndex((date) => date.at !== null && date.at <= at);
  return held < 0 ? null : held;
}

/**
 * Doors that hang at both dates and that the robot can pass at one of them only, with their passage before and now; null where it is not
 * known. Whether an opening without its door is a way is not in the documents of a date.
 * @returns {{opened: [string, string, string][], closed: [string, string, string][]} | null}
 */
export function doorChanges() {
  const { doc, compareDoc } = state;
  if (doc === null || compareDoc === null) return null;
  const passage = (of, id) => {
    const all = of.passages[id] ?? {};
    return all[element(id)?.attributes?.storey] ?? Object.values(all)[0] ?? "absent";
  };
  const opened = [];
  const closed = [];
  for (const id of new Set([...Object.keys(doc.passages), ...Object.keys(compareDoc.passages)])) {
    const [was, is] = [passage(compareDoc, id), passage(doc, id)];
    if (was === "absent" || is === "absent" || (was === "passable") === (is === "passable")) continue;
    (is === "passable" ? opened : closed).push([id, was, is]);
  }
  return { opened, closed };
}
