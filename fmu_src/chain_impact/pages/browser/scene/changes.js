// The present parameters of the page: the values of the scene, and the reader's changes of them.

import { numberText } from "../base/format.js";
import { valueInFile, pathText } from "../base/paths.js";
import { nearestText } from "../base/similar_names.js";
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
    this.values = {}; // name → changed value, a number; a choice is the number of its item
    // inputs that the reader changed while the motion played: name → pairs of a time [s] and the value from it to the next pair's time
    this.inputSteps = {};
  }

  /** Use another scene. Of the changes `from`, which are for an earlier scene, those stay whose parameters this scene has, too. */
  open(scene, from = { values: {}, inputSteps: {} }) {
    this.#use(scene);
    this.#openers.forEach((opener) => opener());
    const [values, inputSteps] = [from.values, from.inputSteps].map((table) =>
      without(table, Object.keys(table).filter((name) => !this.parameters.has(name))));
    this.replace(this.with(values), inputSteps);
  }

  /** Add a function that is called when another scene is opened, before the listeners for changed values. */
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
   * Return the value of a parameter with the changes `values`: the changed value; else the value that follows from other parameters; else
   * the value in the scene; undefined for an unknown name. This is an arrow function, so that it keeps `this` as an argument of others.
   */
  valueOf = (name, values = this.values) => {
    const { derived } = this.parameters.get(name) ?? {};
    if (name in values || !derived) return values[name] ?? this.starts[name];
    return sumOf(derived, (factor) => this.valueOf(factor, values));
  };

  /** Return a parameter's value at a time [s]: that of an input's last step up to this time or, without such a step, that of `valueOf`. */
  valueAt(name, time) {
    return this.inputSteps[name]?.findLast(([from]) => from <= time)?.[1] ?? this.valueOf(name);
  }

  isChanged(name) {
    return name in this.values || name in this.inputSteps;
  }

  /**
   * Return the number that stands for a value that the reader gives: a number, a text (degrees become radians), or the name of a choice. If
   * the value is not allowed, the error names the allowed values.
   */
  numberOf(name, given) {
    const parameter = this.parameters.get(name);
    if (!parameter) throw new RangeError(`${this.scene.name} has no parameter ${name}${nearestText(name, [...this.parameters.keys()])}`);
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
   * Return the changes `from`, name → number, with `given` added, name → number or text, after a check. A given value that equals the
   * scene's value is left out, unless the scene derives the parameter from others: without a change, the parameter would follow from these.
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

  /** Refuse changes with which values of the scene file are valid alone, but not together; the kernel checks further rules. */
  #check(values) {
    const nameAt = (path) => this.names.get(pathText(path));
    const valueAt = (path) => (nameAt(path) ? this.valueOf(nameAt(path), values) : valueInFile(this.scene.file, path));
    const rules = SHARED.refusalRules.FILE.filter((rule) => !rule.in_kernel);
    keepFileRules(this.scene.file, { textAt: (path) => nameAt(path) ?? pathText(path), rules, valueAt });
  }

  /** Change the values of some parameters: name → number, text, or name of a choice. A changed input has the given value at all times. */
  set(given) {
    this.replace(this.with(given), without(this.inputSteps, Object.keys(given)));
  }

  /** Give an input a value from a time [s] on, and remove the input's steps at this time and later. */
  setFrom(name, given, time) {
    const before = (this.inputSteps[name] ?? []).filter(([from]) => from < time);
    this.replace(this.values, { ...this.inputSteps, [name]: [...before, [time, this.numberOf(name, given)]] });
  }

  reset(name) {
    this.replace(this.with({}, without(this.values, [name])), without(this.inputSteps, [name]));
  }

  /** Give the parameters `names` the values and the steps that they have in the changes `before`. */
  takeBack(names, before) {
    const [values, inputSteps] = ["values", "inputSteps"].map((key) => {
      const kept = names.filter((name) => name in before[key]).map((name) => [name, before[key][name]]);
      return { ...without(this[key], names), ...Object.fromEntries(kept) };
    });
    this.replace(values, inputSteps);
  }

  /** Replace the changed values by `values`, and the steps of inputs by `inputSteps`, which by default stay; then call the listeners. */
  replace(values, inputSteps = this.inputSteps) {
    Object.assign(this, { values, inputSteps });
    this.#listeners.forEach((listener) => listener());
  }

  /** Return changes of parameters for a command or an address, as pairs [name, text of the value]; a choice is given by its name. */
  texts(values = this.values) {
    return Object.entries(values).map(([name, value]) => {
      const { items } = this.parameters.get(name);
      return [name, items.length ? items[value - 1][0] : numberText(value)];
    });
  }
}

/** Return changes of a scene that stay as they are, while the page's changes go on. */
export function changesOf(scene, values, inputSteps) {
  return Object.assign(new Changes(scene), { values, inputSteps });
}

/** Return a table without some of its keys. */
function without(table, keys) {
  return Object.fromEntries(Object.entries(table).filter(([key]) => !keys.includes(key)));
}
