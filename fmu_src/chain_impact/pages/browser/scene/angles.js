// Angles, which the page shows in degrees, and what a reader types for a quantity.
// The twin in Python is `scene/texts/angles.py`.

import { numberText, raised, unitText, withPoint } from "../base/format.js";

// rad, rad/s or rad/s2 → the word for this unit in degrees, the pattern of a text in degrees, and words for an error
const IN_DEGREES = Object.fromEntries(Object.entries(SHARED.degrees).map(([unit, [word, pattern, advice]]) =>
  [unit, { word, text: new RegExp(`^${pattern}$`), advice }]));
const DEGREE = Math.PI / 180; // [rad] one degree
/** The largest number of significant digits with which an angle is shown in degrees. */
export const DEGREE_DIGITS = 5;
/** The number of significant digits that determine each double. */
export const ALL_DIGITS = 17;
const [SUM, TOKEN] = [/^([-+*/\s]|pi|π|(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)*/i, /[-+*/]|pi|π|[\d.]+(?:e[-+]?\d+)?/gi];
const PI = /^(pi|π)$/i;
const SI_PREFIXES = { n: 1e-9, µ: 1e-6, u: 1e-6, m: 1e-3, c: 1e-2, d: 0.1, "": 1, k: 1e3, M: 1e6, G: 1e9 };
const STANDARD_GRAVITY = 9.80665; // [m/s²]
const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";
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

/** Return the value of sums and products of numbers, a list of numbers and signs such as 2 * 0.6 − pi / 3; NaN for any other list. */
function calculated(tokens) {
  const factor = () => {
    const token = tokens.shift();
    return token === "-" ? -factor() : token === "+" ? factor() : PI.test(token) ? Math.PI : Number(token ?? NaN);
  };
  const product = () => {
    let value = factor();
    while (tokens[0] === "*" || tokens[0] === "/") value = tokens.shift() === "*" ? value * factor() : value / factor();
    return value;
  };
  let value = product();
  while (tokens[0] === "-" || tokens[0] === "+") value = tokens.shift() === "+" ? value + product() : value - product();
  return tokens.length ? NaN : value;
}

/** Return the factor from a typed unit `word` to a `unit`: no word stands for the unit that is shown; NaN for an unknown word. */
function factorOf(word, unit) {
  const digitOf = (one) => SUPERSCRIPTS.indexOf(one);
  const [plain, whole] = [word, unit].map((text) => raised(text).replaceAll("·", ".").replace(/[⁰¹²³⁴-⁹]/g, digitOf));
  if (unit in IN_DEGREES) return plain === unit ? 1 : ["", IN_DEGREES[unit].word, unit.replace("rad", "°")].includes(plain) ? DEGREE : NaN;
  if (plain === "") return 1;
  if (plain === "%" && ["", "1"].includes(unit)) return 0.01;
  if (plain === "g" && whole === "m/s2") return STANDARD_GRAVITY;
  const [words, parts] = [plain, whole].map((text) => text.split("/"));
  if (words.length !== parts.length) return NaN;
  return parts.map((part, k) => prefixFactor(withPoints(words[k], part), part)).reduce((above, below) => above / below);
}

/** Return a `word` for a product of units, such as kNm or kN m, with the points between letters that the `part` of a unit has: kN.m. */
function withPoints(word, part) {
  const [whole, bare] = [word, part].map((text) => text.replaceAll(/(?<=[a-z])[. ]+(?=[a-z])/gi, ""));
  return bare !== part && whole.endsWith(bare) ? whole.slice(0, -bare.length) + part : word;
}

/** Return the factor from a `word` to a `part` of a unit with perhaps another prefix, as mm^1.5 for m^1.5; NaN for other words. */
function prefixFactor(word, part) {
  const [, stem, power = ""] = /^([a-z]+)(\^?[\d.]+)?$/i.exec(part) ?? [part, part];
  if (word === part) return 1;
  const [base, own] = stem.startsWith("kg") ? [stem.slice(1), SI_PREFIXES.k] : [stem, 1];
  const isLike = word.endsWith(base + power) && /^[a-z]/i.test(base);
  const factor = isLike ? SI_PREFIXES[word.slice(0, word.length - (base + power).length)] : NaN;
  return ((factor ?? NaN) / own) ** (Number(power.replace("^", "")) || 1);
}

/** Return words for units that `typed` understands for a `unit`: "m, cm, mm" for m, "N/m^1.5, kN/m^1.5, N/mm^1.5" for N/m^1.5. */
function understood(unit) {
  if (unit in IN_DEGREES) return `${unitText(unit).replace("rad", "°")}, ${unitText(unit)}`;
  const plain = raised(unit).replaceAll(".", "·").replace(/(?<=\d)·(?=\d)/, ".");
  const some = { m: ["m", "cm", "mm"], s: ["s", "ms"], kg: ["kg", "g"], "m/s2": ["m/s²", "g"] }[unit];
  const isWord = /^[a-z]/i.test(plain);
  const others = isWord ? [plain, `k${plain.replace(/^kg/, "g")}`, plain.replace("/m", "/mm")] : [];
  return (some ?? [...new Set(others)]).join(", ");
}

/** Return {tokens, word, factor} of what a reader types: numbers and signs, a unit's word, and the factor from it to a `unit`. */
function typedParts(given, unit) {
  const text = withPoint(given).trim();
  const [sum] = SUM.exec(text);
  const tokens = sum.match(TOKEN) ?? [];
  const isInRad = unit in IN_DEGREES && tokens.some((token) => PI.test(token));
  const word = text.slice(sum.length) || (isInRad ? unit : "");
  return { tokens, word, factor: factorOf(word, unit) };
}

/** Return words for what is wrong in what a reader types: the comma or the unit that is not understood; else "". */
export function notUnderstood(given, unit) {
  if (/\d,\d/.test(withPoint(given))) return "this comma may separate thousands; the decimal sign is a point";
  const { tokens, word, factor } = typedParts(given, unit);
  if (!Number.isNaN(factor) || !Number.isFinite(calculated(tokens))) return "";
  const known = understood(unit);
  return known ? `the unit "${word}" is not understood; write ${known}` : `this value has no unit "${word}"`;
}

/**
 * Return what a reader types for a quantity with a `unit` as a number in this unit: "90" and "90°" for an angle, "1.5 rad", "2*0.6",
 * "120 cm". An angle with pi and no unit is in rad. Return any other text as it is, so that it is refused.
 */
export function typed(given, unit) {
  const { tokens, factor } = typedParts(given, unit);
  const isExact = factor === DEGREE || (factor === 1 && tokens.length < 3); // else without round-off in the last digit
  const value = calculated(tokens) * factor;
  return Number.isFinite(value) ? Number(value.toPrecision(isExact ? ALL_DIGITS : 15)) : given;
}

/** Return a sentence on an allowed value with the unit in which a field shows an angle, and without the words on texts in degrees. */
export function inShownUnit(sentence) {
  return sentence.replace(/, or text in degrees as "[^"]*"/, "; an angle in rad ends with rad").replace(/(?<=\[)rad/, "°");
}

/** Return a value as text with at most `digits` significant digits; an angle in degrees, with at most DEGREE_DIGITS. */
export function valueText(value, unit, digits = ALL_DIGITS) {
  const [shown, most] = unit in IN_DEGREES ? [value / DEGREE, Math.min(digits, DEGREE_DIGITS)] : [value, digits];
  return numberText(Number(shown.toPrecision(most)));
}

/**
 * Return a value as text with all its digits if a field has room for them, else with the most digits from 6 to 3 that fit, at least 3. An
 * angle that is not round in degrees has at most 4 digits.
 */
export function shortText(value, unit) {
  const isRound = !(unit in IN_DEGREES) || Math.abs(Number(valueText(value, unit)) * DEGREE - value) <= 1e-9 * Math.abs(value);
  const texts = [...(isRound ? [ALL_DIGITS, 6, 5] : []), 4, 3].map((digits) => valueText(value, unit, digits));
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
