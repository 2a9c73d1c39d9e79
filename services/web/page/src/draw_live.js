// Draws what is live: the robot's own map, the robot with its uncertainty, deviations.

import { slamUrl } from "./source.js";
import { state } from "./state.js";
import { featuresOf } from "./site.js";
import { outline } from "./draw_site.js";

const pictures = new Map(); // hash -> Image, only the newest two are kept

// The picture of a hash once it is loaded; until then null, and `redraw` is called when it is.
function pictureOf(hash, redraw) {
  if (!pictures.has(hash)) {
    const image = new Image();
    image.addEventListener("load", redraw);
    image.src = slamUrl(hash);
    pictures.set(hash, image);
    if (pictures.size > 2) pictures.delete(pictures.keys().next().value);
  }
  const image = pictures.get(hash);
  return image.complete && image.naturalWidth > 0 ? image : null;
}

/**
 * The picture lies by three corners: rows go down from the upper left.
 * @param {import("./types.js").Pen} pen
 */
export function drawSlam(pen) {
  const { slam } = state;
  if (!slam || !state.slamShown || slam.storey !== state.storey) return;
  const image = pictureOf(slam.hash, pen.redraw);
  if (!image) return;
  const [[lx, ly], [rx, ry], [ux, uy]] = slam.corners_m.map(([x, y]) => [pen.x(x), pen.y(y)]);
  const [width, height] = [image.naturalWidth, image.naturalHeight];
  const { ctx } = pen;
  pen.pixels();
  ctx.save();
  ctx.globalAlpha = 0.6;
  ctx.imageSmoothingEnabled = false;
  ctx.transform((rx - lx) / width, (ry - ly) / width, (lx - ux) / height, (ly - uy) / height, ux, uy);
  ctx.drawImage(image, 0, 0);
  ctx.restore();
}

export function inkOf(verdict) {
  if (verdict === "on_plan" || verdict === "present") return "deviation-ok";
  if (verdict === "late" || verdict === "absent") return "deviation-late";
  if (verdict === "early") return "deviation-early";
  return verdict === "displaced" ? "deviation-displaced" : "deviation-unknown";
}

/** @param {import("./types.js").Pen} pen */
export function drawDeviations(pen) {
  const told = state.deviations?.elements;
  if (!told) return;
  for (const feature of featuresOf(state.storey)) {
    if (feature.kind === "element" && Object.hasOwn(told, feature.id)) {
      outline(pen, [feature], inkOf(told[feature.id].verdict), 3, 1, 0.5);
    }
  }
}

/**
 * The robot as an arrow head of its size; the ellipse is two sigma wide and never smaller than a few pixels.
 * @param {import("./types.js").Pen} pen
 */
export function drawRobot(pen) {
  const { robot } = state;
  if (!robot || robot.storey !== state.storey) return;
  const { ctx } = pen;
  const [x, y] = [pen.x(robot.x_m), pen.y(robot.y_m)];
  const radius = Math.max(9, (state.site.robot?.radius_m ?? 0.3) * pen.scale);
  pen.pixels();
  const sigma = Math.max(2 * (robot.sigma_m ?? 0) * pen.scale, radius + 3);
  ctx.beginPath();
  ctx.ellipse(x, y, sigma, sigma, -robot.yaw_rad, 0, 2 * Math.PI);
  ctx.globalAlpha = 0.2;
  ctx.fillStyle = ctx.strokeStyle = pen.colour("robot");
  ctx.fill();
  ctx.globalAlpha = 0.8;
  ctx.lineWidth = 1.5;
  ctx.stroke();
  // The uncertainty of the heading as a wedge.
  const spread = (2 * (robot.sigma_deg ?? 0) * Math.PI) / 180;
  ctx.globalAlpha = 0.25;
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.arc(x, y, radius * 3, -robot.yaw_rad - spread, -robot.yaw_rad + spread);
  ctx.fill();
  ctx.globalAlpha = 1;
  arrowHead(pen, x, y, robot.yaw_rad, radius);
  pen.pixels();
}

// An arrow head in the colour that is set, edged so that it is seen on every map.
function arrowHead(pen, x, y, yaw, radius) {
  const { ctx } = pen;
  ctx.translate(x, y);
  ctx.rotate(-yaw);
  ctx.beginPath();
  ctx.moveTo(radius, 0);
  ctx.lineTo(-radius * 0.75, radius * 0.7);
  ctx.lineTo(-radius * 0.4, 0);
  ctx.lineTo(-radius * 0.75, -radius * 0.7);
  ctx.closePath();
  ctx.fill();
  ctx.lineWidth = 2;
  ctx.strokeStyle = pen.colour("mark-edge");
  ctx.stroke();
}

/**
 * Robots that tell the server where they are, with their names. Where one that is silent was is drawn faintly.
 * @param {import("./types.js").Pen} pen
 */
export function drawFleet(pen) {
  for (const robot of state.fleet?.robots ?? []) {
    const { place } = robot;
    if (!place || place.storey !== state.storey) continue;
    const { ctx } = pen;
    const [x, y] = [pen.x(place.x_m), pen.y(place.y_m)];
    const radius = Math.max(7, 0.3 * pen.scale);
    pen.pixels();
    ctx.globalAlpha = robot.state === "current" || robot.state === "behind" ? 1 : 0.4;
    ctx.fillStyle = pen.colour("robot");
    ctx.font = "600 12px system-ui, sans-serif";
    ctx.textAlign = "center";
    ctx.textBaseline = "top";
    ctx.lineWidth = 3;
    ctx.strokeStyle = pen.colour("mark-edge");
    ctx.strokeText(robot.name, x, y + radius + 3);
    ctx.fillText(robot.name, x, y + radius + 3);
    arrowHead(pen, x, y, place.yaw_rad, radius);
    ctx.globalAlpha = 1;
    pen.pixels();
  }
}
