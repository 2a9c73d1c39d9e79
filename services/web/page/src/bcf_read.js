// Topics of a BCF container, 2.0 and 2.1: title, description, viewpoint and picture. What cannot be read is counted.

import { strFromU8, unzipSync } from "fflate";

const ENTRY_BYTES_MAX = 32e6;
const ALL_BYTES_MAX = 256e6;
const TOPICS_MAX = 500;
const TEXT_MAX = 2000; // characters of a title or description
const COMPONENTS_MAX = 100000;
const GLOBAL_ID = /^[0-9A-Za-z_$]{22}$/;

/** A container that is too large. */
export class TooMany extends Error {}

/**
 * @typedef {object} ReadTopic
 * @property {string} title
 * @property {string} description
 * @property {string | null} link
 * @property {import("./bcf_write.js").Viewpoint | null} viewpoint
 * @property {Uint8Array | null} picture
 */

/**
 * @param {Uint8Array} bytes
 * @returns {{topics: ReadTopic[], skipped: number}}
 */
export function readBcf(bytes) {
  let sum = 0;
  let nTopics = 0;
  const files = unzipSync(bytes, {
    filter: ({ name, originalSize }) => {
      if (!/\.(bcf|bcfv|png|jpe?g)$/i.test(name)) return false;
      sum += originalSize;
      if (name.endsWith(".bcf")) nTopics += 1;
      if (nTopics > TOPICS_MAX || sum > ALL_BYTES_MAX) throw new TooMany(String(TOPICS_MAX));
      return originalSize <= ENTRY_BYTES_MAX;
    },
  });
  const topics = [];
  let skipped = 0;
  for (const name of Object.keys(files).sort()) {
    if (!name.endsWith("markup.bcf")) continue;
    try {
      topics.push(topicOf(files, name.slice(0, -"markup.bcf".length)));
    } catch {
      skipped += 1;
    }
  }
  return { topics, skipped };
}

function parsed(bytes) {
  const text = strFromU8(bytes);
  // No document of BCF has its own entities.
  if (/<!DOCTYPE/i.test(text)) throw new Error("doctype");
  const xml = new DOMParser().parseFromString(text, "application/xml");
  if (xml.querySelector("parsererror")) throw new Error("xml");
  return xml;
}

// By local names: some programs write prefixes.
const children = (node, name) => [...(node?.children ?? [])].filter((child) => child.localName === name);
const child = (node, name) => children(node, name)[0] ?? null;
const textOf = (node, name) => (child(node, name)?.textContent ?? "").trim().slice(0, TEXT_MAX);

/** @returns {ReadTopic} */
function topicOf(files, folder) {
  const root = parsed(files[`${folder}markup.bcf`]).documentElement;
  const topic = child(root, "Topic");
  if (topic === null) throw new Error("topic");
  const views = child(root, "Viewpoints");
  const named = (name, otherwise) => files[`${folder}${textOf(views, name) || otherwise}`] ?? null;
  const view = named("Viewpoint", "viewpoint.bcfv");
  return {
    title: textOf(topic, "Title") || folder.replace(/\/$/, ""),
    description: textOf(topic, "Description"),
    link: textOf(topic, "ReferenceLink") || null,
    viewpoint: view === null ? null : viewpointOf(parsed(view).documentElement),
    picture: named("Snapshot", "snapshot.png"),
  };
}

/** @returns {import("./bcf_write.js").Viewpoint | null} */
function viewpointOf(root) {
  const orthogonal = child(root, "OrthogonalCamera");
  const camera = child(root, "PerspectiveCamera") ?? orthogonal;
  if (camera === null) return null;
  const components = child(root, "Components");
  const ids = (node) =>
    children(node, "Component")
      .slice(0, COMPONENTS_MAX)
      .map((part) => part.getAttribute("IfcGuid") ?? "")
      .filter((id) => GLOBAL_ID.test(id));
  const visibility = child(components, "Visibility");
  const number = (node, name) => finite(Number(textOf(node, name)));
  return {
    selection: ids(child(components, "Selection")),
    visible: visibility?.getAttribute("DefaultVisibility") !== "false",
    exceptions: ids(child(visibility, "Exceptions")),
    eye: vectorOf(child(camera, "CameraViewPoint")),
    direction: vectorOf(child(camera, "CameraDirection")),
    up: vectorOf(child(camera, "CameraUpVector")),
    fieldOfView: camera === orthogonal ? null : number(camera, "FieldOfView"),
    height: camera === orthogonal ? number(camera, "ViewToWorldScale") : null,
    clip: null,
  };
}

function finite(value) {
  if (!Number.isFinite(value)) throw new Error("number");
  return value;
}

/** @returns {[number, number, number]} */
function vectorOf(node) {
  if (node === null) throw new Error("vector");
  const at = (name) => finite(Number.parseFloat(textOf(node, name)));
  return [at("X"), at("Y"), at("Z")];
}
