// Draws the robot's mission: waypoints, scans with what they see, the tour, the route graph, and a way asked for.

import { hasLayer, state } from "./state.js";
import { outline } from "./draw_site.js";
import { featuresOf } from "./site.js";
import { seenBy } from "./scan_view.js";
import { currentWay } from "./way.js";
import { kindOf } from "./waypoint_kinds.js";

function line(pen, points) {
  pen.ctx.beginPath();
  points.forEach(([x, y], i) => (i === 0 ? pen.ctx.moveTo(pen.x(x), pen.y(y)) : pen.ctx.lineTo(pen.x(x), pen.y(y))));
}

/** @param {import("./types.js").Pen} pen */
export function drawGraph(pen) {
  if (!hasLayer("graph") || !state.doc?.graph) return;
  const { ctx } = pen;
  const { nodes, edges } = state.doc.graph;
  const storeys = new Map(nodes.map((node) => [node.id, node.storey]));
  pen.pixels();
  for (const edge of edges) {
    if (storeys.get(edge.from) !== state.storey && storeys.get(edge.to) !== state.storey) continue;
    ctx.strokeStyle = pen.colour(edge.usable ? "graph" : "graph-unusable");
    ctx.lineWidth = edge.class === "door" ? 3 : 1.5;
    ctx.setLineDash(edge.usable ? [] : [5, 4]);
    line(pen, edge.line_m);
    ctx.stroke();
  }
  ctx.setLineDash([]);
  ctx.fillStyle = pen.colour("graph");
  for (const node of nodes) {
    if (node.storey !== state.storey) continue;
    const half = node.kind === "space" ? 4 : 2.5;
    ctx.fillRect(pen.x(node.x_m) - half, pen.y(node.y_m) - half, 2 * half, 2 * half);
  }
}

/**
 * The tour in its order; a leg that leaves the storey ends at its last stop there.
 * @param {import("./types.js").Pen} pen
 */
export function drawTour(pen) {
  if (!hasLayer("tour")) return;
  const { ctx } = pen;
  const stops = [...(state.doc?.waypoints ?? [])].sort((a, b) => a.order - b.order);
  pen.pixels();
  ctx.strokeStyle = pen.colour("tour");
  ctx.fillStyle = pen.colour("tour");
  ctx.lineWidth = 2;
  for (let k = 1; k < stops.length; k++) {
    const [a, b] = [stops[k - 1], stops[k]];
    if (a.storey !== state.storey || b.storey !== state.storey) continue;
    line(pen, [
      [a.x_m, a.y_m],
      [b.x_m, b.y_m],
    ]);
    ctx.stroke();
    arrow(pen, a, b);
  }
}

// A head in the middle of a leg, where it is long enough to hold one.
function arrow(pen, a, b) {
  const [dx, dy] = [pen.x(b.x_m) - pen.x(a.x_m), pen.y(b.y_m) - pen.y(a.y_m)];
  const length = Math.hypot(dx, dy);
  if (length < 34) return;
  const [ux, uy] = [dx / length, dy / length];
  const [mx, my] = [pen.x(a.x_m) + dx / 2, pen.y(a.y_m) + dy / 2];
  const { ctx } = pen;
  ctx.beginPath();
  ctx.moveTo(mx + ux * 6, my + uy * 6);
  ctx.lineTo(mx - ux * 5 - uy * 4.5, my - uy * 5 + ux * 4.5);
  ctx.lineTo(mx - ux * 5 + uy * 4.5, my - uy * 5 - ux * 4.5);
  ctx.fill();
}

/** @param {import("./types.js").Pen} pen */
export function drawScan(pen) {
  const chosen = state.doc?.waypoints.find((w) => w.id === state.waypoint);
  if (!chosen || !kindOf(chosen).sees_area || chosen.storey !== state.storey) return;
  const { ctx } = pen;
  pen.pixels();
  line(pen, seenBy(chosen));
  ctx.closePath();
  ctx.globalAlpha = 0.22;
  ctx.fillStyle = ctx.strokeStyle = pen.colour(kindOf(chosen).ink);
  ctx.fill();
  ctx.globalAlpha = 0.9;
  ctx.lineWidth = 1.5;
  ctx.stroke();
  ctx.globalAlpha = 1;
}

/** @param {import("./types.js").Pen} pen */
export function drawWaypoints(pen) {
  for (const waypoint of state.doc?.waypoints ?? []) {
    if (waypoint.storey !== state.storey || !hasLayer(kindOf(waypoint).layer)) continue;
    drawWaypoint(pen, waypoint, waypoint.id === state.waypoint);
  }
}

// A disc for a room's centre, a diamond for a scan, with the number in the tour when there is room; a tick shows the yaw.
function drawWaypoint(pen, waypoint, chosen) {
  const { ctx } = pen;
  const { ink, mark } = kindOf(waypoint);
  const [x, y] = [pen.x(waypoint.x_m), pen.y(waypoint.y_m)];
  const large = pen.scale > 14;
  const radius = (large ? 9 : 5) + (chosen ? 2 : 0);
  pen.pixels();
  ctx.strokeStyle = pen.colour(ink);
  ctx.lineWidth = 2.5;
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(x + Math.cos(waypoint.yaw_rad) * (radius + 7), y - Math.sin(waypoint.yaw_rad) * (radius + 7));
  ctx.stroke();
  ctx.beginPath();
  if (mark === "diamond") {
    const r = radius * 1.25;
    ctx.moveTo(x, y - r);
    ctx.lineTo(x + r, y);
    ctx.lineTo(x, y + r);
    ctx.lineTo(x - r, y);
    ctx.closePath();
  } else {
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
  }
  ctx.fillStyle = pen.colour(ink);
  ctx.fill();
  ctx.lineWidth = chosen ? 3 : 1.5;
  ctx.strokeStyle = pen.colour(chosen ? "selected-edge" : "mark-edge");
  ctx.stroke();
  if (!large) return;
  ctx.fillStyle = pen.colour("mark-text");
  ctx.font = '600 10px "Segoe UI", Roboto, Arial, "Liberation Sans", sans-serif';
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillText(String(waypoint.order + 1), x, y + 0.5);
}

/** @param {import("./types.js").Pen} pen */
export function drawWay(pen) {
  const way = currentWay();
  if (way === null) return;
  if (!way.edges) {
    outline(
      pen,
      featuresOf(state.storey).filter((feature) => way.closed.includes(feature.id)),
      "door-closed",
      5,
      1,
    );
    return;
  }
  const { ctx } = pen;
  pen.pixels();
  ctx.lineJoin = ctx.lineCap = "round";
  for (const [ink, width] of /** @type {const} */ ([
    ["mark-edge", 7],
    ["way", 4],
  ])) {
    ctx.strokeStyle = pen.colour(ink);
    ctx.lineWidth = width;
    for (const { edge, storeys } of way.edges) {
      if (!storeys.includes(state.storey)) continue;
      line(pen, edge.line_m);
      ctx.stroke();
    }
  }
  ctx.lineJoin = "miter";
  ctx.lineCap = "butt";
  for (const node of [way.nodes[0], way.nodes.at(-1)]) {
    if (node.storey !== state.storey) continue;
    ctx.beginPath();
    ctx.arc(pen.x(node.x_m), pen.y(node.y_m), 6, 0, 2 * Math.PI);
    ctx.fillStyle = pen.colour("mark-edge");
    ctx.fill();
    ctx.lineWidth = 3;
    ctx.strokeStyle = pen.colour("way");
    ctx.stroke();
  }
}
