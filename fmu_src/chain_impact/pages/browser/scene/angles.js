// Angles: texts in degrees, which are read and shown beside radians.

import { numberText } from "../base/format.js";

// table: unit of an angle → the word for its unit in degrees, the pattern of a text in degrees, and words for a refusal
const IN_DEGREES = Object.fromEntries(Object.entries(SHARED.degrees).map(([unit, [word, pattern, advice]]) =>
  [unit, { word, text: new RegExp(`^${pattern}$`), advice }]));
const DEGREE = Math.PI / 180; // [rad] one degree
const DEGREE_DIGITS = 12; // number of digits of a value in degrees that are right in spite of round-off

/** Return a text such as "90 deg" in radians; return other values unchanged. */
export function inRadians(value, unit) {
  const [, number] = (typeof value === "string" && IN_DEGREES[unit]?.text.exec(value)) || [];
  return number ? Number(number) * DEGREE : value;
}

/** Return words for a refusal, such as ', or text in degrees as "90 deg"'; "" if the unit is not a unit of angles. */
export function orDegrees(unit) {
  return IN_DEGREES[unit]?.advice ?? "";
}

/** Return a value as text; an angle is written in degrees if this is shorter and stands for the same number. */
export function valueText(value, unit) {
  const text = numberText(value);
  if (!(unit in IN_DEGREES)) return text;
  const degrees = `${numberText(Number((value / DEGREE).toPrecision(DEGREE_DIGITS)))} ${IN_DEGREES[unit].word}`;
  return degrees.length < text.length && inRadians(degrees, unit) === value ? degrees : text;
}
