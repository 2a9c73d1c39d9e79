// What a scan sees of the date shown.

import { segmentsOf, visiblePolygon } from "./geometry.js";
import { state } from "./state.js";
import { element, featuresOf, isClosed, isStanding, passageOf } from "./site.js";

const DEFAULT_RANGE_M = 10; // where the robot's profile gives no range

let seen = { waypoint: null, polygon: null };

/**
 * The polygon a scan sees: rays over the footprints of what stands at the height of the sensor. Doors that a robot
 * passes are taken as open.
 * @param {import("./types.js").Waypoint} waypoint
 * @returns {import("./types.js").Point[]}
 */
export function seenBy(waypoint) {
  if (seen.waypoint === waypoint) return seen.polygon;
  const { robot } = state.site;
  const z = waypoint.sensor_z_m ?? waypoint.z_m + (robot?.sensor_height_m ?? 1);
  const stands = ({ id, kind }) => {
    if (kind !== "element" || !isStanding(id)) return false;
    const { class: cls, aabb_m: box } = element(id);
    if (box && (box.min[2] > z || box.max[2] < z)) return false;
    return cls !== "door" || isClosed(passageOf(id, waypoint.storey));
  };
  const segments = featuresOf(waypoint.storey)
    .filter(stands)
    .flatMap((feature) => segmentsOf(feature.polygon));
  const polygon = visiblePolygon(waypoint.x_m, waypoint.y_m, robot?.lidar_range_m ?? DEFAULT_RANGE_M, segments);
  seen = { waypoint, polygon };
  return polygon;
}
