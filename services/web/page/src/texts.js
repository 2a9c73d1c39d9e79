// Words, dates and numbers in the language of the reader: that of the browser, or `?lang=` of the address.

import { SENTENCES, TABLE as PAGE_TABLE } from "./text_table.js";
import { SITE_TABLE } from "./text_table_site.js";

const TABLE = { ...PAGE_TABLE, ...SITE_TABLE };

const wanted = new URLSearchParams(location.search).get("lang") ?? navigator.language ?? "en";
const language = wanted.toLowerCase().startsWith("de") ? "de" : "en";
const column = language === "de" ? 1 : 0;

/**
 * @param {string} key
 * @param {Record<string, any>} values
 */
export function t(key, values = {}) {
  return TABLE[key][column].replace(/\{(\w+)\}/g, (_, name) => values[name] ?? "");
}

// Whether the table has a text.
export const has = (key) => Object.hasOwn(TABLE, key);

/**
 * The word for a value of the files; a value the table does not know is shown as it is.
 * @param {string} prefix
 * @param {string | null} value
 */
export function word(prefix, value) {
  const key = `${prefix}_${value}`;
  return Object.hasOwn(TABLE, key) ? t(key) : String(value).replaceAll("_", " ");
}

/**
 * A sentence of the reports in the reader's language; what stands in it is translated too.
 * @param {string} text
 * @returns {string}
 */
export function sentence(text) {
  if (language !== "de") return text;
  for (const [pattern, german] of SENTENCES) {
    const found = text.match(pattern);
    if (found) return german.replace(/\$(\d)/g, (_, k) => inSentence(found[k]));
  }
  return text;
}

const inSentence = (part) => (/^\d+\.\d+$/.test(part) ? part.replace(".", ",") : sentence(part));

// Fills the texts of index.html: `data-text` is the content, `data-name` the accessible name and the tooltip.
export function translate(root) {
  document.documentElement.lang = language;
  for (const node of root.querySelectorAll("[data-text]")) node.textContent = t(node.dataset.text);
  for (const node of root.querySelectorAll("[data-name]")) {
    node.setAttribute("aria-label", t(node.dataset.name));
    if (node.matches("button")) node.title = t(node.dataset.name);
  }
  for (const node of root.querySelectorAll("[data-hint]")) node.placeholder = t(node.dataset.hint);
}

// Times of the schedule are civil times without a zone: read and written as UTC, nothing is shifted.
const format = (options) =>
  new Intl.DateTimeFormat(language === "de" ? "de-DE" : "en-GB", { timeZone: "UTC", ...options });
const LONG = format({
  weekday: "short",
  day: "numeric",
  month: "long",
  year: "numeric",
  hour: "2-digit",
  minute: "2-digit",
});
const MEDIUM = format({
  weekday: "short",
  day: "numeric",
  month: "short",
  year: "numeric",
  hour: "2-digit",
  minute: "2-digit",
});
const SHORT = format({ day: "numeric", month: "short", year: "numeric", hour: "2-digit", minute: "2-digit" });
const DAY = format({ day: "numeric", month: "short" });
const MONTH = format({ month: "short", year: "numeric" });

/** @type {(at: string) => number} */
export const milliseconds = (at) => Date.parse(at.endsWith("Z") ? at : `${at}Z`);
/** @type {(at: string | null) => string} */
export const longDate = (at) => (at === null ? t("everythingBuilt") : LONG.format(milliseconds(at)));
/** @type {(at: string | null) => string} */
export const mediumDate = (at) => (at === null ? t("everythingBuilt") : MEDIUM.format(milliseconds(at)));
/** @type {(at: string | null) => string} */
export const shortDate = (at) => (at === null ? t("everythingBuilt") : SHORT.format(milliseconds(at)));
export const today = () =>
  new Date().toLocaleDateString(language === "de" ? "de-DE" : "en-GB", {
    day: "numeric",
    month: "short",
    year: "numeric",
  });
export const dayDate = (ms) => DAY.format(ms);
export const monthDate = (ms) => MONTH.format(ms);

// Names in the order of people: "Room 9" before "Room 10".
export const byName = new Intl.Collator(language, { numeric: true }).compare;

const numbers = new Map();
/**
 * @param {number} value
 * @param {number} digits
 */
export function number(value, digits = 1) {
  if (!numbers.has(digits)) {
    numbers.set(
      digits,
      new Intl.NumberFormat(language, { minimumFractionDigits: digits, maximumFractionDigits: digits }),
    );
  }
  return numbers.get(digits).format(value);
}

// Why a room is blocked, in words.
export function reasonText(why, nameOfTask) {
  if (why.startsWith("task:")) return t("w_task", { task: nameOfTask(why.slice(5)) });
  return word("w", why);
}
