// Builds DOM nodes. Text always becomes a text node, so that names from a model can never be markup.

const SVG = "http://www.w3.org/2000/svg";

/** @typedef {Node | string | null | undefined | false | Child[]} Child */

/**
 * A node of `tag` with attributes, listeners (`onclick`) and children (nodes, strings, arrays; null is left out).
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Record<string, any>} attributes
 * @param {Child[]} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function h(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

/**
 * The same in SVG.
 * @param {string} tag
 * @param {Record<string, any>} attributes
 * @param {Child[]} children
 * @returns {SVGElement}
 */
export function svg(tag, attributes = {}, ...children) {
  return fill(/** @type {SVGElement} */ (document.createElementNS(SVG, tag)), attributes, children);
}

/**
 * @template {Element} E
 * @param {E} node
 * @param {Record<string, any>} attributes
 * @param {Child[]} children
 */
function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...flattened(children));
  return node;
}

export const byId = (id) => document.getElementById(id);

/** @type {(id: string) => HTMLInputElement} */
export const inputById = (id) => /** @type {HTMLInputElement} */ (byId(id));

/** @type {(id: string) => HTMLButtonElement} */
export const buttonById = (id) => /** @type {HTMLButtonElement} */ (byId(id));

/**
 * The node that an event meets, or the nearest one around it that a selector matches; null if there is none.
 * @param {Event} event
 * @param {string} selector
 * @returns {HTMLElement | null}
 */
export const closestTo = (event, selector) => /** @type {Element} */ (event.target).closest(selector);

/**
 * What there is of children, in one list.
 * @param {Child[]} children
 * @returns {(Node | string)[]}
 */
function flattened(children) {
  return /** @type {any[]} */ (children).flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false);
}

/**
 * Replaces the children of a node. The keyboard's focus goes to what has the same id or text as before.
 * @param {HTMLElement} node
 * @param {Child[]} children
 */
export function show(node, ...children) {
  const focused =
    node.contains(document.activeElement) && document.activeElement !== node ? document.activeElement : null;
  node.replaceChildren(...flattened(children));
  if (focused === null) return;
  const same = [.../** @type {NodeListOf<HTMLElement>} */ (node.querySelectorAll(focused.tagName))].find((other) =>
    focused.id !== "" ? other.id === focused.id : other.textContent === focused.textContent,
  );
  (same ?? (node.tabIndex >= 0 ? node : null))?.focus({ preventScroll: true });
}

/**
 * An icon of index.html's symbol table.
 * @param {string} name
 */
export function icon(name) {
  return svg(
    "svg",
    { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true" },
    svg("use", { href: `#icon-${name}` }),
  );
}

/**
 * Label and value of a fact; nothing if the value is missing.
 * @param {Child} label
 * @param {Child} value
 */
export function fact(label, value) {
  if (value === null || value === undefined || value === "") return null;
  return [h("dt", {}, label), h("dd", {}, value)];
}
