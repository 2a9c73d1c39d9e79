// What only a live site has: the state of the daemons, alerts, the connection, deviations to confirm, and the date.

import { byId, closestTo, h, icon, show } from "./dom.js";
import { onChange, state, update } from "./state.js";
import { nameOf } from "./site.js";
import { followEvents, postConfirm, postDate } from "./source.js";
import { link } from "./link.js";
import { longDate, number, sentence, t, word } from "./texts.js";

// `onDate({key, at, stop})` and `onSite()` load what the event tells of.
export function createLive({ onDate, onSite }) {
  byId("dialog").addEventListener("close", closed);
  onChange(["connected", "full", "status", "site"], showAlerts);
  onChange(["connected", "status", "robot", "fleet", "slam", "deviations", "site"], showServices);
  const toggle = byId("services-toggle");
  const open = (on) => {
    byId("services").hidden = !on;
    toggle.setAttribute("aria-expanded", String(on));
  };
  toggle.addEventListener("click", () => open(byId("services").hidden));
  byId("live").addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    open(false);
    toggle.focus();
  });
  document.addEventListener("pointerdown", (event) => {
    if (closestTo(event, "#live") === null) open(false);
  });
  onChange(["select"], () => open(false));
  if (!state.site.live) return;
  showServices();
  followEvents(
    (name, value) => {
      if (name === "date") onDate(value);
      else if (name === "site") onSite();
      else update({ [name]: value });
    },
    (connected, full) => {
      if (connected && !state.connected) {
        say(t("recovered"));
        onSite(); // events were missed
      }
      update({ connected, full });
    },
  );
}

function showAlerts() {
  const { connected, full, status } = state;
  const alerts = [];
  if (!connected) alerts.push(t(full ? "full" : "lost"));
  if (status?.stale) alerts.push([t("stale"), status.why].filter(Boolean).join(": "));
  for (const service of status?.services ?? []) {
    if (service.state === "down" || service.state === "error") {
      alerts.push(
        [`${service.name}: ${word("service", service.state)}`, service.detail && sentence(service.detail)]
          .filter(Boolean)
          .join(", "),
      );
    }
  }
  const node = byId("alerts");
  // The same alerts are not written again: a screen reader would read them again.
  if (node.dataset.said === alerts.join("\n")) return;
  node.dataset.said = alerts.join("\n");
  show(
    node,
    alerts.map((text) => h("p", {}, icon("alert"), h("span", {}, text))),
  );
}

function showServices() {
  const { status, robot, slam, deviations, fleet, connected, site } = state;
  byId("live").hidden = !site.live;
  if (!site.live) return;
  const services = status?.services ?? [];
  const bad = services.filter((s) => s.state === "down" || s.state === "error");
  const toggle = byId("services-toggle");
  toggle.className = `chip ${!connected || bad.length > 0 ? "chip-bad" : status?.stale ? "chip-warn" : "chip-ok"}`;
  byId("services-state").textContent = bad.length > 0 ? bad.map((s) => s.name).join(", ") : t("live");
  const told = Object.entries(deviations?.elements ?? {});
  show(
    byId("services"),
    h("h2", {}, t("services")),
    h(
      "ul",
      { class: "plain" },
      services.map((s) =>
        h(
          "li",
          { class: "service" },
          h("span", { class: `dot dot-${s.state}` }),
          h("span", { class: "service-name" }, s.name),
          h(
            "span",
            { class: "quiet" },
            [word("service", s.state), s.detail && sentence(s.detail)].filter(Boolean).join(", "),
          ),
        ),
      ),
    ),
    robot
      ? h(
          "p",
          {},
          `${t("robot")}: `,
          t("robotAt", {
            m: number(robot.sigma_m ?? 0, 2),
            deg: number(robot.sigma_deg ?? 0),
            age: number(robot.age_s ?? 0),
          }),
        )
      : null,
    slam
      ? h(
          "label",
          { class: "switch" },
          h("input", {
            type: "checkbox",
            id: "slam-shown",
            checked: state.slamShown,
            onchange: (event) => update({ slamShown: event.target.checked }),
          }),
          h("span", {}, `${t("slam")} (±${number(slam.sigma_m ?? 0, 2)} m, ±${number(slam.sigma_deg ?? 0)}°)`),
        )
      : null,
    ...fleetNodes(fleet),
    told.length === 0 ? null : h("h3", {}, t("deviations"), h("span", { class: "count" }, String(told.length))),
    told.length === 0
      ? null
      : h(
          "ul",
          { class: "links" },
          told
            .slice(0, 100)
            .map(([id, { verdict }]) =>
              h("li", {}, link(id, nameOf(id), word("v", verdict), verdict === "on_plan" ? "passable" : "in_progress")),
            ),
        ),
  );
}

const FLEET_DOTS = { current: "ok", behind: "warning", silent: "error", never_heard: "down" };

// The robots of a site, as its server knows them.
function fleetNodes(fleet) {
  if (!fleet) return [];
  const robots = fleet.robots.map((robot) =>
    h(
      "li",
      { class: "service" },
      h("span", {
        class: `dot dot-${robot.state === "current" && robot.findings.length > 0 ? "warning" : FLEET_DOTS[robot.state]}`,
      }),
      h("span", { class: "service-name" }, robot.name),
      h(
        "span",
        { class: "quiet" },
        [
          t(`fleetState_${robot.state}`),
          robot.epoch ? t("fleetIndex", { n: String(robot.epoch) }) : "",
          robot.plan_time ? longDate(robot.plan_time) : "",
          ...robot.findings,
        ]
          .filter(Boolean)
          .join(", "),
      ),
    ),
  );
  const conflicts = (fleet.conflicts ?? []).map(({ id, told }) => h("li", {}, link(id, nameOf(id), told, "in_progress")));
  return [
    h("h3", {}, t("fleet"), h("span", { class: "count" }, String(robots.length))),
    fleet.error ? h("p", {}, sentence(fleet.error)) : null,
    h("ul", { class: "plain", id: "fleet" }, robots),
    conflicts.length > 0 ? h("h3", {}, t("fleetConflicts")) : null,
    conflicts.length > 0 ? h("ul", { class: "links" }, conflicts) : null,
  ];
}

// What was seen, and how surely: "absent, 9 of 10 samples".
export function deviationText({ verdict, observation, text }) {
  return [observation ? word("o", observation) : word("v", verdict), text && sentence(text)].filter(Boolean).join(", ");
}

// Verdict and text of a deviation, and whether it waits for a confirmation; null if there is none.
export function deviationOf(id) {
  const { deviations } = state;
  if (!deviations?.elements || !Object.hasOwn(deviations.elements, id)) return null;
  return { ...deviations.elements[id], waiting: deviations.waiting?.includes(id) ?? false };
}

// A short message that goes away by itself.
let timer = 0;
// `lasting`: it stays until something else is said.
export function say(text, lasting = false) {
  const toast = byId("toast");
  toast.textContent = text;
  toast.classList.add("shown");
  clearTimeout(timer);
  if (!lasting) timer = setTimeout(() => toast.classList.remove("shown"), 4000);
}

// Asks in the dialog; resolves to true if the person agrees. A question that is open is given up for a new one.
let answer = null;
function ask(title, text, action) {
  const dialog = /** @type {HTMLDialogElement} */ (byId("dialog"));
  if (dialog.open) dialog.close();
  closed();
  byId("dialog-title").textContent = title;
  byId("dialog-text").textContent = text;
  byId("dialog-ok").textContent = action;
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => (answer = resolve));
}

// The event comes later than the end of its question: by then the next one may be open, and waits for its own end.
function closed() {
  const dialog = /** @type {HTMLDialogElement} */ (byId("dialog"));
  if (dialog.open) return;
  answer?.(dialog.returnValue === "ok");
  answer = null;
}

export async function askConfirm(id) {
  const told = deviationOf(id);
  const text = t("confirmText", { name: nameOf(id), text: deviationText(told) });
  if (!(await ask(t("confirmAsk"), text, t("confirm")))) return;
  await tell(() => postConfirm(id), t("confirmed", { name: nameOf(id) }));
}

// The date of the whole site: it moves robots, so it is asked for.
export async function askDate(stop) {
  const { at } = state.site.dates[stop];
  if (!(await ask(t("moveSite"), t("moveSiteText", { date: longDate(at) }), t("setDate")))) return;
  await tell(() => postDate(at), null);
}

async function tell(request, done) {
  try {
    await request();
    if (done) say(done);
  } catch (error) {
    say(t("refused", { text: error.message }));
  }
}
