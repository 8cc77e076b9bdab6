// Functions that write numbers, units and times as text.
// The twin in Python is `scene/texts/unit_text.py`.

import { mapValues } from "./map_values.js";

const [PRODUCT, SQUARE] = [SHARED.units.PRODUCT, SHARED.units.SQUARE].map((pattern) => new RegExp(pattern, "g"));
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""]];
// for small speeds and impulses: least value for a prefix, in the unit without prefix; factor on the value; prefix of the unit
const SMALL_PREFIXES = [[1e-1, 1, ""], [1e-3, 1e3, "m"], [1e-6, 1e6, "µ"], [1e-10, 1e9, "n"]];

const LEAST_PLAIN = 1e-3; // smaller values in a column have an exponent
// least time [s], factor on the time, its unit
const SHORT_TIMES = [[1, 1, "s"], [1e-3, 1e3, "ms"], [1e-6, 1e6, "µs"], [1e-9, 1e9, "ns"], [1e-18, 1e15, "fs"]];

/** Return a unit as a reader sees it, as `unit_text.py` does; "" for a pure number. */
export function unitText(unit) {
  return unit === "1" ? "" : unit.replaceAll(PRODUCT, "·").replaceAll(SQUARE, "²");
}

/** Return the unit of a stiffness, force over penetration to a power, as `stiffness_unit` in Python: N/m^1.5, or N/m for the exponent 1. */
export function unitOfPower(unit, exponent = "exponent") {
  return unitText(unit).replace("^exponent", exponent === 1 ? "" : `^${exponent}`);
}

/** Return a unit with the exponent at its end, if any, as raised digits: N/m¹·⁵ for N/m^1.5. */
export function raised(unit) {
  const raisedSign = (sign) => "·⁰¹²³⁴⁵⁶⁷⁸⁹"[".0123456789".indexOf(sign)];
  return unit.replace(/\^([\d.]+)$/, (_, power) => [...power].map(raisedSign).join(""));
}

/** Return a text with a minus sign in place of the hyphen with which it begins, if a number follows. */
export function withMinus(text) {
  return text.replace(/^-(?=[\d.])/, "−");
}

/** Return a number as text with `count` significant digits, but all digits before the decimal point, and at most 9 decimals. */
export function digits(value, count = 3) {
  if (value === 0) return "0";
  const decimals = count - 1 - Math.floor(Math.log10(Math.abs(value)));
  return value.toFixed(Math.min(Math.max(decimals, 0), 9));
}

/** Return a number as text with a given number of decimals; a number that is rounded to 0 has no minus sign. */
export function fixed(value, decimals) {
  return value.toFixed(decimals).replace(/^-(?=[0.]*$)/, "");
}

const DECIMALS = 6; // largest number of decimals of an axis label that has no exponent
const EXPONENT_LIMIT = 1e6; // absolute value from which on the labels of an axis have exponents if all are whole numbers

/** Return the labels for ticks at equal distances, with only so many digits that all labels differ. */
export function ticksOf(ticks) {
  const step = ticks.length > 1 ? Number((ticks[1] - ticks[0]).toPrecision(3)) : Math.abs(ticks[0]) || 1;
  const [mantissa, exponent] = step.toExponential().split("e");
  const decimals = (mantissa.split(".")[1] ?? "").length - Number(exponent); // number of decimals of the distance between two ticks
  const largest = Math.max(...ticks.map(Math.abs));
  const isPlain = decimals <= DECIMALS && (largest < EXPONENT_LIMIT || decimals > 0);
  return ticks.map((tick) => {
    if (Math.abs(tick) < step / 2) return "0";
    const afterFirst = Math.floor(Math.log10(Math.abs(tick))) + decimals; // number of digits of this tick after its first digit
    return isPlain ? fixed(tick, Math.max(decimals, 0)) : tick.toExponential(Math.min(Math.max(afterFirst, 0), 15));
  });
}

/** Return the pair of PREFIXES that suits a size: its least value, by which values are divided, and its prefix; [1, ""] below 1. */
function largePrefix(size) {
  return PREFIXES.find(([least]) => size >= least) ?? [1, ""];
}

/**
 * Return a force [N] as text, such as 12.3 kN: with `count` significant digits, or up to 6 if `count` is 0. A moment has another `unit`.
 */
export function forceText(newtons, count = 3, unit = "N") {
  const [factor, prefix] = largePrefix(Math.abs(newtons));
  const value = newtons / factor;
  return `${count ? digits(value, count) : +value.toPrecision(6)}\u202f${prefix}${unit}`;
}

/** Return a value ≥ 0 and its unit, with a prefix if the value is small; a value below those of all prefixes is 0. */
function withSmallPrefix(value, unit) {
  const [, factor, prefix] = SMALL_PREFIXES.find(([least]) => value >= least) ?? [0, 0, ""];
  return [factor * value, prefix + unit];
}

/** Return the impulse of an impact as text with its unit, N·s or, at a stop of a joint, N·m·s; "" if it is unknown. */
export function impulseText(impact, count = 3) {
  if (!Number.isFinite(impact.impulse ?? NaN)) return "";
  return amountText(impact.impulse, unitsOf(impact).impulse, count);
}

/** Return a value ≥ 0 as text with its unit, which has a prefix if the value is small or large, such as 12 mJ. */
export function amountText(value, unit, count = 3) {
  const [scaled, suited] = withSmallPrefix(value, unit);
  return forceText(scaled, count, suited);
}

/** Return the labels for an axis of forces, all with the prefix of the unit that suits the largest tick. */
export function forceTicks(ticks, unit) {
  const [factor, prefix] = largePrefix(Math.max(...ticks.map(Math.abs)));
  return ticks.map((tick) => (tick ? `${+(tick / factor).toPrecision(6)}\u202f${prefix}${unit}` : "0"));
}

/**
 * Return {unit, textOf} for a list of quantities, pairs [value, unit]: all values with one unit have one prefix, which suits the largest.
 * `unit` is the only unit with its prefix; with several units it is "", and the texts that `textOf` returns for pairs contain units.
 */
export function inOneUnit(pairs) {
  const most = new Map();
  pairs.forEach(([value, unit]) => Number.isFinite(value ?? NaN) && most.set(unit, Math.max(most.get(unit) ?? 0, value)));
  const scales = new Map([...most].map(([unit, largest]) => {
    const [least, prefix] = largePrefix(largest);
    const [, factor, small] = SMALL_PREFIXES.find(([from]) => largest >= from) ?? [0, 1, ""];
    return [unit, largest >= 1 ? [1 / least, prefix + unit] : [factor, small + unit]];
  }));
  const unit = scales.size === 1 ? [...scales.values()][0][1] : "";
  const textOf = ([value, own]) => {
    if (!Number.isFinite(value ?? NaN)) return "–";
    const [factor, text] = scales.get(own);
    const scaled = factor * value;
    const number = scaled !== 0 && Math.abs(scaled) < LEAST_PLAIN ? scaled.toExponential(1) : digits(scaled);
    return unit ? number : `${number}\u202f${text}`;
  };
  return { unit, textOf };
}

/** Return a time [s] as text with its unit, for example 620 µs. */
export function durationText(seconds, count = 3) {
  const [, factor, unit] = SHORT_TIMES.find(([least]) => Math.abs(seconds) >= least) ?? [0, 1e6, "µs"];
  return `${digits(seconds * factor, count)}\u202f${unit}`;
}

/** Return a speed in a `unit` as text: with two decimals or, if it is small, with three digits and a prefix, for example 3.52 mm/s. */
export function speedWithUnit(speed, unit) {
  const [value, suited] = withSmallPrefix(speed, unit);
  return `${suited === unit && value > 0 ? value.toFixed(2) : digits(value)}\u202f${suited}`;
}

/** Return words for a rate relative to real time, for example: 480 × slower; "real time" for a rate near 1. */
export function rateText(value) {
  if (Math.abs(value - 1) < SHARED.pacing.REAL) return "real time";
  const [times, word] = value < 1 ? [1 / value, "slower"] : [value, "faster"];
  const rounded = times < SHARED.pacing.TENS ? String(Number(times.toFixed(1))) : Number(times.toPrecision(2)).toFixed(0);
  return rounded === "1" ? "real time" : `${rounded} × ${word}`;
}

/** Return a speed of playing for a menu as text, for example ½ ×. */
export function speedText(value) {
  const names = { 0.5: "½", 0.25: "¼", 0.125: "⅛", 0.0625: "1⁄16" };
  return `${names[value] ?? Number(value.toPrecision(3))} ×`;
}

/**
 * Return the largest force of an impact or, at a stop of a joint, the largest moment as text; the impulse if the impact has no peak force;
 * `unknown` if the impulse is unknown, too.
 */
export function peakText(impact, unknown = "–") {
  return impact.peak_force === null ? impulseText(impact) || unknown : forceText(impact.peak_force, 3, unitsOf(impact).peak_force);
}

/** Return name of a quantity of an impact → its unit; at a stop of a joint (`atStop`), speeds, forces and so on are angular. */
export function unitsOf({ atStop }) {
  return mapValues(SHARED.impactUnits[atStop ? "AT_STOP" : "AT_WALL"], unitText);
}

/** Return a sentence with ≤ and ≥ in place of <= and >=, in which no line ends after a sign of comparison. */
export function readable(text) {
  return text.replaceAll(">=", "≥").replaceAll("<=", "≤").replaceAll(/(?<=[<>≤≥]) /g, "\u00a0");
}

/** Return a name or a unit in which the browser may break the line after each ".", "_" or "/". */
export function breakable(name) {
  return name.replaceAll(/([._/])/g, "$1\u200b");
}

/** Return a value with its unit as text, in the `factor` and the unit (`text`) of `shown`, with at most `count` significant digits. */
export function textWithUnit(value, shown, count = 5) {
  const number = withMinus(numberText(Number((shown.factor * value).toPrecision(count))));
  return [number, shown.text].filter(Boolean).join("\u202f");
}

/** Return a typed text with a point in place of each decimal comma; a comma that may be one of thousands, as in 1,500, stays. */
export function withPoint(text) {
  return text.replace(/(?<![\d.,])(\d*),(\d+)(?![\d.,])/g, (all, whole, decimals) =>
    (/^[1-9]\d{0,2}$/.test(whole) && decimals.length === 3 ? all : `${whole}.${decimals}`));
}

/** Return a number as text with the fewest digits from which exactly this number is read again. */
export function numberText(value) {
  const size = Math.abs(value);
  return size !== 0 && (size >= 1e6 || size < 1e-3) ? value.toExponential().replace("e+", "e") : String(value);
}
