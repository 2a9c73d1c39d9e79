// The frame around the plan: tabs, sheets on phones, theme, link and the north arrow.

import { byId, closestTo } from "./dom.js";
import { LINKED_MAX, onChange, state, TABS, update } from "./state.js";
import { say } from "./live.js";
import { t } from "./texts.js";

export function createShell() {
  createTabs();
  createSheets();
  createTheme();
  byId("copy-link").addEventListener("click", copyLink);
  showTitle();
  onChange(["site"], showTitle);
}

function showTitle() {
  const { title, schedule_ignored: ignored } = state.site;
  byId("title").textContent = byId("title").title = title;
  document.title = `${title} – groundplan`;
  byId("ignored").hidden = !ignored;
  const angle = northAngle(state.site.frames);
  for (const arrow of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(".north"))) {
    arrow.hidden = arrow.parentElement.hidden = false;
    arrow.toggleAttribute("hidden", angle === null);
    if (angle !== null)
      arrow.querySelector("g").setAttribute("transform", `rotate(${((-angle * 180) / Math.PI).toFixed(2)} 20 20)`);
  }
}

// Angle of grid north on the plan, anticlockwise from up; null for a model without georeference.
function northAngle(frames) {
  const earth = frames?.earth_from_world;
  if (!earth) return null;
  return (frames.map_from_world?.yaw_rad ?? 0) - (earth.yaw_rad ?? 0);
}

function createTabs() {
  const list = byId("tabs");
  list.addEventListener("click", (event) => {
    const tab = closestTo(event, "[role=tab]");
    if (tab) update({ tab: tab.dataset.tab });
  });
  list.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    const tab = TABS[(TABS.indexOf(state.tab) + by + TABS.length) % TABS.length];
    update({ tab });
    byId(`tab-${tab}`).focus();
  });
  const showTab = () => {
    for (const tab of TABS) {
      const chosen = tab === state.tab;
      byId(`tab-${tab}`).setAttribute("aria-selected", String(chosen));
      byId(`tab-${tab}`).tabIndex = chosen ? 0 : -1;
      byId(`panel-${tab}`).hidden = !chosen;
    }
  };
  onChange(["tab"], showTab);
  showTab();
}

/** @type {() => NodeListOf<HTMLButtonElement>} */
const sheetButtons = () => document.querySelectorAll("#sheet-bar button");

// On phones one panel at a time lies over the lower part of the plan: the maps, one of the tabs, or the calendar.
function createSheets() {
  for (const button of sheetButtons()) {
    button.addEventListener("click", () => {
      const { sheet } = button.dataset;
      if (sheet === "rooms") update({ calendarOpen: !state.calendarOpen, sheet: null });
      else
        update({
          sheet: state.sheet === sheet ? null : sheet,
          calendarOpen: false,
          ...(TABS.includes(sheet) ? { tab: sheet } : {}),
        });
    });
  }
  for (const button of document.querySelectorAll(".sheet-close"))
    button.addEventListener("click", () => update({ sheet: null }));
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && state.sheet !== null) update({ sheet: null });
  });
  const showSheet = () => {
    byId("sheet-title").textContent = t(state.tab);
    document.body.dataset.sheet = state.sheet === null ? "" : state.sheet === "maps" ? "maps" : "tabs";
    for (const button of sheetButtons()) {
      const { sheet } = button.dataset;
      button.setAttribute("aria-pressed", String(sheet === "rooms" ? state.calendarOpen : sheet === state.sheet));
    }
  };
  onChange(["sheet", "calendarOpen", "tab"], showSheet);
  showSheet();
}

// The system's theme until the switch is used; the choice stays in this browser where it may be stored.
function createTheme() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const stored = () => {
    try {
      return localStorage.getItem("groundplan-theme");
    } catch {
      return null; // storage is forbidden: the system's theme
    }
  };
  const apply = (theme) => {
    document.documentElement.dataset.theme = theme;
    byId("theme").setAttribute("aria-pressed", String(theme === "dark"));
    document.dispatchEvent(new Event("themechange"));
  };
  const current = () => stored() ?? (dark.matches ? "dark" : "light");
  byId("theme").addEventListener("click", () => {
    const theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    try {
      localStorage.setItem("groundplan-theme", theme);
    } catch {
      // Not stored: it holds until the page is loaded again.
    }
    apply(theme);
  });
  dark.addEventListener("change", () => apply(current()));
  apply(current());
}

async function copyLink() {
  try {
    await navigator.clipboard.writeText(location.href);
    const isShort = Math.max(state.hidden.length, state.only.length) > LINKED_MAX;
    say(t(isShort ? "linkShort" : "linkCopied", { n: LINKED_MAX }));
  } catch {
    say(location.href); // no clipboard here: the link to copy by hand
  }
}
