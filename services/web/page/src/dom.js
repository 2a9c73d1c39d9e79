// Builds DOM nodes. Text always becomes a text node, so that names from a model can never be markup.

const SVG = "http://www.w3.org/2000/svg";

// A node of `tag` with attributes, listeners (`onclick`) and children (nodes, strings, arrays; null is left out).
export function h(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return node;
}

export const byId = (id) => document.getElementById(id);

// Replaces the children of a node. The keyboard's focus goes to what has the same id or text as before.
export function show(node, ...children) {
  const focused =
    node.contains(document.activeElement) && document.activeElement !== node ? document.activeElement : null;
  node.replaceChildren(
    ...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false),
  );
  if (focused === null) return;
  const same = [...node.querySelectorAll(focused.tagName)].find((other) =>
    focused.id !== "" ? other.id === focused.id : other.textContent === focused.textContent,
  );
  (same ?? (node.tabIndex >= 0 ? node : null))?.focus({ preventScroll: true });
}

// An icon of index.html's symbol table.
export function icon(name) {
  return svg(
    "svg",
    { class: "icon", viewBox: "0 0 24 24", "aria-hidden": "true" },
    svg("use", { href: `#icon-${name}` }),
  );
}

// Label and value of a fact; nothing if the value is missing.
export function fact(label, value) {
  if (value === null || value === undefined || value === "") return null;
  return [h("dt", {}, label), h("dd", {}, value)];
}
