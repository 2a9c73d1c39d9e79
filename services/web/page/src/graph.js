// Shortest ways on the route graph, and, where there is none, what would have to open.

import { isClosed, passageOf, spaceState } from "./site.js";

// Dijkstra from `starts` (node ids) with `links(node) -> [{to, cost, ...}]`; stops at the first node of `goals`.
// Returns {cost, steps: [link..]} or null.
function shortest(starts, goals, links) {
  const best = new Map(starts.map((node) => [node, { cost: 0, from: null, link: null }]));
  const heap = starts.map((node) => [0, node]);
  const done = new Set();
  while (heap.length > 0) {
    const [cost, node] = pop(heap);
    if (done.has(node)) continue;
    done.add(node);
    if (goals.has(node)) {
      const steps = [];
      for (let at = best.get(node), here = node; at.link !== null; here = at.from, at = best.get(here))
        steps.unshift(at.link);
      return { cost, end: node, start: steps[0]?.from ?? node, steps };
    }
    for (const link of links(node)) {
      const total = cost + link.cost;
      if (total < (best.get(link.to)?.cost ?? Infinity)) {
        best.set(link.to, { cost: total, from: node, link });
        push(heap, [total, link.to]);
      }
    }
  }
  return null;
}

function push(heap, item) {
  let i = heap.push(item) - 1;
  while (i > 0) {
    const parent = (i - 1) >> 1;
    if (heap[parent][0] <= heap[i][0]) break;
    [heap[parent], heap[i]] = [heap[i], heap[parent]];
    i = parent;
  }
}

function pop(heap) {
  const top = heap[0];
  const last = heap.pop();
  if (heap.length === 0) return top;
  heap[0] = last;
  for (let i = 0; ;) {
    let least = i;
    for (const child of [2 * i + 1, 2 * i + 2])
      if (child < heap.length && heap[child][0] < heap[least][0]) least = child;
    if (least === i) return top;
    [heap[i], heap[least]] = [heap[least], heap[i]];
    i = least;
  }
}

/**
 * Nodes at which a room is entered into the graph: its own node, else any that lies in it.
 * @param {import("./types.js").Graph} graph
 * @param {string} room
 */
export function nodesOf(graph, room) {
  const own = graph.nodes.filter((node) => node.kind === "space" && node.of === room);
  return own.length > 0 ? own : graph.nodes.filter((node) => node.space === room);
}

/**
 * The shortest way between two rooms over usable edges:
 * {length_m, nodes, edges: [{edge, storeys}], doors: [gid], rooms: [gid]} or null.
 * @param {import("./types.js").Graph} graph
 * @param {string} from
 * @param {string} to
 * @returns {import("./types.js").Way | null}
 */
export function findWay(graph, from, to) {
  const nodes = new Map(graph.nodes.map((node) => [node.id, node]));
  const links = new Map();
  const add = (at, link) => (links.has(at) ? links.get(at).push(link) : links.set(at, [link]));
  for (const edge of graph.edges) {
    if (!edge.usable) continue;
    add(edge.from, { from: edge.from, to: edge.to, cost: edge.length_m, edge });
    add(edge.to, { from: edge.to, to: edge.from, cost: edge.length_m, edge });
  }
  const starts = nodesOf(graph, from).map((node) => node.id);
  const goals = new Set(nodesOf(graph, to).map((node) => node.id));
  const found = shortest(starts, goals, (node) => links.get(node) ?? []);
  if (found === null) return null;
  const passed = [nodes.get(found.start), ...found.steps.map((link) => nodes.get(link.to))];
  const once = (ids) => ids.filter((id, i) => id && ids.indexOf(id) === i);
  return {
    length_m: found.cost,
    nodes: passed,
    edges: found.steps.map(({ edge }) => ({ edge, storeys: [nodes.get(edge.from).storey, nodes.get(edge.to).storey] })),
    doors: once(found.steps.map(({ edge }) => (edge.class === "door" ? edge.of : null))),
    rooms: once(passed.map((node) => node.space)),
  };
}

const OBSTACLE_COST = 1000; // a way around is better than a closed door, however long

/**
 * What keeps a robot from getting from one room to the other, on the way with the fewest obstacles:
 * [{kind: "door", id, passage} | {kind: "room", id} | {kind: "edge", edge, a, b}], or null if no way is modelled at all.
 * @param {import("./types.js").Site} site
 * @param {import("./types.js").Graph} graph
 * @param {string} from
 * @param {string} to
 * @returns {import("./types.js").Obstacle[] | null}
 */
export function findObstacles(site, graph, from, to) {
  const links = new Map();
  const add = (at, link) => (links.has(at) ? links.get(at).push(link) : links.set(at, [link]));
  const join = (a, b, obstacle) => {
    if (!a || !b || a === b) return;
    for (const [here, there] of [
      [a, b],
      [b, a],
    ]) {
      const blocked = spaceState(there)?.state === "blocked";
      const obstacles = [obstacle, blocked ? { kind: "room", id: there } : null].filter(Boolean);
      add(here, { from: here, to: there, cost: 1 + OBSTACLE_COST * obstacles.length, obstacles });
    }
  };
  for (const [id, door] of Object.entries(site.elements)) {
    if (!door.attributes?.spaces) continue;
    const passage = passageOf(id, door.attributes.storey ?? door.storeys?.[0]);
    const obstacle = isClosed(passage) ? { kind: "door", id, passage } : null;
    const [a, b] = door.attributes.spaces;
    join(a ?? "outside", b ?? "outside", obstacle);
  }
  const rooms = new Map(graph.nodes.map((node) => [node.id, node.space ?? (node.kind === "space" ? node.of : null)]));
  for (const edge of graph.edges) {
    const [a, b] = [rooms.get(edge.from), rooms.get(edge.to)];
    join(a, b, edge.usable ? null : { kind: "edge", edge, a, b });
  }
  const found = shortest([from], new Set([to]), (room) => links.get(room) ?? []);
  if (found === null) return null;
  const first = spaceState(from)?.state === "blocked" ? [{ kind: "room", id: from }] : [];
  return [...first, ...found.steps.flatMap((link) => link.obstacles)];
}
