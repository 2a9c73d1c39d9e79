// A topic as BCF 2.1: a container with markup, viewpoint and picture. Coordinates are those of the IFC world, in metres.
//
// Source: buildingSMART, BIM Collaboration Format 2.1: version.xsd, markup.xsd, visinfo.xsd.

import { strToU8, zipSync } from "fflate";

/**
 * @typedef {object} Viewpoint in the IFC world
 * @property {string[]} selection GlobalIds
 * @property {boolean} visible whether what is no exception is shown
 * @property {string[]} exceptions GlobalIds
 * @property {[number, number, number]} eye
 * @property {[number, number, number]} direction
 * @property {[number, number, number]} up
 * @property {number | null} fieldOfView degrees, of a camera with perspective
 * @property {number | null} height metres that are seen from below to above, of one without
 * @property {{at: [number, number, number], direction: [number, number, number]} | null} clip what is cut away, and where
 */

/**
 * @typedef {object} Topic
 * @property {string} title
 * @property {string} description
 * @property {string | null} link
 * @property {string[]} files names of the models
 * @property {Viewpoint | null} viewpoint
 * @property {Uint8Array | null} picture a PNG
 */

const escaped = (text) =>
  String(text)
    // Letters that XML forbids.
    // eslint-disable-next-line no-control-regex
    .replace(/[\u0000-\u0008\u000b\u000c\u000e-\u001f\ufffe\uffff]/g, "")
    .replace(/[&<>"]/g, (letter) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[letter]);

const tag = (name, attributes, ...inner) => {
  const list = Object.entries(attributes).map(([key, value]) => ` ${key}="${escaped(value)}"`);
  return `<${name}${list.join("")}>${inner.join("")}</${name}>`;
};
const leaf = (name, text) => (text === null || text === "" ? "" : tag(name, {}, escaped(text)));
const file = (root) => strToU8(`<?xml version="1.0" encoding="UTF-8"?>\n${root}\n`);
const rounded = (value) => String(Math.round(1e6 * value) / 1e6);
const vector = (name, [x, y, z]) => tag(name, {}, leaf("X", rounded(x)), leaf("Y", rounded(y)), leaf("Z", rounded(z)));

// Of random numbers: `crypto.randomUUID` is not there for pages that come without encryption.
function uuid() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  bytes[6] = (bytes[6] & 0x0f) | 0x40;
  bytes[8] = (bytes[8] & 0x3f) | 0x80;
  const hex = [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  return [hex.slice(0, 8), hex.slice(8, 12), hex.slice(12, 16), hex.slice(16, 20), hex.slice(20)].join("-");
}

/**
 * The container of a topic.
 * @param {Topic} topic
 * @param {Date} created
 * @returns {Uint8Array}
 */
export function writeBcf(topic, created) {
  const [guid, view] = [uuid(), uuid()];
  /** @type {Record<string, Uint8Array>} */
  const files = { "bcf.version": file(tag("Version", { VersionId: "2.1" }, leaf("DetailedVersion", "2.1"))) };
  files[`${guid}/markup.bcf`] = file(markup(topic, guid, view, created));
  if (topic.viewpoint !== null) files[`${guid}/viewpoint.bcfv`] = file(visualization(topic.viewpoint, view));
  if (topic.picture !== null) files[`${guid}/snapshot.png`] = topic.picture;
  return zipSync(files);
}

function markup({ title, description, link, files, viewpoint, picture }, guid, view, created) {
  const sources = files.map((name) => tag("File", { isExternal: "true" }, leaf("Filename", name)));
  const head = tag(
    "Topic",
    { Guid: guid, TopicType: "Issue", TopicStatus: "Open" },
    leaf("ReferenceLink", link),
    leaf("Title", title),
    leaf("CreationDate", created.toISOString()),
    leaf("CreationAuthor", "groundplan"),
    leaf("Description", description),
  );
  const snapshot = picture === null ? "" : leaf("Snapshot", "snapshot.png");
  const views = viewpoint === null ? "" : tag("Viewpoints", { Guid: view }, leaf("Viewpoint", "viewpoint.bcfv"), snapshot);
  return tag("Markup", {}, sources.length > 0 ? tag("Header", {}, ...sources) : "", head, views);
}

const plane = ({ at, direction }) => tag("ClippingPlane", {}, vector("Location", at), vector("Direction", direction));

function visualization(viewpoint, guid) {
  const { selection, visible, exceptions, eye, direction, up, fieldOfView, height, clip } = viewpoint;
  const components = (name, ids) => (ids.length === 0 ? "" : tag(name, {}, ...ids.map((id) => tag("Component", { IfcGuid: id }))));
  const camera = [vector("CameraViewPoint", eye), vector("CameraDirection", direction), vector("CameraUpVector", up)];
  return tag(
    "VisualizationInfo",
    { Guid: guid },
    tag(
      "Components",
      {},
      components("Selection", selection),
      tag("Visibility", { DefaultVisibility: String(visible) }, components("Exceptions", exceptions)),
    ),
    fieldOfView === null
      ? tag("OrthogonalCamera", {}, ...camera, leaf("ViewToWorldScale", rounded(height)))
      : tag("PerspectiveCamera", {}, ...camera, leaf("FieldOfView", rounded(fieldOfView))),
    clip === null ? "" : tag("ClippingPlanes", {}, plane(clip)),
  );
}
