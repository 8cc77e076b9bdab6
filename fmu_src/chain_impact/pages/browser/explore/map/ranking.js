// What drives an output of the map: the parameters in the order of their effects, each from a run with a small step of this parameter.

import { byId, make } from "../../base/dom.js";
import { digits, unitText, withMinus } from "../../base/format.js";
import { save } from "../export.js";
import { outputIn, presentOutputs, runIn, wordsOfRun } from "./map_outputs.js";
import { quantityOf, scaledTo } from "./map_scales.js";

// the step of each parameter, relative to its value or, for a value of 0, in its SI unit (RELATIVE_STEP in recording/sensitivity.py)
const STEP_SHARE = 0.01;
const ANGLE_STEP = Math.PI / 180; // step of each angle [rad]: its value depends on the direction from which it is counted
const LEAST_SHARE = 1e-6; // an effect that is at most this, relative to the output, can be an error of the solver, and counts as none
// the kinds of steps, whose effects cannot be compared with each other: `most` is the number of parameters that the list shows at first
const KINDS = {
  relative: { head: "A step of 1\u202f% of the value", most: 8 },
  angle: { head: "A step of 1°", most: 5 },
  absolute: { head: "Values of 0: a step of 0.01, as 0 has no 1\u202f%", most: 3 },
};
// parameters that are no part of the mechanism, and exponents, which change the unit of a stiffness
const NOT_RANKED = /^(solver|simulation)\.|\.exponent$/;

/**
 * Return a parameter's `name`, its `value` after a step, with the `sign` 1, or, if the scene refuses this value, after the opposite step,
 * with the `sign` −1; undefined if the scene refuses both. The `text` tells the step, by its `kind` (KINDS): 1 % of the value, 1° for an
 * angle, or for a value of 0 a hundredth of the unit.
 */
function stepOf(changes, name) {
  const { unit } = changes.parameters.get(name);
  const before = changes.valueOf(name);
  const kind = unit === "rad" ? "angle" : before === 0 ? "absolute" : "relative";
  const [step, size] = {
    angle: [ANGLE_STEP, "1°"],
    absolute: [STEP_SHARE, `${STEP_SHARE}\u202f${unitText(unit)}`.trim()],
    relative: [Math.abs(before) * STEP_SHARE, "1\u202f%"],
  }[kind];
  const upwards = kind === "relative" && before < 0 ? -1 : 1; // 1 % more of a negative value is a more negative value
  const steps = [1, -1].map((sign) => ({ name, sign, kind, value: before + sign * upwards * step, text: `+ ${size}` }));
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
   * Connect the tabs, one of which shows the list, not the map. `startEngines`: a function that starts workers; `wordsOf`: a function
   * from the name of a parameter to its words; `choose`: a function that lets the map vary a parameter.
   */
  constructor(changes, { startEngines, wordsOf, choose }) {
    Object.assign(this, { changes, startEngines, wordsOf, choose });
    [this.list, this.text] = ["map-ranking", "map-ranking-text"].map(byId);
    this.tabs = [byId("map-tab"), byId("map-rank")];
    this.tabs.forEach((tab, k) => {
      tab.addEventListener("click", () => this.#show(k === 1));
      tab.addEventListener("keydown", ({ key }) => {
        if (!["ArrowLeft", "ArrowRight"].includes(key)) return;
        this.#show(k === 0);
        this.tabs[1 - k].focus();
      });
    });
    byId("map-output").addEventListener("change", () => this.#draw());
    byId("map").addEventListener("close", ({ target }) => target.open || this.#show(false));
    byId("map-rank-csv").addEventListener("click", () =>
      save(new Blob([this.csv], { type: "text/csv" }), `${changes.scene.name}-ranking.csv`));
  }

  /** Begin the list in place of the map and of the fields that act on it only; if `isShown` is false, show the map again. */
  #show(isShown) {
    this.isWhole = false;
    this.text.hidden = !isShown;
    this.#fill([]);
    this.tabs.forEach((tab, k) => {
      tab.setAttribute("aria-selected", isShown === (k === 1));
      tab.tabIndex = isShown === (k === 1) ? 0 : -1;
    });
    byId("map").classList.toggle("with-effects", isShown);
    byId("map-title").textContent = isShown ? "Effects of single parameters" : "Map of two parameters";
    this.#stop();
    if (isShown) this.#rank();
  }

  /** Fill the list, which is shown if it has entries. */
  #fill(rows) {
    this.list.replaceChildren(...rows);
    this.list.hidden = byId("map-rank-csv").hidden = !rows.length;
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
    const output = shown.outputs.find(({ name }) => name === byId("map-output").value);
    const valueOf = ({ values }) => values && !output.isPlace ? outputIn(values, output) : null;
    const base = valueOf(shown.runs.find(({ sign }) => sign === 0));
    const { factor, text: unit } = scaledTo(output, { ends: [base ?? 0] });
    const write = (value, count) =>
      [withMinus(output.integer ? String(value) : digits(factor * value, count)), unit].filter(Boolean).join("\u202f");
    const effects = shown.runs.filter((run) => run.sign && valueOf(run) !== null)
      .map((run) => ({ ...run, change: run.sign * (valueOf(run) - base) }))
      .sort((one, other) => Math.abs(other.change) - Math.abs(one.change));
    const some = effects.filter(({ change }) => Math.abs(change) > LEAST_SHARE * Math.abs(base));
    const groups = base === null ? [] : Object.entries(KINDS).map(([wanted, { head, most }]) => {
      const all = some.filter(({ kind }) => kind === wanted);
      return { head, all, listed: this.isWhole ? all : all.slice(0, most) };
    }).filter(({ all }) => all.length);
    this.csv = csvOfRanking(this.changes, effects, output, base);
    const listed = groups.flatMap((group) => group.listed);
    const rowsOf = (group) => group.map((effect) => this.#row(effect, { base, write, output, largest: Math.abs(group[0].change) }));
    this.#fill(groups.flatMap((group) => [make("h3", { textContent: group.head }), ...rowsOf(group.listed)]));
    if (listed.length) this.#addHead(some.length > listed.length ? some.length : 0);
    const others = [effects.length > some.length && `${effects.length - some.length} without any effect`,
      shown.refused && `${shown.refused} not varied, because the scene refuses both steps`].filter(Boolean).join(", ");
    const effect = "Effects of a small step of a parameter, each from a run";
    const jumps = output.integer ? " A count jumps: a step that is a little larger may have another effect." : "";
    const told = `${effect}${others && `; ${others}`}.${jumps} Choose one to vary it in the map, to the right.`;
    text.textContent = base === null ? `${quantityOf(output.name)} is not known ${output.isPlace ? "as a number" : "in this run"}.`
      : `${quantityOf(output.name)} = ${write(base, 4)}. ${told}`;
  }

  /**
   * Return the row of an effect, a button that varies its parameter in the map. `base`: the output without a step; `write`: a function that
   * writes the `output`; `largest`: the largest change in the row's group, which the longest bar stands for.
   */
  #row({ name, sign: direction, change, text: step }, { base, write, output, largest }) {
    const ends = [50, 50 + (50 * change) / largest].sort((a, b) => a - b).map((end) => `${end}%`);
    const bar = make("span", { className: `effect-bar ${change < 0 ? "less" : ""}` });
    ["--from", "--to"].forEach((key, k) => bar.style.setProperty(key, ends[k]));
    const sign = change > 0 ? "+" : "";
    const share = base ? `${sign}${withMinus(digits((100 * change) / Math.abs(base), 2))}\u202f%` : "";
    const counts = direction > 0 ? `${write(base)} → ${write(base + change)}` : ""; // the run had the opposite step: no count is known
    const told = output.integer ? counts : share; // a count jumps, so that percents tell nothing about a larger step
    const texts = [this.wordsOf(name), step, sign + write(change, 2), told].map((textContent) => make("span", { textContent }));
    texts.splice(2, 0, bar);
    const row = make("button", { type: "button", className: "effect", title: `Vary ${name} in the map, to the right` }, ...texts);
    row.addEventListener("click", () => {
      this.#show(false);
      this.choose(name);
    });
    return row;
  }

  /** Begin the list with a legend of the bars and, if `count` is not 0, with a button that shows all effects, `count` in number. */
  #addHead(count) {
    const keys = [["", "the output grows"], ["less", "falls"]].map(([kind, words]) =>
      make("span", {}, make("i", { className: `effect-key ${kind}` }), words));
    const head = make("p", { className: "note effect-head" }, ...keys, "each group has its scale");
    const more = make("button", { type: "button", textContent: `Show all ${count}` });
    more.addEventListener("click", () => {
      this.isWhole = true;
      this.#draw();
    });
    if (count) head.append(more);
    this.list.prepend(head);
  }
}
