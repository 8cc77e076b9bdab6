// What drives an output of the map: the parameters in the order of their effects, each from a run with a small step of this parameter.

import { find, make } from "../../base/dom.js";
import { digits, unitText, withMinus } from "../../base/format.js";
import { save } from "../export.js";
import { outputIn, presentOutputs, runIn, wordsOfRun } from "./map_outputs.js";
import { quantityOf, scaledTo } from "./map_scales.js";

// the step of each parameter, relative to its value or, for a value of 0, in its SI unit (PART in recording/sensitivity.py)
const STEP_SHARE = 0.01;
const ANGLE_STEP = Math.PI / 180; // step of each angle [rad]: its value depends on the direction from which it is counted
const MOST_AT_ZERO = 4; // largest number of parameters with the value 0 in the list
const LEAST_SHARE = 1e-6; // an effect that is at most this, relative to the output, can be an error of the solver, and counts as none
const MOST_EFFECTS = 10; // largest number of parameters in the list
// parameters that are no part of the mechanism, and exponents, which change the unit of a stiffness
const NOT_RANKED = /^(solver|simulation)\.|\.exponent$/;

/**
 * Return a parameter's `name`, its `value` after a step, with the `sign` 1, or, if the scene refuses this value, after the opposite step,
 * with the `sign` −1; undefined if the scene refuses both. The `text` tells the step: 1 % of the value, 1° for an angle, or for a value of
 * 0 (`isAtZero`) a hundredth of the unit.
 */
function stepOf(changes, name) {
  const { unit } = changes.parameters.get(name);
  const before = changes.valueOf(name);
  const isAngle = unit === "rad";
  const isAtZero = before === 0 && !isAngle;
  const step = isAngle ? ANGLE_STEP : isAtZero ? STEP_SHARE : Math.abs(before) * STEP_SHARE;
  const size = isAngle ? "1°" : isAtZero ? `${STEP_SHARE}\u202f${unitText(unit)}`.trim() : "1\u202f%";
  const upwards = before < 0 && !isAngle ? -1 : 1; // 1 % more of a negative value is a more negative value
  const steps = [1, -1].map((sign) => ({ name, sign, isAtZero, value: before + sign * upwards * step, text: `+ ${size}` }));
  return steps.find(({ value }) => {
    try {
      return changes.with({ [name]: value });
    } catch {
      return false;
    }
  });
}

/** Return effects as CSV: for each parameter its step, and the change of the `output` in its SI unit, also relative to its value `base`. */
function csvOfRanking(changes, effects, output, base) {
  const lines = effects.map(({ name, text, change }) =>
    [name, changes.valueOf(name), `"${text.slice(2)}"`, change, base ? change / Math.abs(base) : ""]);
  return [["parameter", "value", "step", `change of ${output.name}`, "relative change"], ...lines, ""].map((line) =>
    (line ? line.join(",") : "")).join("\r\n");
}

export class Ranking {
  #engines = []; // the workers that are in use

  /**
   * Connect the button that shows the list in place of the map. `startEngines`: a function that starts workers; `wordsOf`: a function from
   * the name of a parameter to its words; `choose`: a function that lets the map vary a parameter.
   */
  constructor(changes, { startEngines, wordsOf, choose }) {
    Object.assign(this, { changes, startEngines, wordsOf, choose });
    [this.button, this.list, this.text] = ["map-rank", "map-ranking", "map-ranking-text"].map(find);
    this.button.addEventListener("click", () => this.#show(this.text.hidden));
    find("map-output").addEventListener("change", () => this.#draw());
    find("map").addEventListener("close", () => this.#show(false));
    find("map-rank-csv").addEventListener("click", () =>
      save(new Blob([this.csv], { type: "text/csv" }), `${changes.scene.name}-ranking.csv`));
  }

  /** Begin the list, which takes the place of the map when the list has entries; if `isShown` is false, show the map again. */
  #show(isShown) {
    this.text.hidden = !isShown;
    this.#fill([]);
    this.button.setAttribute("aria-pressed", isShown);
    this.#stop();
    if (isShown) this.#rank();
  }

  /** Fill the list, which is shown in place of the map if it has entries. */
  #fill(rows) {
    this.list.replaceChildren(...rows);
    this.list.hidden = find("map-rank-csv").hidden = !rows.length;
    ["map-frame", "map-text"].forEach((part) => (find(part).hidden = rows.length > 0));
  }

  #stop() {
    this.#engines.forEach((engine) => engine.end());
    this.#engines = [];
  }

  /** Simulate with the present parameters, and with a step of each in turn (`stepOf`), and list the effects. */
  async #rank() {
    const { changes } = this;
    const reals = changes.scene.parameters.filter(({ name, type, word }) => type === "real" && word >= 0 && !NOT_RANKED.test(name));
    const steps = reals.map(({ name }) => stepOf(changes, name)).filter(Boolean);
    const outputs = presentOutputs(changes);
    const words = wordsOfRun(changes.scene, outputs);
    const [{ name: first }] = steps;
    const waiting = [{ name: first, sign: 0, value: changes.valueOf(first) }, ...steps];
    const shown = { outputs, runs: [], count: waiting.length, refused: reals.length - steps.length };
    this.shown = shown;
    const work = async (engine) => {
      while (waiting.length) {
        const step = waiting.shift();
        const result = await engine.ask("study", { ...changes.values }, { names: [step.name], each: Float64Array.of(step.value), words });
        if (!result || shown !== this.shown) return;
        const { status, values } = runIn(outputs, result, 0);
        shown.runs.push({ ...step, values: status ? null : values });
        this.text.textContent = `${shown.runs.length} of ${shown.count} runs`;
      }
    };
    this.#engines = this.startEngines();
    await Promise.all(this.#engines.map(work)).catch((error) => {
      this.text.textContent = `${error.message}.`;
    });
    if (shown === this.shown && shown.runs.length === shown.count) this.#draw();
    if (shown === this.shown) this.#stop();
  }

  /** List the effects on the chosen output, if all runs are done. */
  #draw() {
    const { shown, text } = this;
    if (text.hidden || shown?.runs.length !== shown?.count) return;
    const output = shown.outputs.find(({ name }) => name === find("map-output").value);
    const valueOf = ({ values }) => values && !output.isPlace ? outputIn(values, output) : null;
    const base = valueOf(shown.runs.find(({ sign }) => sign === 0));
    const { factor, text: unit } = scaledTo(output, { ends: [base ?? 0] });
    const write = (value, count) =>
      [withMinus(output.integer ? String(value) : digits(factor * value, count)), unit].filter(Boolean).join("\u202f");
    const effects = shown.runs.filter((run) => run.sign && valueOf(run) !== null)
      .map((run) => ({ ...run, change: run.sign * (valueOf(run) - base) }))
      .sort((one, other) => Math.abs(other.change) - Math.abs(one.change));
    const some = effects.filter(({ change }) => Math.abs(change) > LEAST_SHARE * Math.abs(base));
    const [usual, zeros] = [false, true].map((wanted) => some.filter(({ isAtZero }) => isAtZero === wanted));
    const listed = base === null ? [] : [...usual.slice(0, MOST_EFFECTS), ...zeros.slice(0, MOST_AT_ZERO)];
    const largest = Math.max(...listed.map(({ change }) => Math.abs(change)));
    this.csv = csvOfRanking(this.changes, effects, output, base);
    const rows = listed.map(({ name, change, text: step }) => {
      const ends = [50, 50 + (50 * change) / largest].sort((a, b) => a - b).map((end) => `${end}%`);
      const bar = make("span", { className: `effect-bar ${change < 0 ? "less" : ""}` });
      ["--from", "--to"].forEach((key, k) => bar.style.setProperty(key, ends[k]));
      const sign = change > 0 ? "+" : "";
      const share = base ? `${sign}${withMinus(digits((100 * change) / Math.abs(base), 2))}\u202f%` : "";
      const row = make("button", { type: "button", className: "effect", title: `Vary ${name} in the map, to the right` },
        make("span", {}, this.wordsOf(name), " ", make("small", { textContent: step })), bar,
        make("span", { textContent: sign + write(change, 2) }),
        make("span", { textContent: share }));
      row.addEventListener("click", () => {
        this.#show(false);
        this.choose(name);
      });
      return row;
    });
    const atZero = rows.splice(Math.min(usual.length, MOST_EFFECTS));
    const textContent = "Parameters that are 0, for which the size of a step is arbitrary:";
    const head = make("p", { className: "note", textContent });
    this.#fill([...rows, ...(atZero.length ? [head, ...atZero] : [])]);
    const others = [some.length > listed.length && `${some.length - listed.length} more with smaller effects`,
      effects.length > some.length && `${effects.length - some.length} without any effect`,
      shown.refused && `${shown.refused} not varied, because the scene refuses both steps`].filter(Boolean).join(", ");
    const effect = "Effects of a small step of a parameter, each from a run";
    const told = `${effect}${others && `; ${others}`}. Choose one to vary it in the map, to the right.`;
    text.textContent = base === null ? `${quantityOf(output.name)} is not known ${output.isPlace ? "as a number" : "in this run"}.`
      : `${quantityOf(output.name)} = ${write(base, 4)}. ${told}`;
  }
}
