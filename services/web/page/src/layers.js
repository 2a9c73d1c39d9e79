// The list of storeys and the switches of the layers.

import { byId, closestTo, h, inputById, show } from "./dom.js";
import { hasLayer, LAYERS, onChange, state, toggleLayer, update } from "./state.js";
import { entryOf, storeyName } from "./site.js";
import { number, t, word } from "./texts.js";

const MAPS = LAYERS.slice(0, 4);

export function createLayers() {
  const list = byId("storeys");
  list.addEventListener("keydown", chooseByKey);
  list.addEventListener("click", (event) => {
    const option = closestTo(event, "[role=option]");
    if (option) update({ storey: Number(option.dataset.storey) });
  });
  onChange(["storey", "site", "doc"], showStoreys);
  onChange(["storey", "site"], () => requestAnimationFrame(showChosen));
  onChange(["layers"], showLayers);
  showStoreys();
  requestAnimationFrame(showChosen);
  makeLayers();
}

// The highest storey on top, as in a section through the building.
const fromTop = () => [...state.site.storeys].sort((a, b) => b.floor_z_m - a.floor_z_m || b.index - a.index);

function showStoreys() {
  const list = byId("storeys");
  show(
    list,
    fromTop().map((storey) => {
      const { index, floor_z_m: z, floor } = storey;
      const maps = state.doc?.storeys.some((s) => s.index === index) ?? true;
      const level = `${z < 0 ? "−" : "+"}${number(Math.abs(z), 2)} m`;
      return h(
        "div",
        {
          role: "option",
          id: `storey-${index}`,
          "data-storey": index,
          class: maps ? "" : "no-map",
          "aria-selected": String(index === state.storey),
          title: maps ? null : t("noMap"),
        },
        h("span", { class: "storey-name" }, storeyName(index)),
        h("span", { class: "storey-level" }, [level, ...notesOf(index, floor)].join(", ")),
      );
    }),
  );
  list.setAttribute("aria-activedescendant", `storey-${state.storey}`);
  const note = byId("no-map");
  const shown = state.doc?.storeys.find((s) => s.index === state.storey);
  note.textContent = shown ? word("m", shown.status) : t("noMap");
  note.hidden = state.doc === null || shown?.status === "ok";
}

// What is to be known of a storey: that its floor is assumed, that the robot has to be put there.
function notesOf(index, floor) {
  const placed = entryOf(index) === "placed" && state.site.storeys.length > 1;
  return [floor === "assumed" ? t("assumedFloor") : null, placed ? t("placedThere") : null].filter(Boolean);
}

// Scrolls the list, and only it, so far that the storey chosen is seen.
function showChosen() {
  const list = byId("storeys");
  const option = byId(`storey-${state.storey}`);
  const top = option.offsetTop - list.offsetTop;
  const bottom = top + option.offsetHeight - list.clientHeight;
  list.scrollTop = Math.min(top, Math.max(bottom, list.scrollTop));
}

function chooseByKey(event) {
  const order = fromTop();
  const now = order.findIndex((storey) => storey.index === state.storey);
  const next = { ArrowUp: now - 1, ArrowDown: now + 1, Home: 0, End: order.length - 1 }[event.key];
  if (next === undefined) return;
  event.preventDefault();
  const storey = order[Math.max(0, Math.min(order.length - 1, next))];
  update({ storey: storey.index });
}

function makeLayers() {
  const row = (layer) =>
    h(
      "label",
      { class: "switch" },
      h("input", {
        type: "checkbox",
        id: `layer-${layer}`,
        checked: hasLayer(layer),
        onchange: (event) => toggleLayer(layer, event.target.checked),
      }),
      h("span", {}, t(`layer_${layer}`)),
    );
  show(
    byId("layers"),
    h("fieldset", {}, h("legend", {}, t("layerMaps")), MAPS.map(row)),
    h("fieldset", {}, h("legend", {}, t("layerSite")), LAYERS.slice(4).map(row)),
  );
}

function showLayers() {
  for (const layer of LAYERS) inputById(`layer-${layer}`).checked = hasLayer(layer);
}
