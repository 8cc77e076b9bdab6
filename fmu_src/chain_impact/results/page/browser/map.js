// The map: two parameters over a grid, coloured by an output at the end of each run.

import { find } from "./dom.js";
import { numberText } from "./changes.js";
import { unitText } from "./knobs.js";

const POINTS = 41; // in each direction
const RUNS = POINTS * POINTS;
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
  #engines = []; // those that are at work
  #read; // the run that a finger has pointed at

  /** `begin` makes an engine. */
  constructor(begin, changes) {
    Object.assign(this, { begin, changes });
    this.dialog = find("map");
    this.canvas = find("map-canvas");
    this.inputs = ["x", "y"].map((axis) => ["name", "from", "to"].map((part) => find(`map-${axis}-${part}`)));
    this.output = find("map-output");
    this.#fill();
    find("map-run").addEventListener("click", () => this.run());
    this.dialog.addEventListener("close", () => this.#stop());
    this.canvas.addEventListener("click", (event) => this.#choose(event));
    this.canvas.addEventListener("pointermove", (event) => this.#tell(event));
  }

  /** Show the dialog, with ranges around the present values where they are as it has put them. */
  open() {
    this.inputs.forEach(([, from, to], k) => {
      if ([from, to].every((field) => field.value === field.dataset.own)) this.#range(k);
    });
    this.dialog.showModal();
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
    [from, to].forEach((field, end) => {
      field.value = numberText(Number(range[end].toPrecision(4)));
      field.dataset.own = field.value;
    });
  }

  /** Work the map out, drawing what is there; what cannot be asked for changes nothing. */
  async run() {
    let asked;
    try {
      asked = this.#asked();
    } catch (error) {
      this.#say(`${error.message}.`);
      return;
    }
    this.#stop();
    this.#read = undefined;
    const shown = { ...asked, found: Array(RUNS), rows: 0 };
    this.shown = shown;
    const began = performance.now();
    const fault = await this.#simulate(shown).then(() => "", (error) => `${error.message}.`);
    if (shown !== this.shown) return;
    this.#stop();
    const seconds = ((performance.now() - began) / 1000).toPrecision(2);
    const done = `${RUNS} runs in ${seconds} s. Point at a run to read it, click to open it; with a finger, tap twice.`;
    this.#say(fault || (shown.rows === POINTS ? done : `Stopped after ${shown.rows} of ${POINTS} rows.`));
  }

  #say(text) {
    find("map-text").textContent = text;
  }

  /** What the fields ask for: names, values along both axes, the other changes and the output. */
  #asked() {
    const names = this.inputs.map(([name]) => name.value);
    if (names[0] === names[1]) throw new RangeError("choose two parameters");
    const axes = this.inputs.map(([name, from, to]) => {
      const [first, last] = [from, to].map((field) => this.changes.numberOf(name.value, field.value));
      return Array.from({ length: POINTS }, (_, k) => Number((first + ((last - first) * k) / (POINTS - 1)).toPrecision(12)));
    });
    const output = this.#outputs.find(({ name }) => name === this.output.value);
    return { names, axes, values: { ...this.changes.values }, output };
  }

  /** Simulate the rows of a map, each in the next worker that is free: there is one for each processor. */
  async #simulate(shown) {
    const { names, axes, values, output } = shown;
    const words = [this.changes.scene.layout.status, output.word];
    let next = 0;
    const work = async (engine) => {
      while (next < POINTS) {
        const row = next;
        next += 1;
        const each = Float64Array.from(axes[0].flatMap((value) => [value, axes[1][row]]));
        const result = await engine.ask("study", values, { names, each, words });
        if (!result) return; // the worker was ended
        this.#take(result.rows, row);
      }
    };
    this.#engines = Array.from({ length: Math.min(navigator.hardwareConcurrency || 1, WORKERS) }, this.begin);
    this.#say(`0 of ${POINTS} rows`);
    await Promise.all(this.#engines.map(work));
  }

  /** End the workers; a map that is not complete stays as it is. */
  #stop() {
    this.#engines.forEach((engine) => engine.end());
    this.#engines = [];
  }

  /** Take the outputs at the ends of the runs of a row; null of one that has failed, or that a scene would refuse. */
  #take(rows, row) {
    const { output, found } = this.shown;
    const integers = new BigInt64Array(rows.buffer);
    for (let column = 0; column < POINTS; column += 1) {
      const [status, value] = [2 * column, 2 * column + 1];
      const index = row * POINTS + column;
      const given = output.integer ? Number(integers[value]) : rows[value];
      found[index] = integers[status] === 0n && this.#isAllowed(index) ? given : null;
    }
    this.shown.rows += 1;
    this.#say(`${this.shown.rows} of ${POINTS} rows`);
    this.#draw();
  }

  /** The values of both parameters in a run. */
  #givenAt(index) {
    const { names, axes } = this.shown;
    return { [names[0]]: axes[0][index % POINTS], [names[1]]: axes[1][Math.floor(index / POINTS)] };
  }

  #isAllowed(index) {
    try {
      return Boolean(this.changes.with(this.#givenAt(index), this.shown.values));
    } catch {
      return false;
    }
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

  /** The run at a place of the canvas; undefined where there is none yet. */
  #at({ clientX, clientY }) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const place = (share) => Math.min(Math.max(Math.floor(share * POINTS), 0), POINTS - 1);
    const [column, row] = [place((clientX - left) / width), POINTS - 1 - place((clientY - top) / height)];
    const index = row * POINTS + column;
    return this.shown?.found[index] === undefined ? undefined : index;
  }

  #tell(event) {
    const index = this.#at(event);
    if (index === undefined) return;
    const value = this.shown.found[index];
    const parameters = Object.entries(this.#givenAt(index)).map(([name, one]) => `${name} = ${numberText(Number(one.toPrecision(5)))}`);
    const result = value === null ? "the run fails" : `${this.shown.output.name} = ${numberText(Number(value.toPrecision(6)))}`;
    this.#say(`${parameters.join(", ")}: ${result}`);
  }

  /** Open a run; a finger that has not pointed at it yet reads it first. */
  #choose(event) {
    const index = this.#at(event);
    if (index === undefined) return;
    const isRead = event.pointerType !== "touch" || index === this.#read;
    this.#read = index;
    if (!isRead) {
      this.#tell(event);
      return;
    }
    try {
      this.changes.replace(this.changes.with(this.#givenAt(index), this.shown.values));
      this.dialog.close();
    } catch (error) {
      this.#say(`${error.message}.`);
    }
  }
}
