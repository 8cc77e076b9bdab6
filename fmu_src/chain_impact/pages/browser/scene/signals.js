// The signals of a scene: the inputs that each signal drives, the data of signals in the record, and the checks, as in
// `scene/signals.py` and `scene/signal_values.py`. The page has only the tables of its own scene.

import { numbersIn } from "../base/base64.js";
import { unitText } from "../base/format.js";

const MOTIONS = ["", "v", "a"]; // motions of a base, without the axis; each is the derivative of the one before
const WALL_MOTIONS = ["displacement", "velocity", "acceleration"];

/**
 * Return the names of the quantities that an input drives, each the derivative of the one before; "" for a quantity that is
 * no input.
 */
function familyOf(name) {
  const [head, last] = [name.slice(0, name.lastIndexOf(".")), name.slice(name.lastIndexOf(".") + 1)];
  if (head === "base") return MOTIONS.map((prefix) => `base.${prefix}${last.at(-1)}`);
  if (last === "belt_speed") return ["", name]; // the travel of a belt is not an input
  if (head.startsWith("wall.")) return WALL_MOTIONS.map((key) => `${head}.${key}`);
  return /^target_(angle|position)$/.test(last) ? [name, `${head}.target_velocity`] : [name];
}

/** Return whether an input moves base or wall; only one input of a motion can be driven. */
function isMotion(name) {
  return /^(base|wall)\./.test(name) && !name.endsWith(".belt_speed");
}

/** Return the signals with exactly the keys of their forms; `tables` are the tables by name. */
export function completeSignals(signals, { required, other, tables }) {
  for (const [name, signal] of Object.entries(signals)) {
    const what = `signals.${name}`;
    const known = [...required[signal.form], ...Object.keys(other[signal.form])];
    const strange = Object.keys(signal).find((key) => !["input", "form", ...known].includes(key));
    if (strange) throw new RangeError(`${what}.${strange} must be left out: form = "${signal.form}" has ${known.join(", ")}`);
    const missing = required[signal.form].find((key) => signal[key] === undefined);
    if (missing) throw new RangeError(`${what}.${missing} is missing: form = "${signal.form}" needs it`);
    signals[name] = { ...Object.fromEntries(Object.entries(other[signal.form]).filter(([, value]) => value !== null)), ...signal };
    if (signal.form === "steps") checkSteps(what, signal);
    if (signal.form === "table") checkTable(what, signals[name], tables[name]);
  }
}

/** Return the signals in the form of a file, without the default values of their `forms`. */
export function signalsAsWritten(signals, forms) {
  return Object.fromEntries(Object.entries(signals).map(([name, signal]) =>
    [name, Object.fromEntries(Object.entries(signal).filter(([key, value]) => forms[signal.form][key] !== value))]));
}

function checkSteps(what, { times, values }) {
  if (times.length === 0 || times.length !== values.length) {
    throw new RangeError(`${what}.times and .values must be of one length > 0, not ${times.length} and ${values.length}`);
  }
  const late = times.findIndex((time, k) => k > 0 && !(time > times[k - 1]));
  if (late > 0) throw new RangeError(`${what}.times[${late + 1}] = ${times[late]} must be > ${times[late - 1]} [s], the time before it`);
}

/** Refuse a table that the page does not have. */
function checkTable(what, { file, interpolation = null, period = null, input }, table) {
  const isSame = table?.file === file.split(/[\\/]/).at(-1) && table.interpolation === interpolation && table.period === period;
  if (isSame && input.every((name) => name in table.columns)) return;
  throw new RangeError(`${what}.file = "${file}": the page does not have this table as this signal needs it; chain-impact explore makes a page with it`);
}

/** Return the driven inputs, with a row of the record for each: its number of knots, and all quantities that it drives. */
export function drivenBy({ signals }, { knots, tables }) {
  const count = (name, input, { form, shape, times }) => ({
    steps: () => times.length,
    table: () => tables[name].columns[input].knots,
  }[form] ?? (() => knots[form] + (shape === "trapezoid" ? 2 : 0)))();
  const rows = Object.entries(signals).flatMap(([name, signal]) => signal.input.map((input) => {
    const outputs = familyOf(input);
    return { name, input, signal, outputs, order: outputs.indexOf(input), knots: count(name, input, signal) };
  }));
  // a target velocity comes after the target whose rate it replaces
  const [late, early] = [true, false].map((wanted) => rows.filter(({ input }) => input.endsWith("target_velocity") === wanted));
  let first = 0;
  return [...early, ...late].map((row) => {
    first += row.knots;
    return { ...row, first: first - row.knots };
  });
}

/**
 * Refuse inputs that the scene does not have, and inputs that are driven twice; `units` are the units of the scene's inputs.
 */
export function checkDriven(driven, units) {
  const owners = new Map();
  for (const { name, input, signal } of driven) {
    const what = `signals.${name}.input`;
    if (!units.has(input)) {
      const there = [...units.keys()].join(", ");
      throw new RangeError(`${what} = "${input}" is no input of the scene; it has ${there || "none"}`);
    }
    const alone = isMotion(input) ? familyOf(input) : [input];
    const owned = alone.find((quantity) => owners.has(quantity));
    if (owned) throw new RangeError(`${what} = "${input}" must be driven by one signal only: signals.${owners.get(owned)} drives ${owned}`);
    alone.forEach((quantity) => owners.set(quantity, name));
    const other = signal.form !== "table" && signal.input.find((member) => units.get(member) !== units.get(input));
    if (other) throw new RangeError(`${what} must name inputs of one unit: ${input} is in ${unitText(units.get(input))}, ${other} in ${unitText(units.get(other))}`);
  }
}

/**
 * Return the driven quantities: name of an input, of its integral or derivative → row of its signal, and order of the
 * derivative.
 */
export function drivenRows(driven) {
  return new Map(driven.flatMap(({ outputs }, row) => outputs.map((name, order) => [name, [row, order]])).filter(([name]) => name));
}

/** Return the elements of signals, each in the row of the first input that it drives, and of steps. */
export function signalElements(driven, units) {
  const first = driven.filter(({ name }, row) => driven.findIndex((other) => other.name === name) === row);
  return {
    signal: first.map((each) => ({ name: each.name, at: driven.indexOf(each), unit: units.get(each.input) })),
    step: first.filter(({ signal }) => signal.form === "steps").flatMap(({ name, input, signal, first: knot }) =>
      signal.times.map((_, k) => ({ name, n: k + 1, at: knot + k, entry: k, unit: units.get(input) }))),
  };
}

/** Put the signals into a new record: `put` gets the name of a field, a value and an index. */
export function putSignals(driven, { forms, shapes, numbers, tables }, acting, put) {
  driven.forEach(({ name, input, signal, order, knots, first }, row) => {
    const [number, index] = acting(input);
    const fields = {
      form: forms.indexOf(signal.form),
      shape: Math.max(shapes.indexOf(signal.shape), 0),
      source: driven.findIndex((other) => other.name === name),
      input: number,
      index,
      order,
      first,
      segment: first,
      last: first + knots - 1,
      ...Object.fromEntries(numbers.map((key) => [key, signal[key] ?? 0])),
    };
    Object.entries(fields).forEach(([key, value]) => put(`signal_${key}`, value, row));
    if (signal.form === "steps") {
      signal.times.forEach((time, k) => put("knot_given_time", time, first + k));
      signal.values.forEach((value, k) => put("knot_given_value", value, first + k));
    }
    if (signal.form !== "table") return;
    const { times, powers, gain } = tables[name].columns[input];
    put("signal_gain", gain, row);
    put("signal_period", signal.period ?? 0, row);
    numbersIn(times).forEach((time, k) => put("knot_time", time, first + k));
    powers.forEach((column, p) => numbersIn(column).forEach((value, k) => put(`knot_power_${p}`, value, first + k)));
  });
}
