// What drives an output of the map: the parameters in the order of their effects, each from a run with this parameter changed by 1 %.

import { find, make } from "../../base/dom.js";
import { digits, withMinus } from "../../base/format.js";
import { outputIn, presentOutputs, runIn, wordsOfRun } from "./map_outputs.js";
import { quantityOf, scaledTo } from "./map_scales.js";

const STEP_SHARE = 0.01; // change of each parameter, relative to its value
const LEAST_SHARE = 1e-6; // an effect that is at most this, relative to the output, can be an error of the solver, and counts as none
const MOST_EFFECTS = 10; // largest number of parameters in the list
// parameters that are no part of the mechanism, and exponents, which change the unit of a stiffness
const NOT_RANKED = /^(solver|simulation)\.|\.exponent$/;

/**
 * Return a parameter's `name`, its `value` times 1.01, with the `sign` 1, or, if the scene refuses this value, times 0.99, with the `sign`
 * −1; undefined if the value is 0, or the scene refuses both values.
 */
function stepOf(changes, name) {
  const steps = [1, -1].map((sign) => ({ name, sign, value: changes.valueOf(name) * (1 + sign * STEP_SHARE) }));
  return steps.find(({ value }) => {
    try {
      return value !== 0 && changes.with({ [name]: value });
    } catch {
      return false;
    }
  });
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
    this.list.hidden = !rows.length;
    ["map-frame", "map-text"].forEach((part) => (find(part).hidden = rows.length > 0));
  }

  #stop() {
    this.#engines.forEach((engine) => engine.end());
    this.#engines = [];
  }

  /** Simulate with the present parameters, and with each in turn changed by 1 % (`stepOf`), and list the effects. */
  async #rank() {
    const { changes } = this;
    const reals = changes.scene.parameters.filter(({ name, type, word }) => type === "real" && word >= 0 && !NOT_RANKED.test(name));
    const steps = reals.map(({ name }) => stepOf(changes, name)).filter(Boolean);
    const outputs = presentOutputs(changes);
    const words = wordsOfRun(changes.scene, outputs);
    const [{ name: first }] = steps;
    const waiting = [{ name: first, sign: 0, value: changes.valueOf(first) }, ...steps];
    const shown = { outputs, runs: [], count: waiting.length };
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
      .map((run) => ({ name: run.name, change: run.sign * (valueOf(run) - base) }))
      .sort((one, other) => Math.abs(other.change) - Math.abs(one.change));
    const some = effects.filter(({ change }) => Math.abs(change) > LEAST_SHARE * Math.abs(base));
    const largest = Math.abs(some[0]?.change);
    this.#fill((base === null ? [] : some.slice(0, MOST_EFFECTS)).map(({ name, change }) => {
      const ends = [50, 50 + (50 * change) / largest].sort((a, b) => a - b).map((end) => `${end}%`);
      const bar = make("span", { className: `effect-bar ${change < 0 ? "less" : ""}` });
      ["--from", "--to"].forEach((key, k) => bar.style.setProperty(key, ends[k]));
      const sign = change > 0 ? "+" : "";
      const share = base ? `${sign}${withMinus(digits((100 * change) / Math.abs(base), 2))}\u202f%` : "";
      const row = make("button", { type: "button", className: "effect", title: `Vary ${name} in the map, to the right` },
        make("span", { textContent: this.wordsOf(name) }), bar, make("span", { textContent: sign + write(change, 2) }),
        make("span", { textContent: share }));
      row.addEventListener("click", () => {
        this.#show(false);
        this.choose(name);
      });
      return row;
    }));
    const others = [some.length > MOST_EFFECTS && `${some.length - MOST_EFFECTS} more with smaller effects`,
      effects.length > some.length && `${effects.length - some.length} without any`].filter(Boolean).join(", ");
    const effect = "Effects of 1\u00a0% more of a parameter, each from a run";
    const told = `${effect}${others && `; ${others}`}. Choose one to vary it in the map.`;
    text.textContent = base === null ? `${quantityOf(output.name)} is not known ${output.isPlace ? "as a number" : "in this run"}.`
      : `${quantityOf(output.name)} = ${write(base, 4)}. ${told}`;
  }
}
