// The words of handles for screen readers, and the values that a dragged handle sets, as text beside it.

import { numberText, withMinus } from "../base/format.js";
import { positionsAround } from "../drawing/label_positions.js";
import { capitalized } from "../scene/words.js";
import { presentUnit } from "./parameters/parameter_fields.js";

const SPOKEN = {
  site: (index, label) => `Point ${index}${label}: arrow keys move it on its link`,
  joint: (index) => `Point ${index}: arrow keys move it`,
  velocity: (index) => `Velocity of point ${index}: arrow keys change it`,
  wall: (name, words) => `${capitalized(words || `wall ${name}`)}: arrow keys move it`,
};
const [TEXT_DISTANCE, TEXT_SIZE] = [24, 13]; // [pixels] distance of the text from the middle of the handle, and size of its letters
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

/** Write the text near the dragged handle of a drawing: above it or, if other labels or lines are there, in another direction. */
export function writeAt({ above, labelSpace }, text, at) {
  const places = positionsAround(at, [0, -1], TEXT_DISTANCE);
  const { at: [x, y], anchor } = labelSpace.findPosition(text, TEXT_SIZE, places) ?? places[0];
  above.plain(text).attr({ x, y: y + 4, "text-anchor": anchor }).addClass("handle-text");
}
