// The map: an output at the end of each run, shown as a colour over a grid of the values of two parameters.

import { byId } from "../../base/dom.js";
import { numberText, readable } from "../../base/format.js";
import { presentlyShown } from "../parameters/parameter_fields.js";
import { mainParametersOf, withControls, wordsFor } from "../parameters/main_parameters.js";
import { colourScale } from "./map_colours.js";
import { MapDrawing } from "./map_drawing.js";
import { connectFiles } from "./map_files.js";
import { limitIn } from "./map_limit.js";
import { mainOutput, outputIn, outputsOf, presentOutputs, runIn, takeOutput, wordsOfRun } from "./map_outputs.js";
import { MapPlace } from "./map_place.js";
import { firstRun, runAt } from "./map_pointing.js";
import { COARSE_POINTS, completed, hasAreaOf, packedMap, POINTS, rowOrder, unpackedMap, valuesAt } from "./map_rows.js";
import { areaOf, axisScale, isLogarithmic, limitOf, quantityOf, rangeOf, refused, titleOf } from "./map_scales.js";
import { doneText, runText } from "./map_text.js";
import { Ranking } from "./ranking.js";

const WORKERS = 8; // largest number of workers that compute a map
const PREVIEW_DELAY = 300; // [ms] after the last change of another parameter, a preview beside the motion is simulated again

export class GridMap {
  #engines = []; // the workers that are in use
  #touched; // the run that a finger has touched once
  #chosen; // the run that the reader points at, or that the arrow keys have reached
  #opened; // the run that the reader has opened, until something changes
  #nextPreview = 0; // the timer that starts the next preview
  #hasRing = false; // whether the present run is in the map
  #isLeft = false; // whether the reader has left the map for one of its runs
  #refuses = false; // whether the dialog's text tells that the fields' values are refused

  /** Make the map; `begin` is a function that starts an engine (a worker with a kernel). */
  constructor(begin, changes) {
    Object.assign(this, { begin, changes });
    this.dialog = byId("map");
    this.place = new MapPlace(this.dialog);
    this.canvas = byId("map-canvas");
    this.drawing = new MapDrawing(this.canvas, byId("map-scales"), byId("map-frame"));
    this.inputs = ["x", "y"].map((axis) => ["name", "from", "to"].map((part) => byId(`map-${axis}-${part}`)));
    [this.output, this.scaleKind, this.limitField] = ["map-output", "map-scale", "map-limit"].map(byId);
    this.inputs.forEach(([name], k) => name.addEventListener("change", () => this.#range(k)));
    this.#fill();
    changes.onOpen(() => this.#fill());
    changes.onChange(() => this.#follow());
    byId("map-run").addEventListener("click", () => (this.#isRunning ? this.#stop() : this.run()));
    this.inputs.flat().forEach((field) => field.addEventListener("change", () => this.#preview()));
    this.output.addEventListener("change", () => (this.shown ? this.#recolour() : this.#preview()));
    [this.scaleKind, this.limitField].forEach((field) => field.addEventListener("change", () => this.shown && this.#recolour()));
    connectFiles(this);
    new ResizeObserver(() => this.shown && this.#drawScales()).observe(byId("map-frame"));
    this.dialog.addEventListener("close", () => this.dialog.open || this.#stop());
    const choose = (name) => {
      this.inputs[0][0].value = name;
      this.inputs[0][0].dispatchEvent(new Event("change"));
    };
    new Ranking(changes, { startEngines: () => this.#startEngines(), wordsOf: (name) => this.wordsOf(name), choose });
    this.canvas.addEventListener("click", (event) => this.#choose(event));
    this.canvas.addEventListener("pointermove", (event) => this.#mark(runAt(event, this.canvas, this.shown)));
    this.canvas.addEventListener("pointerleave", ({ pointerType }) => pointerType === "mouse" && this.#mark(undefined));
    this.canvas.addEventListener("keydown", (event) => this.#press(event));
  }

  /**
   * Show the dialog, or close it if it stands beside the motion. Ranges of a map with all its points, or with an opened run, stay.
   * Otherwise, ranges that the reader has not changed follow from the present values again (`rangeOf`).
   */
  open() {
    if (this.place.isBeside) return this.dialog.close();
    const isKept = this.shown?.points === POINTS || this.#isLeft;
    this.#leave(false);
    this.inputs.forEach(([, from, to], k) => {
      if (!isKept && [from, to].every((field) => field.value === field.dataset.own)) this.#range(k);
    });
    this.place.show();
    if (this.shown) this.#drawScales();
    this.#preview();
  }

  /** Beside the motion, move the ring with a change; if the change is of another parameter, simulate a preview again soon. */
  #follow() {
    this.#opened = undefined;
    clearTimeout(this.#nextPreview);
    if (!this.place.isBeside || !this.shown) return;
    this.#drawScales();
    this.#tell();
    const isOld = this.shown.points === COARSE_POINTS && !Object.keys(this.changes.inputSteps).length && !this.#isOfPresent();
    if (isOld) this.#nextPreview = setTimeout(() => this.place.isBeside && this.#preview(), PREVIEW_DELAY);
  }

  /** Note whether the reader has left the map for one of its runs: then the button that opens the map tells the way back. */
  #leave(isLeft) {
    this.#isLeft = isLeft;
    byId("map-back").hidden = !isLeft;
  }

  /** Return whether runs of a map with all its points are under way. */
  get #isRunning() {
    return this.#engines.length > 0 && this.shown?.points === POINTS;
  }

  #showState() {
    byId("map-run").textContent = this.#isRunning ? "Stop" : `Simulate ${POINTS} × ${POINTS} runs`;
  }

  /** Show a preview, a map of few runs for the present fields, unless the shown map has all its points and fits these fields. */
  #preview() {
    if (this.shown?.points === POINTS && this.#fitsFields()) {
      this.#refuse(false);
      this.#tell();
    } else {
      this.run(COARSE_POINTS);
    }
  }

  /** Return whether the shown map has the parameters and the ends of the axes that the fields ask for. */
  #fitsFields() {
    try {
      return areaOf(this.shown) === areaOf(this.#requestOf(POINTS));
    } catch {
      return false; // the fields are refused
    }
  }

  /**
   * Fill the lists with the parameters that a map can vary and the outputs that it can show, and choose usual parameters and outputs; stop
   * and remove the map of another scene.
   */
  #fill() {
    this.#stop();
    this.#leave(false);
    this.#refuse(false);
    this.shown = undefined;
    this.drawing.clear();
    byId("map-files").hidden = true;
    this.#say("");
    const reals = this.changes.scene.parameters.filter(({ type, word }) => type === "real" && word >= 0);
    this.wordsOf = wordsFor(this.changes);
    const restitutions = mainParametersOf(this.changes).map(({ name }) => name).filter((name) => name.endsWith("restitution"));
    const { scene: { links, contactPoints, file: { chain } }, parameters } = this.changes;
    const isBall = links === 1 && contactPoints.length === 1 && chain.base === "free"; // its angle hardly matters
    const preferred = [...restitutions.slice(0, 1), ...(isBall ? ["initial.y"] : []), "initial.angle[1]", "gravity.y"]
      .filter((name) => parameters.has(name));
    this.inputs.forEach(([name], k) => {
      name.replaceChildren(...reals.map((parameter) => new Option(this.wordsOf(parameter.name), parameter.name)));
      name.value = preferred[k];
      this.#range(k);
    });
    const outputs = outputsOf(this.changes.scene);
    this.output.replaceChildren(...outputs.map(({ name, unit }) =>
      new Option(titleOf(quantityOf(name), name.startsWith("point") ? unit : ""), name)));
    this.output.value = mainOutput(this.changes, outputs).name;
    if (this.place.isBeside) this.#preview();
  }

  /** Return the map with all its points as data of a saved page; undefined for any other map. */
  get saved() {
    return this.shown?.points === POINTS ? packedMap(this.shown) : undefined;
  }

  /** Show the map of a saved page, of which the fields tell the axes, without simulating its runs. */
  restore(saved) {
    this.shown = unpackedMap(saved);
    this.inputs.forEach((_, k) => this.#tellUnit(k));
    Object.assign(this.canvas, { width: 2 * (POINTS - 1), height: 2 * (POINTS - 1) });
    this.#draw();
  }

  /** Tell the unit of an axis; return the factor from the SI unit to it. */
  #tellUnit(k) {
    const { factor, text } = presentlyShown(this.changes, this.inputs[k][0].value);
    byId(`map-${"xy"[k]}-unit`).textContent = text && `in ${text}`;
    return factor;
  }

  #range(k) {
    const [name, from, to] = this.inputs[k];
    const parameter = this.changes.parameters.get(name.value);
    const range = rangeOf(parameter, this.changes.valueOf(name.value));
    const factor = this.#tellUnit(k);
    [from, to].forEach((field, end) => {
      const round = Number((factor * range[end]).toPrecision(2));
      const isAllowed = round >= factor * parameter.low && round <= factor * parameter.high;
      field.value = numberText(isAllowed ? round : Number((factor * range[end]).toPrecision(4)));
      field.dataset.own = field.value;
    });
  }

  /** Note whether the values of the fields are refused. If they are, the map still shows earlier values, and is drawn pale. */
  #refuse(isRefused) {
    this.#refuses = isRefused;
    byId("map-frame").classList.toggle("earlier", isRefused);
  }

  /** Compute the map with `points` values of each parameter, and draw it as it grows. If the fields have a fault, only tell the fault. */
  async run(points = POINTS) {
    let request;
    this.#refuse(false);
    try {
      request = this.#requestOf(points);
    } catch (error) {
      this.#refuse(true);
      this.#say(`${error.message}.`, true);
      return;
    }
    this.#stop();
    this.#touched = this.#chosen = this.#opened = undefined;
    // runs: for each run the values of all outputs, so that another colour needs no runs; null for a run that fails; known: present values
    // of both parameters, as text → their run
    const coarse = this.shown?.points === COARSE_POINTS && hasAreaOf(this.shown, request) ? this.shown : undefined;
    const shown = { ...request, points, coarse, runs: Array(points * points), faults: new Map(), known: new Map(), rows: 0 };
    this.shown = shown;
    Object.assign(this.canvas, { width: 2 * (points - 1), height: 2 * (points - 1) });
    this.#draw();
    shown.began = performance.now();
    shown.fault = await this.#simulate(shown).then(() => "", (error) => `${error.message}.`);
    shown.seconds = (performance.now() - shown.began) / 1000;
    if (shown !== this.shown) return;
    this.#stop();
    this.#tell();
  }

  /** Tell about the runs of the shown map after their end, but not while the values of the fields are refused. */
  #tell() {
    const { shown } = this;
    if (this.#refuses || shown.seconds === undefined) return;
    if (this.#opened !== undefined) return this.#describe(this.#opened, "Present run: ");
    const hasSteps = Object.keys(this.changes.inputSteps).length > 0;
    this.#say(doneText(shown, this.limitField, { hasRing: this.#hasRing, hasSteps, isOfPresent: this.#isOfPresent() }));
  }

  /** Show the same runs with the chosen output as their colour. */
  #recolour() {
    this.#opened = undefined;
    this.#draw();
    this.#tell();
  }

  #say(text, isFault = false) {
    Object.assign(byId("map-text"), { textContent: readable(text), className: isFault ? "fault" : "" });
  }

  /** Return what the fields ask for: `names` of two parameters, `axes` with their values, all changed `values`, and all `outputs`. */
  #requestOf(points) {
    const names = this.inputs.map(([name]) => name.value);
    this.inputs.flat().forEach((field) => field.setCustomValidity(""));
    if (names[0] === names[1]) throw refused(this.inputs[1][0], "choose two parameters");
    const axes = this.inputs.map(([name, from, to]) => {
      const [first, last] = [from, to].map((field) => limitOf(this.changes, name.value, field, this.wordsOf(name.value)));
      const { valueAt } = axisScale(first, last, isLogarithmic(name.value));
      return Array.from({ length: points }, (_, k) => Number(valueAt(k / (points - 1)).toPrecision(12)));
    });
    return { names, axes, values: { ...this.changes.values }, outputs: presentOutputs(this.changes) };
  }

  /** Simulate the present values, then the rows of a map, each in the next free worker. Each processor has a worker, up to WORKERS. */
  async #simulate(shown) {
    const { names, axes, values, outputs, points, known } = shown;
    const words = wordsOfRun(this.changes.scene, outputs);
    const rows = rowOrder(points);
    const work = async (engine) => {
      while (rows.length) {
        const row = rows.shift();
        const each = Float64Array.from(axes[0].flatMap((value) => [value, axes[1][row]]));
        const result = await engine.ask("study", values, { names, each, words });
        if (!result) return; // there is no result because the worker was ended
        if (shown === this.shown) this.#store(result, row);
      }
    };
    const engines = this.#startEngines();
    this.#engines = engines;
    this.#showState();
    if (!this.#refuses) this.#say(`0 of ${points} rows`);
    const present = names.map((name) => this.changes.valueOf(name));
    const run = await engines[0].ask("study", values, { names, each: Float64Array.from(present), words });
    if (!run) return;
    known.set(present.join(), runIn(outputs, run, 0));
    await Promise.all(engines.map(work));
  }

  #startEngines() {
    return Array.from({ length: Math.min(navigator.hardwareConcurrency || 1, WORKERS) }, this.begin);
  }

  /** End the workers; a map that is not complete stays as it is. */
  #stop() {
    this.#engines.forEach((engine) => engine.end());
    this.#engines = [];
    this.#showState();
  }

  /**
   * Store the outputs of the runs in a row of the map, from the `result` of the study of this row. A run that failed, or whose values the
   * scene refuses, has no outputs; the reason is stored.
   */
  #store(result, row) {
    const { outputs, runs, faults, points, began } = this.shown;
    for (let column = 0; column < points; column += 1) {
      const index = row * points + column;
      const { status, values } = runIn(outputs, result, column);
      const fault = this.#refusalOf(index) || (status ? SHARED.kernel.STATUS_TEXT[status] : "");
      if (fault) faults.set(index, fault);
      runs[index] = fault ? null : values;
    }
    this.shown.rows += 1;
    const left = ((performance.now() - began) * (points / this.shown.rows - 1)) / 1000;
    if (!this.#refuses) this.#say(`${this.shown.rows} of ${points} rows, about ${Math.ceil(left)} s left`);
    this.#draw();
  }

  /** Return why the scene refuses the values of a run; "" if it allows them. */
  #refusalOf(index) {
    try {
      this.changes.with(valuesAt(this.shown, index), this.shown.values);
      return "";
    } catch (error) {
      return withControls(error.message, this.changes);
    }
  }

  #draw() {
    const { shown } = this;
    takeOutput([shown.coarse, shown].filter(Boolean), this.output.value);
    const results = completed(shown);
    const present = [...shown.known.values()].filter(({ status }) => !status).map(({ values }) => outputIn(values, shown.output));
    shown.scale = colourScale([...results, ...present], shown.output.integer, this.scaleKind.value);
    this.drawing.drawRuns(shown, results);
    byId("map-files").hidden = shown.points !== POINTS || shown.rows === 0;
    this.#drawScales();
  }

  #drawScales() {
    const { names, values } = this.shown;
    const varied = Object.fromEntries(names.filter((name) => name.endsWith(".exponent")).map((name) => [name, "exponent"]));
    const shownOf = (name) => presentlyShown(this.changes, name, { ...values, ...varied });
    const units = names.map((name) => ({ ...shownOf(name), isLogarithmic: isLogarithmic(name) }));
    const at = names.map((name) => this.changes.valueOf(name));
    const run = this.shown.known.get(at.join());
    const present = this.#isOfPresent() ? { at, value: run && !run.status ? outputIn(run.values, this.shown.output) : null } : null;
    const inWords = { ...this.shown, names: names.map((name) => this.wordsOf(name)) };
    this.#hasRing = this.drawing.drawScales(inWords, units, { present, chosen: this.#chosen, limit: limitIn(this.limitField, this.shown) });
  }

  /** Return whether all changed values, except those of the map's two parameters, equal those of the map; false if inputs have steps. */
  #isOfPresent() {
    const others = (values) => JSON.stringify(Object.entries(values).filter(([name]) => !this.shown.names.includes(name)).sort());
    return !Object.keys(this.changes.inputSteps).length && others(this.shown.values) === others(this.changes.values);
  }

  /** Go from run to run with the arrow keys, beginning with the present run; open a run with Enter. */
  #press(event) {
    const [right, up] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [];
    if (!this.shown || (right === undefined && event.key !== "Enter")) return;
    event.preventDefault();
    const { points } = this.shown;
    if (event.key === "Enter") return this.#open(this.#chosen);
    const [column, row] = this.#chosen === undefined ? firstRun(this.shown, this.changes, this.#hasRing)
      : [this.#chosen % points + right, Math.floor(this.#chosen / points) + up].map((number) => Math.min(Math.max(number, 0), points - 1));
    this.#mark(row * points + column);
  }

  /** Mark a run, and tell its values; without an index, remove the mark. */
  #mark(index) {
    if (!this.shown || index === this.#chosen) return;
    this.#chosen = index;
    if (index === undefined) this.#tell();
    else this.#describe(index);
    this.#drawScales();
  }

  #describe(index, before = "") {
    if (this.shown?.results[index] === undefined) return;
    this.#say(before + runText(this.shown, index, this.changes, this.wordsOf));
  }

  /** Open a run, that is take over its values, beside which the map stays if it has room; a finger's first touch only shows the values. */
  #choose(event) {
    const index = runAt(event, this.canvas, this.shown);
    if (index === undefined) return;
    const isSecond = event.pointerType !== "touch" || index === this.#touched;
    this.#touched = index;
    if (isSecond) this.#open(index);
    else this.#mark(index);
  }

  #open(index) {
    if (this.shown.results[index] === undefined) return;
    const values = this.shown.runs[index]; // null if the run has failed
    if (values) this.shown.known.set(Object.values(valuesAt(this.shown, index)).join(), { values });
    try {
      // the inputs get no steps, because the runs of a map have constant inputs
      this.changes.replace(this.changes.with(valuesAt(this.shown, index), this.shown.values), {});
      this.#opened = index;
      this.#tell();
      this.#leave(this.place.makeRoom());
    } catch (error) {
      this.#say(`${error.message}.`, true);
    }
  }
}
