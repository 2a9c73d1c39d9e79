// What lies under a point of the plan.

import { contains } from "./geometry.js";
import { isShown } from "./filter.js";
import { hasLayer, state } from "./state.js";
import { elementState, featuresOf } from "./site.js";
import { kindOf } from "./waypoint_kinds.js";

const WAYPOINT_RADIUS_PX = 14;

/**
 * Features under a point, the one people mean first: the smallest, and a room before what covers most of it.
 * @param {number} x
 * @param {number} y
 */
export function pick(x, y) {
  const hits = featuresOf(state.storey).filter((feature) => {
    const { box, kind } = feature;
    if (!hasLayer(kind === "room" ? "rooms" : "elements")) return false;
    if (!isShown(feature.id)) return false;
    if (x < box.x0 || x > box.x1 || y < box.y0 || y > box.y1) return false;
    if (kind === "element" && elementState(feature.id) === "removed") return false;
    return contains(feature.polygon, x, y);
  });
  const room = hits.find((hit) => hit.kind === "room");
  const rank = (hit) => (room && hit !== room && hit.area > 0.8 * room.area ? Number.MAX_VALUE : 0) + hit.area;
  return hits.sort((a, b) => rank(a) - rank(b));
}

/**
 * The waypoint within a finger's width, if waypoints are shown.
 * @param {import("leaflet").Map} map
 * @param {import("leaflet").LatLng} latlng
 */
export function pickWaypoint(map, latlng) {
  const at = map.latLngToContainerPoint(latlng);
  let best = null;
  let least = WAYPOINT_RADIUS_PX;
  for (const waypoint of state.doc?.waypoints ?? []) {
    if (waypoint.storey !== state.storey || !hasLayer(kindOf(waypoint).layer)) continue;
    const distance = map.latLngToContainerPoint([waypoint.y_m, waypoint.x_m]).distanceTo(at);
    if (distance < least) [best, least] = [waypoint, distance];
  }
  return best;
}
