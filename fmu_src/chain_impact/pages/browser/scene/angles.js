// Angles: texts in degrees, which are read beside radians, and shown.

import { numberText, unitText } from "../base/format.js";

// table: unit of an angle → the word for its unit in degrees, the pattern of a text in degrees, and words for a refusal
const IN_DEGREES = Object.fromEntries(Object.entries(SHARED.degrees).map(([unit, [word, pattern, advice]]) =>
  [unit, { word, text: new RegExp(`^${pattern}$`), advice }]));
const DEGREE = Math.PI / 180; // [rad] one degree
const DEGREE_DIGITS = 5; // number of digits of a shown value in degrees

/** Return a text such as "90 deg" in radians; return other values unchanged. */
export function inRadians(value, unit) {
  const [, number] = (typeof value === "string" && IN_DEGREES[unit]?.text.exec(value)) || [];
  return number ? Number(number) * DEGREE : value;
}

/** Return words for a refusal, such as ', or text in degrees as "90 deg"'; "" if the unit is not a unit of angles. */
export function orDegrees(unit) {
  return IN_DEGREES[unit]?.advice ?? "";
}

/** Return a value as text; an angle is written in degrees, with 5 digits. */
export function valueText(value, unit) {
  if (!(unit in IN_DEGREES)) return numberText(value);
  return `${numberText(Number((value / DEGREE).toPrecision(DEGREE_DIGITS)))} ${IN_DEGREES[unit].word}`;
}

/** Return the factor and the unit with which a value is shown; an angle is shown in degrees. */
export function shownIn({ unit }) {
  return unit in IN_DEGREES ? { factor: 1 / DEGREE, text: unitText(unit).replace("rad", "°") } : { factor: 1, text: unitText(unit) };
}
