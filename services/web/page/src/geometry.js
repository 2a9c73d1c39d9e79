// Plane geometry of footprints and rooms, in metres of the map frame.
// A MultiPolygon is a list of polygons, a polygon a list of rings (the first outside, holes after it).

/**
 * @param {import("./types.js").MultiPolygon} multiPolygon
 * @returns {import("./types.js").Box}
 */
export function boundsOf(multiPolygon) {
  const box = { x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity };
  for (const [x, y] of multiPolygon.flat(2)) {
    box.x0 = Math.min(box.x0, x);
    box.y0 = Math.min(box.y0, y);
    box.x1 = Math.max(box.x1, x);
    box.y1 = Math.max(box.y1, y);
  }
  return box;
}

/** @param {import("./types.js").MultiPolygon} multiPolygon */
export function areaOf(multiPolygon) {
  const ring = (points) => {
    let sum = 0;
    for (let i = 0, j = points.length - 1; i < points.length; j = i++) {
      sum += points[j][0] * points[i][1] - points[i][0] * points[j][1];
    }
    return Math.abs(sum) / 2;
  };
  return multiPolygon.reduce(
    (sum, [outside, ...holes]) => sum + ring(outside) - holes.reduce((s, r) => s + ring(r), 0),
    0,
  );
}

/**
 * True if the point is inside, by the even-odd rule over all rings.
 * @param {import("./types.js").MultiPolygon} multiPolygon
 * @param {number} x
 * @param {number} y
 */
export function contains(multiPolygon, x, y) {
  let inside = false;
  for (const ring of multiPolygon.flat(1)) {
    for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
      const [xi, yi] = ring[i];
      const [xj, yj] = ring[j];
      if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) inside = !inside;
    }
  }
  return inside;
}

/**
 * Segments [ax, ay, bx, by] of all rings, closed whether or not the file repeats the first point.
 * @param {import("./types.js").MultiPolygon} multiPolygon
 * @returns {[number, number, number, number][]}
 */
export function segmentsOf(multiPolygon) {
  const segments = [];
  for (const ring of multiPolygon.flat(1)) {
    for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
      const [ax, ay] = ring[j];
      const [bx, by] = ring[i];
      if (ax !== bx || ay !== by) segments.push([ax, ay, bx, by]);
    }
  }
  return segments;
}

/**
 * What a scanner at (x, y) sees: the polygon of the ends of `n` rays, each cut off by the first segment or at `range`.
 * @param {number} x
 * @param {number} y
 * @param {number} range
 * @param {[number, number, number, number][]} segments
 * @param {number} n
 * @returns {import("./types.js").Point[]}
 */
export function visiblePolygon(x, y, range, segments, n = 720) {
  const near = segments.filter(
    ([ax, ay, bx, by]) =>
      Math.min(ax, bx) <= x + range &&
      Math.max(ax, bx) >= x - range &&
      Math.min(ay, by) <= y + range &&
      Math.max(ay, by) >= y - range,
  );
  const ends = [];
  for (let k = 0; k < n; k++) {
    const dx = Math.cos((2 * Math.PI * k) / n);
    const dy = Math.sin((2 * Math.PI * k) / n);
    let least = range;
    for (const [ax, ay, bx, by] of near) {
      const ex = bx - ax;
      const ey = by - ay;
      const turn = dx * ey - dy * ex;
      if (Math.abs(turn) < 1e-12) continue;
      const along = ((ax - x) * ey - (ay - y) * ex) / turn;
      const across = ((ax - x) * dy - (ay - y) * dx) / turn;
      if (along >= 0 && along < least && across >= 0 && across <= 1) least = along;
    }
    ends.push([x + dx * least, y + dy * least]);
  }
  return ends;
}

const LABEL_GRID = 20; // points per side that are tried for a label

/**
 * Where a name is best written: the point inside that is farthest from the outline, with `half` the free width to
 * either side. Wide rooms want their name in the middle, so that height counts more than width.
 * @param {import("./types.js").MultiPolygon} multiPolygon
 * @param {import("./types.js").Box} box
 * @returns {import("./types.js").LabelPlace}
 */
export function labelPoint(multiPolygon, box) {
  const segments = segmentsOf(multiPolygon);
  let best = null;
  for (let i = 1; i < LABEL_GRID; i++) {
    for (let k = 1; k < LABEL_GRID; k++) {
      const x = box.x0 + ((box.x1 - box.x0) * i) / LABEL_GRID;
      const y = box.y0 + ((box.y1 - box.y0) * k) / LABEL_GRID;
      if (!contains(multiPolygon, x, y)) continue;
      const half = { x: clearance(segments, x, y), y: clearance(segments, y, x, true) };
      const score = Math.min(half.x, 2.5 * half.y);
      // The middle of a room wins over points that are as good.
      const off = 0.05 * (Math.abs(i / LABEL_GRID - 0.5) + Math.abs(k / LABEL_GRID - 0.5));
      if (best === null || score * (1 - off) > best.score)
        best = { x, y, half: half.x, height: 2 * half.y, score: score * (1 - off) };
    }
  }
  return (
    best ?? { x: (box.x0 + box.x1) / 2, y: (box.y0 + box.y1) / 2, half: (box.x1 - box.x0) / 2, height: box.y1 - box.y0 }
  );
}

// Distance along one axis to the nearest segment, to whichever side.
function clearance(segments, along, across, swapped = false) {
  let least = Infinity;
  for (const segment of segments) {
    const [au, av, bu, bv] = swapped ? [segment[1], segment[0], segment[3], segment[2]] : segment;
    if (av > across === bv > across) continue;
    const u = au + ((bu - au) * (across - av)) / (bv - av);
    least = Math.min(least, Math.abs(u - along));
  }
  return least;
}
