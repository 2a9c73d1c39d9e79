// Draws what is measured: both points, a corner as a square and a corner of a cell as a cross, and the length between them.

import { state } from "./state.js";
import { measuredLength } from "./measure.js";
import { number } from "./texts.js";

/** @param {import("./types.js").Pen} pen */
export function drawMeasure(pen) {
  const { measured } = state;
  if (measured.length === 0) return;
  const { ctx } = pen;
  pen.pixels();
  const places = measured.map(({ x, y }) => [pen.x(x), pen.y(y)]);
  for (const [ink, width] of [["selected-edge", 5], ["measure", 2]]) {
    ctx.strokeStyle = pen.colour(String(ink));
    ctx.lineWidth = Number(width);
    ctx.beginPath();
    places.forEach(([x, y], k) => (k === 0 ? ctx.moveTo(x, y) : ctx.lineTo(x, y)));
    for (const [k, [x, y]] of places.entries()) {
      if (measured[k].snap === "corner") ctx.rect(x - 5, y - 5, 10, 10);
      else {
        ctx.moveTo(x - 6, y);
        ctx.lineTo(x + 6, y);
        ctx.moveTo(x, y - 6);
        ctx.lineTo(x, y + 6);
      }
    }
    ctx.stroke();
  }
  const length = measuredLength();
  if (length === null) return;
  const [x, y] = [(places[0][0] + places[1][0]) / 2, (places[0][1] + places[1][1]) / 2 - 12];
  ctx.font = '600 14px "Segoe UI", Roboto, Arial, "Liberation Sans", sans-serif';
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.lineJoin = "round";
  ctx.strokeStyle = pen.colour("label-halo");
  ctx.lineWidth = 4;
  const text = `${number(length, 2)} m`;
  ctx.strokeText(text, x, y);
  ctx.fillStyle = pen.colour("label");
  ctx.fillText(text, x, y);
}
