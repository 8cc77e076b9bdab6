// The map: two parameters over a grid, coloured by an output at the end of each run.

import { find } from "./dom.js";
import { numberText } from "./changes.js";
import { unitText } from "./knobs.js";

const POINTS = 41; // in each direction
const RUNS = POINTS * POINTS;
const WIDTH = 4; // numbers of a run: peaks, status, output
const WORKERS = 8; // at most
// viridis of matplotlib (CC0), at equal distances
const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

/** The colour of a share from 0 to 1. */
function colourAt(share) {
  const place = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const at = Math.min(Math.floor(place), VIRIDIS.length - 2);
  return VIRIDIS[at].map((part, k) => Math.round(part + (place - at) * (VIRIDIS[at + 1][k] - part)));
}

/** The first and the last value of an axis: around the present one, within what is allowed. */
function rangeOf({ low, high }, value) {
  if (high <= 1 && low >= 0) return [Math.max(low, 0.05), Math.min(high, 0.95)];
  const reach = value === 0 ? 1 : Math.abs(value) / 2;
  return [Math.max(value - reach, low), Math.min(value + reach, high)];
}

export class GridMap {
  /** `begin` makes an engine; there is one for each processor. */
  constructor(begin, changes) {
    this.engines = Array.from({ length: Math.min(navigator.hardwareConcurrency || 1, WORKERS) }, begin);
    this.changes = changes;
    this.canvas = find("map-canvas");
    this.inputs = ["x", "y"].map((axis) => ["name", "from", "to"].map((part) => find(`map-${axis}-${part}`)));
    this.output = find("map-output");
    this.#fill();
    find("map-run").addEventListener("click", () => this.run());
    this.canvas.addEventListener("click", (event) => this.#open(event));
    this.canvas.addEventListener("pointermove", (event) => this.#tell(event));
  }

  /** The outputs that a map can have: those of the whole and of the tip. */
  get #outputs() {
    const { scene } = this.changes;
    const tip = `point[${scene.links}]`;
    return ["impact.count", "impact.last_time", "energy.total", `${tip}.x`, `${tip}.y`].flatMap((name) => {
      const column = scene.columns.find((one) => one.name === name);
      return column ? [{ ...column, label: unitText(column.unit) ? `${name}, ${unitText(column.unit)}` : name }] : [];
    });
  }

  #fill() {
    const reals = this.changes.scene.parameters.filter(({ type, word }) => type === "real" && word >= 0);
    const preferred = ["contact.restitution", "stop.restitution", "initial.angle[1]", "gravity.y"].filter((name) => this.changes.parameters.has(name));
    this.inputs.forEach(([name], k) => {
      name.append(...reals.map((parameter) => new Option(parameter.name)));
      name.value = preferred[k];
      name.addEventListener("change", () => this.#range(k));
      this.#range(k);
    });
    this.output.append(...this.#outputs.map(({ name, label }) => new Option(label, name)));
  }

  #range(k) {
    const [name, from, to] = this.inputs[k];
    const range = rangeOf(this.changes.parameters.get(name.value), this.changes.valueOf(name.value));
    [from.value, to.value] = range.map((value) => numberText(Number(value.toPrecision(4))));
  }

  /** Work the map out, drawing what is there. */
  async run() {
    try {
      const names = this.inputs.map(([name]) => name.value);
      if (names[0] === names[1]) throw new RangeError("choose two parameters");
      const axes = this.inputs.map(([name, from, to]) => {
        const [first, last] = [from, to].map((field) => this.changes.numberOf(name.value, field.value));
        return Array.from({ length: POINTS }, (_, k) => Number((first + ((last - first) * k) / (POINTS - 1)).toPrecision(12)));
      });
      const output = this.#outputs.find(({ name }) => name === this.output.value);
      this.shown = { names, axes, values: { ...this.changes.values }, output, found: Array(RUNS) };
      const began = performance.now();
      find("map-text").textContent = "";
      if (!(await this.#simulate(this.shown))) return;
      find("map-text").textContent = `${RUNS} runs in ${((performance.now() - began) / 1000).toPrecision(2)} s. Point at a run to read it, click to open it.`;
    } catch (error) {
      find("map-text").textContent = `${error.message}.`;
    }
  }

  /** Simulate the rows of a map, each in the next worker that is free; false if another map has taken its place. */
  async #simulate(shown) {
    const { names, axes, values, output } = shown;
    const words = [this.changes.scene.layout.status, output.row];
    let next = 0;
    const work = async (engine) => {
      while (next < POINTS && shown === this.shown) {
        const row = next;
        next += 1;
        const each = Float64Array.from(axes[0].flatMap((value) => [value, axes[1][row]]));
        const result = await engine.ask("study", values, { names, each, words, replaces: true });
        if (result && shown === this.shown) this.#take(result.rows, row);
      }
    };
    await Promise.all(this.engines.map(work));
    return shown === this.shown;
  }

  /** Take the outputs at the ends of the runs of a row; of a run that has failed, null. */
  #take(rows, row) {
    const { output, found } = this.shown;
    const integers = new BigInt64Array(rows.buffer);
    for (let column = 0; column < POINTS; column += 1) {
      const [status, value] = [column * WIDTH + 2, column * WIDTH + 3];
      const given = output.integer ? Number(integers[value]) : rows[value];
      found[row * POINTS + column] = integers[status] === 0n ? given : null;
    }
    this.#draw();
  }

  #draw() {
    const known = this.shown.found.filter((value) => Number.isFinite(value));
    const [least, most] = known.reduce(([a, b], value) => [Math.min(a, value), Math.max(b, value)], [Infinity, -Infinity]);
    const context = this.canvas.getContext("2d");
    const image = context.createImageData(POINTS, POINTS);
    Array.from(this.shown.found, (value, index) => {
      const [column, row] = [index % POINTS, POINTS - 1 - Math.floor(index / POINTS)];
      const colour = !Number.isFinite(value) ? [128, 128, 128, 60] : [...colourAt((value - least) / (most - least || 1)), 255];
      image.data.set(colour, 4 * (row * POINTS + column));
    });
    context.putImageData(image, 0, 0);
    [["map-least", least], ["map-most", most]].forEach(([id, value]) => {
      find(id).textContent = known.length ? numberText(Number(value.toPrecision(4))) : "";
    });
  }

  /** The run at a place of the canvas: its index, and the values of both parameters. */
  #at({ clientX, clientY }) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const place = (share) => Math.min(Math.max(Math.floor(share * POINTS), 0), POINTS - 1);
    const [column, row] = [place((clientX - left) / width), POINTS - 1 - place((clientY - top) / height)];
    const { names, axes } = this.shown;
    return { index: row * POINTS + column, given: { [names[0]]: axes[0][column], [names[1]]: axes[1][row] } };
  }

  #tell(event) {
    if (!this.shown) return;
    const { index, given } = this.#at(event);
    const value = this.shown.found[index];
    if (value === undefined) return;
    const parameters = Object.entries(given).map(([name, one]) => `${name} = ${numberText(Number(one.toPrecision(5)))}`);
    const result = value === null ? "the run fails" : `${this.shown.output.name} = ${numberText(Number(value.toPrecision(6)))}`;
    find("map-text").textContent = `${parameters.join(", ")}: ${result}`;
  }

  #open(event) {
    if (!this.shown) return;
    try {
      this.changes.replace(this.changes.with(this.#at(event).given, this.shown.values));
      find("map").close();
    } catch (error) {
      find("map-text").textContent = `${error.message}.`;
    }
  }
}
