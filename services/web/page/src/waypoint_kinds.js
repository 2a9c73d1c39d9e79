// How each kind of waypoint is shown: its layer, ink, mark, colour in 3D, and whether it sees an area. A kind that is not here is told, not drawn as
// another.

/**
 * @typedef {object} WaypointKind
 * @property {string} layer the layer of the page that it belongs to
 * @property {string} ink name of its colour
 * @property {"disc" | "diamond"} mark
 * @property {string} colour_3d its colour in the 3D view, which has no style sheet
 * @property {boolean} sees_area true if `covers_m2` and what is seen from it are shown
 */

/** @type {Record<import("./types.js").Waypoint["kind"], WaypointKind>} */
const KINDS = {
  centre: { layer: "waypoints", ink: "waypoint", mark: "disc", colour_3d: "#0b5cad", sees_area: false },
  scan: { layer: "scans", ink: "scan", mark: "diamond", colour_3d: "#7c3aed", sees_area: true },
};

/** @param {{kind: import("./types.js").Waypoint["kind"]}} waypoint */
export function kindOf({ kind }) {
  const known = KINDS[kind];
  if (known === undefined) throw new Error(`waypoints of the kind ${kind} are not known to this page`);
  return known;
}

/** All kinds, with their names. */
export const waypointKinds = () => Object.entries(KINDS);
