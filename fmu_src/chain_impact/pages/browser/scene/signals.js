// The signals of a scene: the inputs that each drives, their data in the record, and the checks. The page has only the
// tables of the scene with which it was made.
// The twins in Python are `scene/signals.py`, `scene/signal_polynomials.py`, `scene/checks/signal_checks.py`.

import { numbersIn } from "../base/base64.js";
import { unitText } from "../base/format.js";
import { keepRules, refuse, shown } from "./refusals.js";

const SIGNALS = SHARED.signals;

/**
 * Add to each signal the defaults of its form. Refuse unsuitable names, missing keys, keys of other forms, and signals that `checkTable`
 * refuses. `tables`: signal → the page's data of its table.
 */
export function completeSignals(signals, tables) {
  for (const [name, signal] of Object.entries(signals)) {
    const { form } = signal;
    const what = `signals.${name}`;
    const keysOf = (kind) => [...SIGNALS.REQUIRED[kind], ...Object.keys(SIGNALS.OTHER[kind])];
    if (!/^[\p{XID_Start}_]\p{XID_Continue}*$/u.test(name)) refuse(what, "signal_name");
    const strange = SIGNALS.FORMS.flatMap(keysOf).find((key) => !keysOf(form).includes(key) && signal[key] !== undefined);
    if (strange) refuse(`${what}.${strange}`, "other_form", { form, keys: keysOf(form).join(", ") });
    const missing = SIGNALS.REQUIRED[form].find((key) => signal[key] === undefined);
    if (missing) refuse(`${what}.${missing}`, "needs_key", { form });
    signals[name] = { ...Object.fromEntries(Object.entries(SIGNALS.OTHER[signal.form]).filter(([, value]) => value !== null)), ...signal };
    if (form === "table") checkTable(what, signals[name], tables[name]);
  }
}

/** Return the signals as a file has them, without the default values of their forms. */
export function signalsAsWritten(signals) {
  return Object.fromEntries(Object.entries(signals).map(([name, signal]) =>
    [name, Object.fromEntries(Object.entries(signal).filter(([key, value]) => SIGNALS.OTHER[signal.form][key] !== value))]));
}

function checkSteps(what, { times, values }) {
  if (times.length === 0 || times.length !== values.length) {
    refuse(`${what}.times`, "times", { times: times.length, values: values.length });
  }
  const late = times.findIndex((time, k) => k > 0 && !(time > times[k - 1]));
  if (late > 0) refuse(`${what}.times[${late + 1}]`, "late", { value: times[late], before: times[late - 1] });
}

/** Refuse a signal that needs a table that the page does not have; `table`: the page's table for this signal, if there is one. */
function checkTable(what, { file, interpolation = null, period = null, input }, table) {
  const isSame = table?.file === file.split(/[\\/]/).at(-1) && table.interpolation === interpolation && table.period === period;
  if (isSame && input.every((name) => name in table.columns)) return;
  const reason = "the page does not have this table as this signal needs it; chain-impact explore makes a page with it";
  throw new RangeError(`${what}.file = "${file}": ${reason}`);
}

/**
 * Refuse a signal that cannot drive an input. `order`: the number of integrations over time from the input to the first quantity that the
 * signal determines, such as 2 for base.ax; `moves`: whether the input moves the base or a wall.
 */
function checkMotion(what, input, signal, order, moves) {
  const speed = Math.abs(signal.amplitude * signal.frequency);
  const facts = {
    order,
    moves,
    steps_differ: new Set(signal.values).size > 1,
    starts_fast: Math.abs(speed * Math.cos(signal.phase)) > SIGNALS.REST_TOLERANCE * speed,
  };
  keepRules(SHARED.refusalRules.SIGNAL, (key) => facts[key] ?? signal[key], (key) => `${what}.${key}`, { input });
}

/**
 * Return the driven inputs in the order of their rows in the record, each with the index (`first`) of its first polynomial, a knot, and the
 * number (`knots`) of its polynomials.
 */
export function drivenBy({ signals }, tables) {
  const count = (name, input, { form, shape, times }) => ({
    steps: () => times.length,
    table: () => tables[name].columns[input].knots,
  }[form] ?? (() => SIGNALS.KNOTS[shape === "trapezoid" ? shape : form]))();
  const rows = Object.entries(signals).flatMap(([name, signal]) =>
    signal.input.map((input) => ({ name, input, signal, knots: count(name, input, signal) })));
  const [late, early] = [true, false].map((wanted) => rows.filter(({ input }) => input.endsWith(SIGNALS.TARGET_RATE) === wanted));
  let first = 0;
  return [...early, ...late].map((row) => {
    first += row.knots;
    return { ...row, first: first - row.knots };
  });
}

/**
 * Return the driven inputs, each with the names of all quantities that it determines: integrals of the input over time, the input, and its
 * derivatives, in this order; "" for one that is no input. Refuse a signal without an input, inputs that are not among `inputs`, that are
 * driven twice or, except with a table, have different units, and signals that `checkSteps` or `checkMotion` refuses.
 */
export function withOutputs(driven, inputs, signals) {
  const owners = new Map();
  const unitOf = (name) => inputs.get(name).unit;
  for (const [name, signal] of Object.entries(signals)) {
    const what = `signals.${name}`;
    if (!signal.input.length) refuse(`${what}.input`, "no_input");
    const strange = signal.input.find((input) => !inputs.has(input));
    if (strange !== undefined) {
      const how = `it has ${[...inputs.keys()].join(", ") || "none"}`;
      refuse(`${what}.input`, "strange_input", { value: shown(strange), how });
    }
    const [first] = signal.input;
    const other = signal.form !== "table" && signal.input.find((member) => unitOf(member) !== unitOf(first));
    if (other) {
      const [unit, other_unit] = [first, other].map((member) => unitText(unitOf(member)));
      refuse(`${what}.input`, "units", { first, unit, other, other_unit });
    }
    if (signal.form === "steps") checkSteps(what, signal);
    for (const input of signal.input) {
      const { alone, family } = inputs.get(input);
      const owned = alone.find((quantity) => owners.has(quantity));
      if (owned !== undefined) {
        const owner = owners.get(owned);
        const by = owner === name ? "it is listed twice" : `signals.${owner} drives ${owned}`;
        refuse(`${what}.input`, "driven_twice", { value: shown(input), by });
      }
      alone.forEach((quantity) => owners.set(quantity, name));
      checkMotion(what, input, signal, family.indexOf(input), alone.length > 1);
    }
  }
  return driven.map((row) => {
    const { family: outputs } = inputs.get(row.input);
    const order = outputs.indexOf(row.input);
    return { ...row, outputs, order };
  });
}

/** Return name of a quantity that a signal determines → its row in the record, and its place among the row's quantities. */
export function drivenRows(driven) {
  return new Map(driven.flatMap(({ outputs }, row) => outputs.map((name, order) => [name, [row, order]])).filter(([name]) => name));
}

/**
 * Write the data of the driven inputs into a new record. `put` is a function that writes a field's value at an index, `acting` a function
 * from an input to the number of its kind and its index.
 */
export function putSignals(driven, tables, acting, put) {
  driven.forEach(({ name, input, signal, order, knots, first }, row) => {
    const [number, index] = acting(input);
    const fields = {
      form: SIGNALS.FORMS.indexOf(signal.form),
      shape: Math.max(SIGNALS.SHAPES.indexOf(signal.shape), 0),
      source: driven.findIndex((other) => other.name === name),
      input: number,
      index,
      order,
      first_knot: first,
      last_knot: first + knots - 1,
      segment: first,
      ...Object.fromEntries(SIGNALS.NUMBERS.map((key) => [key, signal[key] ?? 0])),
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
