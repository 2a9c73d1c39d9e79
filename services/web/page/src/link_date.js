// Dates as links name them: `2024-04-15T08:00`, whatever other dates a later conversion has; `built` where everything stands.

/**
 * The date of a stop as links name it: without seconds if they are zero.
 * @type {(at: string | null) => string}
 */
export const linkDate = (at) => (at === null ? "built" : at.replace(/^(.{16}):00$/, "$1"));

// A date of a link as the documents write it; null for what is no date.
function fullDate(text) {
  const found = /^(\d{4}-\d\d-\d\d)(?:T(\d\d:\d\d)(:\d\d(?:\.\d+)?)?)?$/.exec(text);
  return found && `${found[1]}T${found[2] ?? "00:00"}${found[3] ?? ":00"}`;
}

/**
 * The stop whose maps hold at a date of a link: that at the date, or the last one before it if nothing changes between; null if
 * there is none.
 * @param {import("./types.js").DateStop[]} dates
 * @param {string} text
 */
export function stopValidAt(dates, text) {
  if (text === "built") return orNull(dates.findIndex((date) => date.at === null));
  const at = fullDate(text);
  if (at === null) return null;
  const stop = dates.findLastIndex((date) => date.at !== null && date.at <= at);
  if (stop < 0) return null;
  const { at: from, until } = dates[stop];
  return from === at || until === null || at < until ? stop : null;
}

const orNull = (stop) => (stop < 0 ? null : stop);
