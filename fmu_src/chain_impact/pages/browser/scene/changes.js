// The present parameters of the page: the values of the scene, and the changes of the reader.

import { numberText } from "../base/format.js";
import { inFile, pathText } from "../base/paths.js";
import { inRadians, orDegrees } from "./angles.js";
import { sumOf } from "./geometry.js";
import { keepFileRules } from "./refusals.js";

export class Changes {
  #listeners = [];
  #openers = [];

  constructor(scene) {
    this.#use(scene);
  }

  #use(scene) {
    this.scene = scene;
    this.starts = Object.fromEntries(scene.parameters.map(({ name, start }) => [name, start]));
    this.parameters = new Map(scene.parameters.map((parameter) => [parameter.name, parameter]));
    this.names = new Map(scene.parameters.flatMap(({ name, filePath }) => (filePath ? [[pathText(filePath), name]] : [])));
    this.values = {}; // the changed values, by name, as numbers
    this.inputSteps = {}; // inputs that were changed while the motion played: name → pairs of a time [s] and the value from this time on
  }

  /** Use another scene; changes `from` an earlier scene are kept if this scene has their parameters. */
  open(scene, from = { values: {}, inputSteps: {} }) {
    this.#use(scene);
    this.#openers.forEach((opener) => opener());
    const [values, inputSteps] = [from.values, from.inputSteps].map((table) =>
      without(table, Object.keys(table).filter((name) => !this.parameters.has(name))));
    this.replace(this.with(values), inputSteps);
  }

  /** Add a listener that is called when another scene is opened; it is called before the listeners for values. */
  onOpen(opener) {
    this.#openers.push(opener);
  }

  onChange(listener) {
    this.#listeners.push(listener);
  }

  get count() {
    return Object.keys({ ...this.values, ...this.inputSteps }).length;
  }

  /**
   * Return the value of `name` with the changes `values`: the changed value itself; without it, the value that follows from other
   * parameters; if it does not follow from others, the scene's value.
   */
  valueOf(name, values = this.values) {
    const { derived } = this.parameters.get(name) ?? {};
    if (name in values || !derived) return values[name] ?? this.starts[name];
    return sumOf(derived, (factor) => this.valueOf(factor, values));
  }

  /** Return the value of an input at a time, or of any other parameter. */
  valueAt(name, time) {
    return this.inputSteps[name]?.findLast(([from]) => from <= time)?.[1] ?? this.valueOf(name);
  }

  isChanged(name) {
    return name in this.values || name in this.inputSteps;
  }

  /**
   * Return the number for a value of a parameter: a number, a text, in which degrees become radians, or the name of a choice. An error
   * names the allowed values.
   */
  numberOf(name, given) {
    const parameter = this.parameters.get(name);
    if (!parameter) throw new RangeError(`${this.scene.name} has no parameter ${name}`);
    const { items, low, high, allowed, type, unit } = parameter;
    const choice = items.findIndex(([id]) => id === given) + 1;
    const text = typeof given === "string" ? given.trim() : given;
    const number = inRadians(text, unit);
    const isNumber = typeof number === "number" || (typeof number === "string" && number !== "");
    const value = choice || (isNumber ? Number(number) : NaN);
    const whole = type === "real" || Number.isInteger(value);
    if (!(value >= low && value <= high && whole)) {
      const told = text === "" ? `${name} is empty, and` : `${name} = ${given}`;
      const advice = typeof text === "string" && !Number.isFinite(Number(text)) ? orDegrees(unit) : "";
      throw new RangeError(`${told} must be ${allowed}${advice}`);
    }
    return value;
  }

  /**
   * Return the changes `from`, with the changes `given` added, after a check. A value that equals the scene's value is not a change, unless
   * the scene derives the value: the change then fixes the value.
   */
  with(given, from = this.values) {
    const values = { ...from };
    for (const [name, text] of Object.entries(given)) {
      const value = this.numberOf(name, text);
      if (value === this.starts[name] && !this.parameters.get(name).derived) delete values[name];
      else values[name] = value;
    }
    this.#check(values);
    return values;
  }

  /** Refuse values that are valid alone but not together, as the scene does. */
  #check(values) {
    const nameAt = (path) => this.names.get(pathText(path));
    const valueAt = (path) => (nameAt(path) ? this.valueOf(nameAt(path), values) : inFile(this.scene.file, path));
    const rules = SHARED.rules.FILE.filter((rule) => !rule.in_kernel);
    keepFileRules(this.scene.file, rules, valueAt, (path) => nameAt(path) ?? pathText(path));
  }

  /** Change some values: name → number, text, or the name of a choice. An input then has its value at all times. */
  set(given) {
    this.replace(this.with(given), without(this.inputSteps, Object.keys(given)));
  }

  /** Give an input a value from a time on; its steps from this time on are removed. */
  setFrom(name, given, time) {
    const before = (this.inputSteps[name] ?? []).filter(([from]) => from < time);
    this.replace(this.values, { ...this.inputSteps, [name]: [...before, [time, this.numberOf(name, given)]] });
  }

  reset(name) {
    this.replace(this.with({}, without(this.values, [name])), without(this.inputSteps, [name]));
  }

  /** Replace all changes on the page by the given changes. */
  replace(values, inputSteps = this.inputSteps) {
    Object.assign(this, { values, inputSteps });
    this.#listeners.forEach((listener) => listener());
  }

  /** Return the changes in the form for a command or a link: pairs of a name and a text; for a choice, the text is its name. */
  texts(values = this.values) {
    return Object.entries(values).map(([name, value]) => {
      const { items } = this.parameters.get(name);
      return [name, items.length ? items[value - 1][0] : numberText(value)];
    });
  }
}

/** Return a table without some of its keys. */
function without(table, keys) {
  return Object.fromEntries(Object.entries(table).filter(([key]) => !keys.includes(key)));
}
