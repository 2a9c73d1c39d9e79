// The building in the 3D view: elements of a GLB by GlobalId, and how their states, changes and the selection look.

import { Box3, Color, DoubleSide, Group, MeshLambertMaterial } from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const GLOBAL_ID = /^[0-9A-Za-z_$]{22}$/;
const SELECTED = "#1a73e8";
const CHANGED = "#f9a825";
// How states and verdicts look; every other state looks as built. Doors have the colours of style.css.
const LOOKS = {
  in_progress: { opacity: 0.5 },
  being_removed: { opacity: 0.5, colour: "#c62828" },
  not_started: { opacity: 0.15 },
  removed: { opacity: 0.15 },
  door_passable: { opacity: 1, colour: "#1f9d55" },
  door_closed: { opacity: 1, colour: "#d13a2f" },
  late: { opacity: 0.7, colour: "#c62828" },
  early: { opacity: 1, colour: "#8e24aa" },
  displaced: { opacity: 1, colour: "#ef6c00" },
  came: { opacity: 1, colour: "#159947" },
  went: { opacity: 0.6, colour: "#d6246e" },
  state: { opacity: 1, colour: "#f9a825" },
  task: { opacity: 1, colour: "#7c3aed" },
  by_built: { opacity: 1, colour: "#9aa3ad" },
  by_not_started: { opacity: 0.15, colour: "#7d8896" },
  by_in_progress: { opacity: 0.85, colour: "#e08a00" },
  by_being_removed: { opacity: 0.7, colour: "#c62828" },
  by_removed: { opacity: 0.15, colour: "#c62828" },
};

/** The building of a GLB; `group` is in the frame `map`, in metres, Z up. */
export async function readModel(arrayBuffer) {
  const gltf = await new GLTFLoader().parseAsync(arrayBuffer, "");
  const group = new Group();
  // glTF is Y up.
  group.rotation.x = Math.PI / 2;
  group.add(gltf.scene);
  group.updateMatrixWorld(true);
  const elements = new Map();
  collect(gltf.scene, null, elements);
  return { group, elements, box: new Box3().setFromObject(group) };
}

// Meshes below a node that is named by a GlobalId belong to that element; three changes the names of nodes, not those in userData.
function collect(object, owner, elements) {
  const name = object.userData.name;
  const globalId = typeof name === "string" && GLOBAL_ID.test(name) ? name : owner;
  if (object.isMesh) {
    object.userData.globalId = globalId;
    object.userData.given = object.material;
    if (globalId !== null) {
      if (!elements.has(globalId)) elements.set(globalId, []);
      elements.get(globalId).push(object);
    }
  }
  for (const child of object.children) collect(child, globalId, elements);
}

/**
 * Gives each mesh the material of its element's look; `materials` keeps one for each look. `shown` says of GlobalIds whether they
 * are seen; all are for null.
 */
export function paintModel(model, looks, materials, shown) {
  model.group.traverse((object) => {
    if (!object.isMesh) return;
    const { globalId } = object.userData;
    object.visible = shown === null || (globalId !== null && shown(globalId));
    if (object.visible) object.material = materialOf(object.userData, looks, materials);
  });
}

function materialOf({ globalId, given }, { selected, changed, states }, materials) {
  const look = (globalId !== null && LOOKS[states[globalId]]) || { opacity: 1 };
  let colour = look.colour || null;
  if (changed.has(globalId)) colour = CHANGED;
  if (globalId !== null && globalId === selected) colour = SELECTED;
  const own = colour ? new Color(colour) : given.color;
  // What is selected is seen, whatever its state.
  const opacity = Math.max(given.opacity * look.opacity, colour === SELECTED ? 0.6 : 0);
  const key = `${own.getHexString()} ${opacity.toFixed(3)}`;
  if (!materials.has(key)) {
    const transparent = opacity < 1;
    materials.set(
      key,
      new MeshLambertMaterial({ color: own, side: DoubleSide, transparent, opacity, depthWrite: !transparent }),
    );
  }
  return materials.get(key);
}

/** The box of an element in `map`, or null where the model has none of that name. */
export function elementBox(model, globalId) {
  const meshes = model?.elements.get(globalId);
  if (!meshes) return null;
  const box = new Box3();
  for (const mesh of meshes) box.expandByObject(mesh);
  return box;
}

/** Frees what the graphics card holds of a model. */
export function freeModel(model) {
  model.group.traverse((object) => {
    if (object.isMesh) {
      object.geometry.dispose();
      object.userData.given.dispose();
    }
  });
}
