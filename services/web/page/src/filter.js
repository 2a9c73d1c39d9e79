// Which elements are shown: by class, state, task and storey, without what is hidden, or only what is isolated.

import { element, elementState, space } from "./site.js";
import { NO_FILTER, state, update } from "./state.js";
import { elementsOfTask } from "./task_store.js";

/** A filter of one task alone. */
export const isolatedTask = (task) => ({ ...state.filter, task });

/** True if not everything is shown. */
export function isFiltering() {
  const { filter, hidden, only } = state;
  const { classes, states, task, storey } = filter;
  return classes.length + states.length + hidden.length + only.length > 0 || task !== null || storey;
}

/**
 * Whether an element or a room is shown. Filters are for elements; rooms can be hidden and isolated.
 * @param {string} id GlobalId
 */
export function isShown(id) {
  const { hidden, only, filter } = state;
  if (hidden.includes(id)) return false;
  if (space(id)) return only.length === 0 || !only.some((one) => space(one)) || only.includes(id);
  if (only.length > 0 && !only.includes(id)) return false;
  const part = element(id);
  if (part === null) return true;
  if (filter.classes.length > 0 && !filter.classes.includes(part.class)) return false;
  if (filter.states.length > 0 && !filter.states.includes(elementState(id))) return false;
  if (filter.storey && !part.storeys.includes(state.storey)) return false;
  return filter.task === null || elementsOfTask(filter.task).has(id);
}

export function showAll() {
  update({ filter: NO_FILTER, hidden: [], only: [] });
}

/** @param {string} id GlobalId */
export const hide = (id) => update({ hidden: [...state.hidden.filter((other) => other !== id), id], select: null });

/** @param {string} id GlobalId */
export const isolate = (id) => update({ only: [id] });
