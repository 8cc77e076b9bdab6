// The scales of a map: ranges and ticks of the axes, titles and units of parameters and outputs.

import { ticksBetween } from "../../base/ticks.js";
import { inShownUnit, shownUpTo, typed } from "../../scene/angles.js";
import { MAIN_PARAMETERS } from "../parameters/main_parameters.js";

const SHARE_REACH = 0.3; // reach of the first axis of a parameter from 0 to 1, such as a restitution, on each side of its present value

/** Return whether the axis of a parameter is logarithmic, as the parameter's entry in MAIN_PARAMETERS says. */
export function isLogarithmic(name) {
  return MAIN_PARAMETERS.some((entry) => entry.name === name && entry.logarithmic);
}

/**
 * Return the first and the last value of a map's axis, within the allowed values. For a logarithmic axis they are a tenth of the present
 * value and ten times it; for a parameter whose allowed values lie from 0 to 1, SHARE_REACH below and above the present value, and within
 * 0.05 and 0.95, if the present value is; for any other parameter, the present value minus and plus half of its absolute value, or −1 and 1
 * for a value of 0.
 */
export function rangeOf({ name, low, high }, value) {
  if (isLogarithmic(name)) return [Math.max(value / 10, low), Math.min(10 * value, high)];
  if (high <= 1 && low >= 0) {
    const ends = [Math.max(value - SHARE_REACH, 0.05), Math.min(value + SHARE_REACH, 0.95)];
    return [Math.max(Math.min(ends[0], value), low), Math.min(Math.max(ends[1], value), high)];
  }
  const reach = value === 0 ? 1 : Math.abs(value) / 2;
  return [Math.max(value - reach, low), Math.min(value + reach, high)];
}

/**
 * Return the end of an axis that the text of a field stands for (`typed`). A field with a refused value is marked, and an error tells why,
 * with `words` in place of the parameter's name.
 */
export function limitOf(changes, name, field, words) {
  try {
    return changes.numberOf(name, typed(field.value, changes.parameters.get(name).unit));
  } catch ({ message }) {
    throw refused(field, inShownUnit(message.replace(name, words)));
  }
}

/** Mark a field as refused, and return an error with the reason. */
export function refused(field, reason) {
  field.setCustomValidity(reason);
  return new RangeError(reason);
}

/** Return a text by which maps, or requests of maps, are compared: two texts are equal if both parameters and the ends of the axes are. */
export function areaOf({ names, axes }) {
  return JSON.stringify([names, axes.map((axis) => [axis[0], axis.at(-1)])]);
}

/** Return a name with its unit, if there is one, as the title of an axis. */
export function titleOf(name, unit) {
  return unit ? `${name}, ${unit}` : name;
}

/** The quantities that a map can show, except the coordinates of the tip: name in a scene or a sweep → title. */
const QUANTITIES = {
  "impact.count": "Number of impacts",
  "impact.last_time": "Time of the last impact",
  "impact[1].onset": "First impact: time",
  "impact[1].peak_force": "First impact: largest force",
  "impact[1].place": "First impact: point and wall",
  peak_force: "Largest force at a wall",
  max_penetration: "Largest penetration",
  "stop.peak_moment": "Largest moment at a stop",
  "stop.max_penetration": "Largest angle beyond a stop",
  joint_force: "Largest force in a joint",
  "energy.total": "Energy at the end",
  "energy.dissipated": "Dissipated energy",
};

/** Return the title for the name of an output; a name without an entry in QUANTITIES is that of a coordinate of the tip. */
export function quantityOf(name) {
  return QUANTITIES[name] ?? `Tip at the end, ${name.at(-1)}`;
}

/**
 * Return two functions for an axis from `first` to `last`: `shareOf`, from a value to the fraction of the axis, and `valueAt`, from a
 * fraction to the value. On a logarithmic axis, equal distances stand for equal factors.
 */
export function axisScale(first, last, hasDecades) {
  const [to, from] = hasDecades ? [Math.log, Math.exp] : [Number, Number];
  const [low, width] = [to(first), to(last) - to(first)];
  return { shareOf: (value) => (to(value) - low) / (width || 1), valueAt: (share) => from(low + share * width) };
}

/**
 * Return the ticks of a logarithmic axis from `low` to `high`: powers of ten; with fewer than 3 of these, also 2 and 5 times powers of ten;
 * with fewer than 2 of all these, numbers at equal distances.
 */
export function decadesBetween(low, high) {
  const first = Math.floor(Math.log10(low));
  const powers = Array.from({ length: Math.ceil(Math.log10(high)) - first + 1 }, (_, k) => first + k);
  const within = (factors) => powers.flatMap((power) => factors.map((factor) => Number(`${factor}e${power}`)))
    .filter((tick) => tick >= low * (1 - 1e-9) && tick <= high * (1 + 1e-9));
  const whole = within([1]);
  const finer = whole.length > 2 ? whole : within([1, 2, 5]);
  return finer.length > 1 ? finer : ticksBetween(low, high);
}

/** Return the `factor` and the unit (`text`) with which a map shows its output, by the values at the ends of the `scale` of colours. */
export function scaledTo(output, scale) {
  return shownUpTo(output, Math.max(...(scale?.ends ?? [0]).map(Math.abs)));
}
