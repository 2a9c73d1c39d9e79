// The robot and its waypoints in the 3D view, in the frame `map`.

import {
  ConeGeometry, CylinderGeometry, Group, InstancedMesh, Matrix4, Mesh, MeshLambertMaterial, OctahedronGeometry,
} from "three";
import { waypointKinds } from "./waypoint_kinds.js";

const ROBOT = "#00897b";
const ROBOT_RADIUS_M = 0.3;
const ROBOT_HEIGHT_M = 0.6;
const WAYPOINT_RADIUS_M = 0.18;
const WAYPOINT_ABOVE_FLOOR_M = 0.3;

/** A cylinder with a cone that points where the robot looks; its origin is on the floor. */
export function robotMark() {
  const material = new MeshLambertMaterial({ color: ROBOT });
  const body = new Mesh(new CylinderGeometry(ROBOT_RADIUS_M, ROBOT_RADIUS_M, ROBOT_HEIGHT_M, 24), material);
  body.rotation.x = Math.PI / 2;
  body.position.z = ROBOT_HEIGHT_M / 2;
  const nose = new Mesh(new ConeGeometry(ROBOT_RADIUS_M * 0.6, ROBOT_RADIUS_M * 1.5, 16), material);
  // Cones point along Y; the robot looks along X.
  nose.rotation.z = -Math.PI / 2;
  nose.position.set(ROBOT_RADIUS_M * 1.6, 0, ROBOT_HEIGHT_M / 2);
  const group = new Group();
  group.add(body, nose);
  group.visible = false;
  return group;
}

/** One instanced mesh for each kind of waypoint. */
export function waypointMarks(waypoints) {
  const group = new Group();
  for (const [kind, { colour_3d }] of waypointKinds()) {
    const own = waypoints.filter((waypoint) => waypoint.kind === kind);
    if (own.length === 0) continue;
    const geometry = new OctahedronGeometry(WAYPOINT_RADIUS_M);
    const mesh = new InstancedMesh(geometry, new MeshLambertMaterial({ color: colour_3d }), own.length);
    own.forEach(({ x_m, y_m, z_m }, k) =>
      mesh.setMatrixAt(k, new Matrix4().makeTranslation(x_m, y_m, z_m + WAYPOINT_ABOVE_FLOOR_M)),
    );
    group.add(mesh);
  }
  return group;
}

/** Frees what the graphics card holds of marks. */
export function freeMarks(group) {
  group.traverse((object) => {
    if (!object.isMesh) return;
    object.geometry.dispose();
    object.material.dispose();
    if (object.isInstancedMesh) object.dispose();
  });
}
