// Angles: texts in degrees, which are read and shown beside radians.

import { numberText } from "../base/format.js";

const IN_DEGREES = { rad: "deg", "rad/s": "deg/s" };
const DEGREES_TEXT = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(deg(?:\/s)?)\s*$/;
const DEGREE = Math.PI / 180; // [rad]
const DEGREE_DIGITS = 12; // number of digits of degrees, which round-off leaves right

/** Return a text such as "90 deg" in radians; return other values unchanged. */
export function inRadians(value, unit) {
  const [, number, given] = (typeof value === "string" && DEGREES_TEXT.exec(value)) || [];
  return given && given === IN_DEGREES[unit] ? Number(number) * DEGREE : value;
}

/** Return a value as text: in degrees if it is an angle, and this is shorter and stands for the same number. */
export function valueText(value, unit) {
  const text = numberText(value);
  if (!(unit in IN_DEGREES)) return text;
  const degrees = `${numberText(Number((value / DEGREE).toPrecision(DEGREE_DIGITS)))} ${IN_DEGREES[unit]}`;
  return degrees.length < text.length && inRadians(degrees, unit) === value ? degrees : text;
}
