// The words of handles for screen readers, and the values that a dragged handle sets, as text beside it.

import { numberText, withMinus } from "../base/format.js";
import { capitalized } from "../scene/words.js";
import { presentUnit } from "./parameters/parameter_fields.js";

const SPOKEN = {
  site: (index, label) => `Point ${index}${label}: arrow keys move it on its link`,
  joint: (index) => `Point ${index}: arrow keys move it`,
  velocity: (index) => `Velocity of point ${index}: arrow keys change it`,
  wall: (name, words) => `${capitalized(words || `wall ${name}`)}: arrow keys move it`,
};
const TEXT_DISTANCE = 24; // [pixels] distance of the text from the middle of the handle
const DEGREES = 180 / Math.PI;

/** Return the attributes that make an element a grip for pointers and keys; `label`: words for its name, or "". */
export function gripFor(kind, index, label = "") {
  return { "data-grip": `${kind} ${index}`, tabindex: -1, role: "button", "aria-label": SPOKEN[kind](index, label) };
}

/** Return the values that a handle sets, as text with unit: "−35.2°" for an angle, "1.2, 0.4 m/s" for a velocity. */
export function valueTextOf(changes, values) {
  const names = Object.keys(values);
  const unit = presentUnit(changes, names[0]);
  const numbers = names.map((name) => changes.valueOf(name));
  if (unit === "rad") return `${withMinus((DEGREES * numbers[0]).toFixed(1))}°`;
  return `${numbers.map((value) => withMinus(numberText(value))).join(", ")}\u202f${unit}`;
}

/** Write the text above the dragged handle of a drawing, or below it near the upper edge, within the drawing's `width`. */
export function writeAt(group, text, [x, y], width) {
  const half = 4 * text.length;
  const left = Math.min(Math.max(x, half), width - half);
  const top = y > 2 * TEXT_DISTANCE ? y - TEXT_DISTANCE : y + TEXT_DISTANCE + 10;
  group.plain(text).attr({ x: left, y: top }).addClass("handle-text");
}
