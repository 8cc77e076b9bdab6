// Angles: texts in degrees, which the page accepts beside numbers in radians, and in which it shows angles.
// `scene/words/angles.py` reads the same texts.

import { numberText, unitText } from "../base/format.js";

// rad, rad/s or rad/s2 → the word for this unit in degrees, the pattern of a text in degrees, and words for an error
const IN_DEGREES = Object.fromEntries(Object.entries(SHARED.degrees).map(([unit, [word, pattern, advice]]) =>
  [unit, { word, text: new RegExp(`^${pattern}$`), advice }]));
const DEGREE = Math.PI / 180; // [rad] one degree
/** The largest number of significant digits with which an angle is shown in degrees. */
export const DEGREE_DIGITS = 5;
/** The number of significant digits that determine each double. */
export const ALL_DIGITS = 17;
const ROOM = 9; // number of characters for which the field of a parameter has room

/** Return the number in a `unit` (rad, rad/s, rad/s2) for a text such as "90 deg"; return any other value unchanged. */
export function inRadians(value, unit) {
  const [, number] = (typeof value === "string" && IN_DEGREES[unit]?.text.exec(value)) || [];
  return number ? Number(number) * DEGREE : value;
}

/** Return the end of an error, such as ', or text in degrees as "90 deg"'; "" if IN_DEGREES lacks the unit. */
export function orDegrees(unit) {
  return IN_DEGREES[unit]?.advice ?? "";
}

/** Return a value as text with at most `digits` significant digits; an angle is written in degrees, with at most DEGREE_DIGITS. */
export function valueText(value, unit, digits = ALL_DIGITS) {
  if (!(unit in IN_DEGREES)) return numberText(Number(value.toPrecision(digits)));
  return `${numberText(Number((value / DEGREE).toPrecision(Math.min(digits, DEGREE_DIGITS))))} ${IN_DEGREES[unit].word}`;
}

/** Return a value as text with all its digits if a field has room for them, else with the most digits from 6 to 3 that fit, at least 3. */
export function shortText(value, unit) {
  const texts = [ALL_DIGITS, 6, 5, 4, 3].map((digits) => valueText(value, unit, digits));
  return texts.find(({ length }) => length <= ROOM) ?? texts.at(-1);
}

/** Return the `factor` and the unit (`text`) with which a value is shown; an angle is shown in degrees. */
export function shownIn({ unit }) {
  return unit in IN_DEGREES ? { factor: 1 / DEGREE, text: unitText(unit).replace("rad", "°") } : { factor: 1, text: unitText(unit) };
}

/**
 * Return the `factor` and the unit (`text`) with which values are shown that have the largest absolute value `most`: large forces and
 * moments in kN and kN·m, small lengths in mm, all others as by `shownIn`.
 */
export function shownUpTo({ unit }, most) {
  if ((unit === "N" || unit === "N.m") && most >= 1e3) return { factor: 1e-3, text: `k${unitText(unit)}` };
  if (unit === "m" && most < 0.1) return { factor: 1e3, text: "mm" };
  return shownIn({ unit });
}
