// Where a storey lies on the plan.

import L from "leaflet";
import { state } from "./state.js";

/**
 * The rectangle of a storey of the site document, latlng is [y_m, x_m].
 * @param {import("./types.js").Storey} storey
 */
export function boundsOfStorey(storey) {
  const [x, y] = storey.origin_m;
  const [width, height] = storey.size_cells.map((cells) => cells * state.site.resolution_m);
  return L.latLngBounds([y, x], [y + height, x + width]);
}
