// The view that is shown as a viewpoint of BCF, and back. BCF has the coordinates of the IFC world, the page those of its maps.

import { isFiltering, isShown } from "./filter.js";
import { planMap } from "./plan.js";
import { element, space, storeyFor, storeyOf } from "./site.js";
import { state } from "./state.js";
import { elementsOfTask } from "./task_store.js";
import { pictureOf3d } from "./view3d.js";

const ABOVE_M = 20; // camera of a plan above the floor
const DISTANCE_MIN_M = 1;

/** @typedef {[number, number, number]} Vector */

function motion() {
  const { x_m: x = 0, y_m: y = 0, z_m: z = 0, yaw_rad: yaw = 0 } = state.site.frames?.map_from_world ?? {};
  return { x, y, z, cos: Math.cos(yaw), sin: Math.sin(yaw) };
}

/** @type {(v: Vector) => Vector} */
function directionInWorld([x, y, z]) {
  const { cos, sin } = motion();
  return [cos * x + sin * y, cos * y - sin * x, z];
}

/** @type {(v: Vector) => Vector} */
function pointInWorld([x, y, z]) {
  const m = motion();
  return directionInWorld([x - m.x, y - m.y, z - m.z]);
}

/** @type {(v: Vector) => Vector} */
function directionInMap([x, y, z]) {
  const { cos, sin } = motion();
  return [cos * x - sin * y, sin * x + cos * y, z];
}

/** @type {(v: Vector) => Vector} */
function pointInMap(point) {
  const m = motion();
  const [x, y, z] = directionInMap(point);
  return [x + m.x, y + m.y, z + m.z];
}

/** @type {(v: Vector) => Vector} */
function unit(v) {
  const length = Math.hypot(...v) || 1;
  return /** @type {Vector} */ (v.map((c) => c / length));
}

/**
 * The view that is shown, and its picture; a browser gives no picture of a page of files.
 * @returns {{viewpoint: import("./bcf_write.js").Viewpoint, picture: Uint8Array | null}}
 */
export function viewpointNow() {
  const selection = [...new Set([state.select, ...elementsOfTask(state.task)])].filter((id) => id !== null);
  const of3d = pictureOf3d();
  const shown = visibility();
  if (of3d?.camera) {
    const { camera, fieldOfView, cut, png } = of3d;
    const eye = /** @type {Vector} */ (camera.slice(0, 3));
    const direction = unit([camera[3] - eye[0], camera[4] - eye[1], camera[5] - eye[2]]);
    const flat = Math.hypot(direction[0], direction[1]);
    /** @type {Vector} upright: perpendicular to the direction, as near to the vertical as that allows */
    const up = flat < 1e-6 ? [0, 1, 0] : [(-direction[0] * direction[2]) / flat, (-direction[1] * direction[2]) / flat, flat];
    return {
      viewpoint: {
        ...shown,
        selection,
        eye: pointInWorld(eye),
        direction: directionInWorld(direction),
        up: directionInWorld(up),
        fieldOfView,
        height: null,
        clip: cut === null ? null : { at: pointInWorld([eye[0], eye[1], cut]), direction: [0, 0, 1] },
      },
      picture: bytesOf(png),
    };
  }
  const map = planMap();
  const { lat: y, lng: x } = map.getCenter();
  const height = (map.getSize().y * state.site.resolution_m) / 2 ** map.getZoom();
  const z = (storeyOf(state.storey)?.floor_z_m ?? 0) + ABOVE_M;
  return {
    viewpoint: {
      ...shown,
      selection,
      eye: pointInWorld([x, y, z]),
      direction: [0, 0, -1],
      up: directionInWorld([0, 1, 0]),
      fieldOfView: null,
      height,
      clip: null,
    },
    picture: bytesOf(pictureOfPlan()),
  };
}

function visibility() {
  if (!isFiltering()) return { visible: true, exceptions: [] };
  const all = [...Object.keys(state.site.elements), ...Object.keys(state.site.spaces)];
  const hidden = all.filter((id) => !isShown(id));
  if (2 * hidden.length < all.length) return { visible: true, exceptions: hidden };
  return { visible: false, exceptions: all.filter(isShown) };
}

function bytesOf(png) {
  if (png === null) return null;
  return Uint8Array.from(atob(png.slice(png.indexOf(",") + 1)), (letter) => letter.charCodeAt(0));
}

// Tiles and drawing of the plan in one picture; null where the browser does not give the pixels of a page of files.
function pictureOfPlan() {
  const container = planMap().getContainer();
  const frame = container.getBoundingClientRect();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.round(frame.width), Math.round(frame.height)];
  const ctx = canvas.getContext("2d");
  ctx.fillStyle = getComputedStyle(container).backgroundColor;
  ctx.fillRect(0, 0, canvas.width, canvas.height);
  ctx.imageSmoothingEnabled = false;
  /** @type {NodeListOf<HTMLImageElement | HTMLCanvasElement>} */
  const parts = container.querySelectorAll("img.leaflet-tile, canvas");
  for (const part of parts) {
    const { left, top, width, height } = part.getBoundingClientRect();
    if (width > 0 && (!(part instanceof HTMLImageElement) || part.naturalWidth > 0))
      ctx.drawImage(part, left - frame.left, top - frame.top, width, height);
  }
  try {
    return canvas.toDataURL("image/png");
  } catch {
    return null;
  }
}

/**
 * What to show for a viewpoint, and how many of its elements are not on these maps.
 * @param {import("./bcf_write.js").Viewpoint} viewpoint
 * @returns {{patch: Partial<import("./types.js").State>, missing: number}}
 */
export function patchOf({ selection, visible, exceptions, eye, direction, fieldOfView, height }) {
  const known = (id) => element(id) !== null || space(id) !== null;
  const select = selection.find(known) ?? null;
  const [at, towards] = [pointInMap(eye), unit(directionInMap(direction))];
  /** @type {Partial<import("./types.js").State>} */
  const patch = {
    select,
    task: null,
    hidden: visible ? exceptions.filter(known) : [],
    only: visible ? [] : exceptions.filter(known),
    storey: select === null ? storeyBelow(at[2] - ABOVE_M) : (storeyFor(select) ?? state.storey),
  };
  if (fieldOfView === null) {
    const pixels = planMap().getSize().y || 1;
    const zoom = Math.log2((pixels * state.site.resolution_m) / Math.max(height, 0.5));
    Object.assign(patch, { view: "plan", centre: [at[0], at[1]], zoom });
  } else {
    const distance = Math.max(DISTANCE_MIN_M, along(at, towards));
    const target = at.map((c, k) => c + distance * towards[k]);
    const round = (list) => list.map((value) => Math.round(1000 * value) / 1000);
    Object.assign(patch, { view: "3d", camera: [...round(at), ...round(target)] });
  }
  return { patch, missing: selection.filter((id) => !known(id)).length };
}

// BCF has no point that a camera looks at: that beside the middle of the site is taken.
function along(eye, direction) {
  const boxes = Object.values(state.site.elements).map((part) => part.aabb_m).filter(Boolean);
  if (boxes.length === 0) return 10;
  const middle = [0, 1, 2].map((k) => boxes.reduce((sum, box) => sum + (box.min[k] + box.max[k]) / 2, 0) / boxes.length);
  return middle.reduce((sum, c, k) => sum + (c - eye[k]) * direction[k], 0);
}

function storeyBelow(z) {
  const { storeys } = state.site;
  return storeys.reduce((best, storey) => (Math.abs(storey.floor_z_m - z) < Math.abs(best.floor_z_m - z) ? storey : best)).index;
}
