// The limit of a map's output, which the reader gives: its value, and how many runs keep it.

import { byId } from "../../base/dom.js";
import { typed } from "../../scene/angles.js";
import { capitalized } from "../../scene/words.js";
import { scaledTo } from "./map_scales.js";

/**
 * Return the limit [unit of the output] in the `field`, a number in the shown unit or with its own unit; undefined without one. A text that
 * is no number is refused. A map of classes has no limit.
 */
export function limitIn(field, { output, scale }) {
  const text = field.value.trim();
  const { factor, text: unit } = scaledTo(output, scale);
  field.setCustomValidity("");
  byId("map-limit-unit").textContent = unit && `in ${unit}`;
  field.disabled = Boolean(output.places);
  if (!text || output.places) return undefined;
  const limit = Number.isFinite(Number(text)) ? Number(text) / factor : typed(text, output.unit === "1" ? "" : output.unit);
  if (Number.isFinite(limit)) return limit;
  field.setCustomValidity(`a limit must be a number${unit && `, in ${unit} or with its unit`}`);
  return undefined;
}

/** Return a sentence on the share of the runs whose output is at most the limit, or on a refused limit; "" without a limit. */
export function withinText(field, map) {
  const limit = limitIn(field, map);
  if (!field.checkValidity()) return ` ${capitalized(field.validationMessage)}.`;
  const known = map.results.filter(Number.isFinite);
  if (limit === undefined || !known.length) return "";
  const share = known.filter((value) => value <= limit).length / known.length;
  if (share === 0 || share === 1) return ` ${share ? "All" : "None"} of them are within the limit, so there is no line.`;
  return ` ${Math.round(100 * share)}\u202f% of them are within the limit, the white line.`;
}
