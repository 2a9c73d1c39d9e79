// The 3D view: `groundplanScene(container, options)` shows a GLB of the building in the frame `map`, Z up, in metres.
//
// options: onPick(globalId) when an element is clicked; onCamera([x, y, z, x, y, z]) when a person moved the camera, with its place
// and what it looks at; name, the canvas's accessible name; noWebgl, the text where there is none.
// A picture is drawn when something changed, never in a loop. The canvas is transparent, the background is the page's.

import {
  DirectionalLight, HemisphereLight, PerspectiveCamera, Plane, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { elementBox, freeModel, paintModel, readModel } from "./scene_model.js";
import { freeMarks, robotMark, waypointMarks } from "./scene_marks.js";

const FIELD_OF_VIEW_DEG = 40;
const FROM_SOUTH_WEST = new Vector3(-0.45, -0.8, 0.75).normalize();
// A pointer that moved farther than this turned the view; it did not pick.
const CLICK_PX = 5;
const PIXEL_RATIO_MAX = 2;
const FRAME_MARGIN = 1.08;
const ZOOM_STEP = 1.2;
const NAME = "3D view. Arrow keys move, with Shift they turn, plus and minus zoom, Home shows the whole building.";
const NO_WEBGL = "This browser cannot show the 3D view: it has no WebGL.";

globalThis.groundplanScene = function groundplanScene(container, options = {}) {
  const { onPick = () => {}, onCamera = () => {}, name = NAME, noWebgl = NO_WEBGL } = options;
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("webgl2", { antialias: true, alpha: true });
  if (!context) return messageOnly(container, noWebgl);
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", name);
  canvas.tabIndex = 0;
  canvas.style.display = "block";
  container.append(canvas);

  const renderer = new WebGLRenderer({ canvas, context });
  renderer.setPixelRatio(pixelRatio(context));
  renderer.setClearColor(0x000000, 0);
  const camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.1, 1000);
  camera.up.set(0, 0, 1);
  const scene = new Scene();
  addLights(scene, camera);
  const controls = new OrbitControls(camera, canvas);
  controls.screenSpacePanning = false;
  controls.maxPolarAngle = Math.PI / 2;
  controls.listenToKeyEvents(canvas);

  const cut = new Plane(new Vector3(0, 0, -1), 0);
  const looks = { selected: null, changed: new Set(), states: {} };
  const materials = new Map();
  const robot = robotMark();
  scene.add(robot);
  let waypoints = waypointMarks([]);
  let model = null;
  let ghosts = null;
  let ghostLoads = 0;
  let shown = null;
  let framed = false;
  let wantedCamera = null;
  let loads = 0;
  let frame = null;

  function draw() {
    frame = null;
    renderer.render(scene, camera);
  }
  function drawSoon() {
    if (frame === null) frame = requestAnimationFrame(draw);
  }
  function paint() {
    if (model) paintModel(model, looks, materials, shown);
    if (ghosts) paintModel(ghosts, looks, materials, (globalId) => ghosts.ids.has(globalId) && (shown === null || shown(globalId)));
    drawSoon();
  }
  function showAll() {
    if (!model || model.box.isEmpty()) return;
    frameBox(camera, controls, model.box);
    framed = true;
    drawSoon();
  }
  function resize() {
    const { clientWidth, clientHeight } = container;
    if (clientWidth === 0 || clientHeight === 0) return;
    renderer.setSize(clientWidth, clientHeight);
    camera.aspect = clientWidth / clientHeight;
    camera.updateProjectionMatrix();
    // Setting the size clears the canvas.
    draw();
  }
  // Names of elements at a place of the canvas, nearest first; what is cut away is not hit.
  function pickAt(clientX, clientY) {
    if (!model) return null;
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const at = new Vector2(((clientX - left) / width) * 2 - 1, 1 - ((clientY - top) / height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, camera);
    const hits = ray.intersectObject(model.group, true);
    const isShown = ({ point }) => renderer.clippingPlanes.every((plane) => plane.distanceToPoint(point) >= 0);
    return hits.find((hit) => hit.object.visible && isShown(hit))?.object.userData.globalId ?? null;
  }

  const cameraNow = () => [...camera.position, ...controls.target].map((value) => Math.round(1000 * value) / 1000);
  function applyCamera() {
    if (!model || wantedCamera === null) return;
    if (!framed) showAll();
    if (wantedCamera.every((value, k) => Math.abs(value - cameraNow()[k]) < 0.002)) return;
    camera.position.fromArray(wantedCamera);
    controls.target.fromArray(wantedCamera, 3);
    controls.update();
    drawSoon();
  }
  controls.addEventListener("change", drawSoon);
  controls.addEventListener("end", () => onCamera(cameraNow()));
  const sizes = new ResizeObserver(resize);
  sizes.observe(container);
  // Printers take the canvas outside of a frame of animation.
  window.addEventListener("beforeprint", draw);
  canvas.addEventListener("webglcontextrestored", drawSoon);
  onClick(canvas, (x, y) => {
    const globalId = pickAt(x, y);
    if (globalId !== null) onPick(globalId);
  });
  canvas.addEventListener("keydown", (event) => {
    const zoom = { "+": 1 / ZOOM_STEP, "=": 1 / ZOOM_STEP, "-": ZOOM_STEP }[event.key];
    if (zoom) {
      camera.position.sub(controls.target).multiplyScalar(zoom).add(controls.target);
      controls.update();
      drawSoon();
      onCamera(cameraNow());
    } else if (event.key === "Home") {
      showAll();
      onCamera(cameraNow());
    } else {
      return;
    }
    event.preventDefault();
  });
  resize();

  return {
    /** Shows the building of a GLB, or none; of several calls the last one counts. */
    async load(arrayBuffer) {
      const own = ++loads;
      const next = arrayBuffer ? await readModel(arrayBuffer) : null;
      if (own !== loads) {
        if (next) freeModel(next);
        return;
      }
      if (model) {
        scene.remove(model.group);
        freeModel(model);
      }
      model = next;
      if (model) scene.add(model.group);
      paint();
      if (!framed) showAll();
      applyCamera();
    },
    /** Puts the camera where a link says; of a building that is not loaded yet, once it is. */
    setCamera(list) {
      wantedCamera = list;
      applyCamera();
    },
    /** Hides everything above a height in `map`, or nothing. */
    setCut(zMetres) {
      cut.constant = zMetres ?? 0;
      renderer.clippingPlanes = zMetres === null || zMetres === undefined ? [] : [cut];
      drawSoon();
    },
    select(globalId) {
      looks.selected = globalId ?? null;
      paint();
    },
    highlight(globalIds) {
      looks.changed = new Set(globalIds);
      paint();
    },
    setStates(states) {
      looks.states = states;
      paint();
    },
    /** Shows the elements alone of which a function of their GlobalId says so; all for null. */
    setShown(isShown) {
      shown = isShown;
      paint();
    },
    /** Adds elements of another model, which is a GLB, to the building; null takes them away. */
    async setGhosts(arrayBuffer, globalIds) {
      const own = ++ghostLoads;
      const next = arrayBuffer ? await readModel(arrayBuffer) : null;
      if (own !== ghostLoads) {
        if (next) freeModel(next);
        return;
      }
      if (ghosts) {
        scene.remove(ghosts.group);
        freeModel(ghosts);
      }
      ghosts = next && { ...next, ids: new Set(globalIds) };
      if (ghosts) scene.add(ghosts.group);
      paint();
    },
    /** What is shown, as the data address of a PNG. */
    picture() {
      renderer.render(scene, camera);
      return canvas.toDataURL("image/png");
    },
    cameraNow,
    fieldOfView: FIELD_OF_VIEW_DEG,
    setRobot(pose) {
      robot.visible = Boolean(pose);
      if (pose) {
        robot.position.set(pose.x_m, pose.y_m, pose.z_m);
        robot.rotation.z = pose.yaw_rad;
      }
      drawSoon();
    },
    setWaypoints(list) {
      scene.remove(waypoints);
      freeMarks(waypoints);
      waypoints = waypointMarks(list);
      scene.add(waypoints);
      drawSoon();
    },
    resize,
    /** Where the middle of an element is on the screen, in pixels of the page, or null. */
    project(globalId) {
      const box = elementBox(model, globalId);
      if (!box) return null;
      const at = box.getCenter(new Vector3()).project(camera);
      if (at.z < -1 || 1 < at.z) return null;
      const { left, top, width, height } = canvas.getBoundingClientRect();
      return [left + ((at.x + 1) / 2) * width, top + ((1 - at.y) / 2) * height];
    },
    dispose() {
      loads++;
      ghostLoads++;
      if (frame !== null) cancelAnimationFrame(frame);
      sizes.disconnect();
      window.removeEventListener("beforeprint", draw);
      controls.dispose();
      if (model) freeModel(model);
      if (ghosts) freeModel(ghosts);
      freeMarks(robot);
      freeMarks(waypoints);
      for (const material of materials.values()) material.dispose();
      renderer.dispose();
      canvas.remove();
    },
  };
};

function messageOnly(container, text) {
  const message = document.createElement("p");
  message.setAttribute("role", "alert");
  message.textContent = text;
  container.append(message);
  const nothing = () => {};
  return {
    load: async () => {}, setCut: nothing, select: nothing, highlight: nothing, setStates: nothing, setRobot: nothing,
    setWaypoints: nothing, setCamera: nothing, setShown: nothing, setGhosts: async () => {}, resize: nothing, project: () => null,
    picture: () => null, cameraNow: () => null, fieldOfView: FIELD_OF_VIEW_DEG, dispose: () => message.remove(),
  };
}

// Every pixel costs time where the processor draws.
function pixelRatio(context) {
  const info = context.getExtension("WEBGL_debug_renderer_info");
  const drawnBy = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  return /swiftshader|llvmpipe|software/i.test(drawnBy) ? 1 : Math.min(window.devicePixelRatio || 1, PIXEL_RATIO_MAX);
}

function addLights(scene, camera) {
  const sky = new HemisphereLight("#ffffff", "#8d8d8d", 2.2);
  sky.position.set(0, 0, 1);
  const lamp = new DirectionalLight("#ffffff", 1.6);
  lamp.position.set(-0.6, 0.3, 1);
  camera.add(lamp);
  scene.add(sky, camera);
}

// Moves the camera back along its direction until every corner of the box is in the picture.
function frameBox(camera, controls, box) {
  const centre = box.getCenter(new Vector3());
  camera.position.copy(centre).add(FROM_SOUTH_WEST);
  camera.lookAt(centre);
  const [right, up, back] = [new Vector3(), new Vector3(), new Vector3()];
  camera.updateMatrixWorld();
  camera.matrixWorld.extractBasis(right, up, back);
  const high = Math.tan((camera.fov * Math.PI) / 360);
  const wide = high * camera.aspect;
  let distance = 0;
  for (const x of [box.min.x, box.max.x])
    for (const y of [box.min.y, box.max.y])
      for (const z of [box.min.z, box.max.z]) {
        const corner = new Vector3(x, y, z).sub(centre);
        const aside = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / high);
        distance = Math.max(distance, corner.dot(back) + aside);
      }
  distance *= FRAME_MARGIN;
  controls.target.copy(centre);
  camera.position.copy(centre).addScaledVector(FROM_SOUTH_WEST, distance);
  camera.near = distance / 200;
  camera.far = distance * 20;
  camera.updateProjectionMatrix();
  controls.update();
}

// Calls back with the place of a click by one pointer that did not move meanwhile.
function onClick(canvas, callback) {
  let down = null;
  canvas.addEventListener("pointerdown", (event) => {
    down = event.isPrimary && event.button === 0 ? event : null;
  });
  canvas.addEventListener("pointerup", (event) => {
    if (!down || event.pointerId !== down.pointerId) return;
    const moved = Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY);
    down = null;
    if (moved <= CLICK_PX) callback(event.clientX, event.clientY);
  });
}
