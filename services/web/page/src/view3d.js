// The 3D view: loads scene.js (three.js and the scene) when it is opened first, and keeps it on the date, the
// selection, the changes, the robot and the waypoints of the plan.

import { byId, inputById } from "./dom.js";
import { changedIds, comparedKinds } from "./changes.js";
import { isFiltering, isShown } from "./filter.js";
import { hasLayer, onChange, state, update } from "./state.js";
import { loadModel } from "./source.js";
import { element, elementState, isClosed, passageOf, storeyOf } from "./site.js";
import { elementsOfTask } from "./task_store.js";
import { number, t } from "./texts.js";
import { kindOf } from "./waypoint_kinds.js";

const CUT_ABOVE_FLOOR_M = 1.4; // a cut through walls and windows of the storey

let scene = null;
let loading = null;
let shownModel = null;

export function createView3d() {
  byId("view-plan").addEventListener("click", () => update({ view: "plan" }));
  byId("view-3d").addEventListener("click", () => update({ view: "3d" }));
  byId("cut").addEventListener("input", () => {
    cutFromSlider();
    update({ cut: Number(inputById("cut").value) });
  });
  onChange(["view"], showView);
  onChange(["doc", "calendar"], showModel);
  onChange(["compare", "compareDoc", "task", "tasks", "byState"], showLooks);
  onChange(["filter", "hidden", "only", "tasks", "storey"], showFiltered);
  onChange(["select"], () => scene?.select(state.select));
  onChange(["robot"], showRobot);
  onChange(["doc", "layers"], showWaypoints);
  // A link names a cut together with its storey; a storey that is chosen has its own.
  onChange(["storey", "cut"], (changed) => {
    if (changed.includes("storey") && !changed.includes("cut") && state.cut !== null) update({ cut: null });
    else cutAtStorey();
  });
  onChange(["camera"], () => scene?.setCamera(state.camera));
  new ResizeObserver(() => scene?.resize()).observe(byId("scene"));
  showView();
}

const isOpen = () => state.view === "3d";

function showView() {
  document.body.dataset.view = state.view;
  byId("view-plan").setAttribute("aria-pressed", String(!isOpen()));
  byId("view-3d").setAttribute("aria-pressed", String(isOpen()));
  byId("scene").hidden = byId("cut-box").hidden = !isOpen();
  if (isOpen()) open();
}

async function open() {
  try {
    loading ??= loadScene();
    await loading;
    scene.resize();
    cutAtStorey();
    scene.setCamera(state.camera);
    await showModel();
    showRobot();
    showWaypoints();
  } catch (error) {
    loading = null;
    tell(t("view3dFailed", { text: error.message }));
  }
}

const tell = (text) => (byId("scene-message").textContent = text);

async function loadScene() {
  tell(t("loading"));
  await new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = "scene.js";
    script.addEventListener("load", resolve);
    script.addEventListener("error", () => reject(new Error("scene.js")));
    document.head.append(script);
  });
  const onCamera = (camera) => update({ camera });
  const onPick = (id) => update({ select: id, tab: "details", sheet: id ? "details" : null });
  ghostOf = null;
  scene = globalThis.groundplanScene(byId("scene-canvas"), { onPick, onCamera, name: t("sceneName"), noWebgl: t("noWebgl") });
  globalThis.groundplanView3d = scene; // for tests: where an element is on the screen
  tell("");
}

// Loads the model of the date if it is another one than before. An answer that comes late is not shown.
async function showModel() {
  if (!scene || !isOpen() || !state.doc) return;
  const { model } = state.doc;
  if (model !== shownModel) {
    shownModel = model;
    if (model === null) {
      tell(t("noModel"));
      return;
    }
    try {
      const buffer = await loadModel(model);
      if (shownModel !== model) return;
      await scene.load(buffer);
      tell("");
    } catch (error) {
      shownModel = null;
      tell(t("failed", { what: error.message }));
      return;
    }
  }
  showLooks();
  showFiltered();
  scene.select(state.select);
}

// How elements look: doors as the robot passes them, else their states; over that two dates compared, and the task chosen.
function showLooks() {
  if (!scene || !isOpen() || !state.doc) return;
  const kinds = comparedKinds();
  const looks = { ...doorStates(), ...state.doc.elements };
  if (state.byState) for (const id of Object.keys(state.site.elements)) looks[id] = `by_${elementState(id)}`;
  for (const [id, kind] of kinds ?? []) looks[id] = kind;
  for (const id of elementsOfTask(state.task)) looks[id] = "task";
  scene.setStates(looks);
  scene.highlight(kinds === null ? [...changedIds()] : []);
  showGone(kinds);
}

function showFiltered() {
  if (!scene || !isOpen() || !state.doc) return;
  scene.setShown(isFiltering() ? isShown : null);
}

// What stood at the date compared with and is gone comes from the model of that date, where there is one.
let ghostOf = null;
async function showGone(kinds) {
  const gone = [...(kinds ?? [])].filter(([, kind]) => kind === "went").map(([id]) => id);
  const model = gone.length > 0 ? (state.compareDoc?.model ?? null) : null;
  const wanted = model === null ? null : `${model} ${gone.join(" ")}`;
  if (wanted === ghostOf) return;
  ghostOf = wanted;
  try {
    const buffer = model === null ? null : await loadModel(model);
    if (ghostOf === wanted) await scene.setGhosts(buffer, gone);
  } catch (error) {
    ghostOf = null;
    tell(t("failed", { what: error.message }));
  }
}

// Doors that stand have the colours of the plan: whether this robot passes them.
function doorStates() {
  const looks = {};
  for (const id of Object.keys(state.doc.passages ?? {})) {
    const passage = passageOf(id, element(id)?.attributes?.storey);
    looks[id] = isClosed(passage) ? "door_closed" : "door_passable";
  }
  return looks;
}

function showRobot() {
  if (!scene) return;
  const { robot } = state;
  const z_m = robot ? (storeyOf(robot.storey)?.floor_z_m ?? 0) : 0;
  scene.setRobot(robot ? { x_m: robot.x_m, y_m: robot.y_m, z_m, yaw_rad: robot.yaw_rad } : null);
}

function showWaypoints() {
  if (!scene || !state.doc) return;
  const shown = state.doc.waypoints.filter((w) => hasLayer(kindOf(w).layer));
  scene.setWaypoints(shown.map(({ x_m, y_m, z_m, kind }) => ({ x_m, y_m, z_m, kind })));
}

// The slider ends above everything: there it cuts nothing.
function range() {
  const boxes = Object.values(state.site.elements)
    .map((e) => e.aabb_m)
    .filter(Boolean);
  const low = boxes.reduce((z, box) => Math.min(z, box.min[2]), Infinity);
  const high = boxes.reduce((z, box) => Math.max(z, box.max[2]), -Infinity);
  return Number.isFinite(low) ? [low, high] : [0, 3];
}

function cutAtStorey() {
  if (!scene || !isOpen()) return;
  const [low, high] = range();
  const slider = inputById("cut");
  slider.min = low.toFixed(1);
  slider.max = (high + 0.5).toFixed(1);
  const ofStorey = (storeyOf(state.storey)?.floor_z_m ?? low) + CUT_ABOVE_FLOOR_M;
  slider.value = String(Math.min(state.cut ?? ofStorey, high + 0.5));
  cutFromSlider();
}

function cutFromSlider() {
  const slider = inputById("cut");
  const z = Number(slider.value);
  const whole = z >= Number(slider.max) - 0.05;
  const text = whole ? t("cutNone") : t("cutAt", { m: number(z) });
  scene?.setCut(whole ? null : z);
  slider.setAttribute("aria-valuetext", text);
  byId("cut-text").textContent = text;
}

/** The picture of the 3D view as a data address of a PNG, and its camera; null while it is not open. */
export function pictureOf3d() {
  if (!scene || !isOpen()) return null;
  return { png: scene.picture(), camera: scene.cameraNow(), fieldOfView: scene.fieldOfView, cut: cutNow() };
}

// Height above which everything is cut away; null without a cut.
function cutNow() {
  const slider = inputById("cut");
  const z = Number(slider.value);
  return z >= Number(slider.max) - 0.05 ? null : z;
}
