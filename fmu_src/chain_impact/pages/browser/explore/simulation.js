// The runs of the page, which simulates after each change, and the line that tells how the last run ended.

import { byId, make } from "../base/dom.js";
import { readable } from "../base/format.js";
import { changesOf } from "../scene/changes.js";
import { capitalized, withBoxWalls } from "../scene/words.js";
import { keepAboveStatus, markFailing, writtenValue } from "./parameters/parameter_fields.js";
import { withControls, wordsFor } from "./parameters/main_parameters.js";
import { overlapOf, startText } from "./refused_start.js";
import { faultWords } from "./stopped_run.js";

const WAITING_TIME = 120; // [ms] after this computing time, the motion that is still shown becomes pale
// [ms] a run may take this long before the next change ends it, so that a slider shows its effect while it is dragged
const PATIENCE = 250;
// how far a run comes: it has no motion, a motion up to a fault, or no fault
const [REFUSED, STOPPED, COMPLETE] = [0, 1, 2];

export class Simulation {
  #started = -Infinity; // [ms] when the present run began; −∞ if none runs
  #nextRun = 0; // the timer that starts the next run
  #status = 0; // the status of the last run
  #sentence = ""; // the sentence that tells how the last run ended
  #reason = ""; // a further sentence on the last run, if it stopped
  // for a run that is STOPPED or REFUSED: `last` has scene, values and steps of inputs of the last run that came further, and `names` are
  // the parameters with whose change the runs began to fail
  #failures = [REFUSED, STOPPED].map(() => ({ names: [] }));
  #reach = REFUSED; // how far the last run came
  #notice = ""; // the sentence on a fault in the address, which is shown until something changes

  /**
   * `beginEngine` is a function that starts an engine for the present scene, `choice` the chosen outputs. `show(parts, about, overlap)`
   * shows the parts of a motion (null if there is none) or, for a refused start, the result of `overlapOf`. `about` has the scene, the
   * changes `values` and `inputSteps`, and the result of `changesInWords`.
   */
  constructor(beginEngine, changes, choice, show) {
    Object.assign(this, { beginEngine, changes, choice, show });
  }

  /** Simulate at once and after each change; start another engine when another scene is opened. */
  begin() {
    this.engine = this.beginEngine();
    this.changes.onOpen(() => {
      this.engine.end();
      this.engine = this.beginEngine();
    });
    this.changes.onChange(() => {
      this.#notice = "";
      this.soon();
    });
    this.#tell();
    byId("caption").textContent = "Simulating…"; // this text is shown until the first motion is drawn
    this.soon();
  }

  /** Simulate with the present parameters as soon as the present run has ended or has lasted for PATIENCE, or at once without a run. */
  soon() {
    byId("stage").ariaBusy = "true";
    clearTimeout(this.#nextRun);
    const left = this.#started + PATIENCE - performance.now();
    if (left > 0) this.#nextRun = setTimeout(() => this.#run(), left);
    else this.#run();
  }

  /** Simulate with the present parameters, and show the motion, unless a newer run has replaced this one. */
  async #run() {
    const { changes, choice } = this;
    const { scene, values, inputSteps } = changes;
    this.#started = performance.now();
    this.#nextRun = 0;
    const words = changesInWords(changes);
    const waiting = setTimeout(() => document.body.classList.add("computing"), WAITING_TIME);
    const result = await this.engine
      .ask("motion", changes.values, { replaces: true, curves: choice.names, inputSteps: changes.inputSteps }, (share) =>
        byId("stage").style.setProperty("--share", `${100 * share}%`))
      .catch((error) => ({ parts: null, fault: `The solver cannot work in this browser: ${error.message}.` }));
    clearTimeout(waiting);
    if (!result) return;
    this.#started = -Infinity;
    document.body.classList.remove("computing");
    document.body.classList.toggle("stale", !result.parts);
    this.#keepFailures({ scene, values, inputSteps }, result);
    this.#status = result.status;
    [this.#sentence, this.#reason] = result.fault || this.#reach !== STOPPED
      ? [result.fault ?? this.faultOf(result, result.parts, values), ""] : this.#stopText(result, values);
    this.#tell();
    const isRefused = !result.parts && !result.fault;
    const overlap = isRefused ? this.#overlapOf(result, values) : undefined;
    const { names } = this.#failures[REFUSED];
    if (isRefused && names.length === 1) markFailing(names[0], this.#inWords(startText(result, scene, overlap)));
    this.show(result.parts, { ...words, scene, values, inputSteps }, overlap);
    if (isRefused) keepAboveStatus();
    if (this.#nextRun) this.soon();
    else byId("stage").ariaBusy = "false";
  }

  /**
   * Give recordings of the present scene the curves of the chosen outputs: run each recording again that lacks a chosen output. Return
   * whether any recording lacked one.
   */
  async addCurves(recordings) {
    const { engine, choice: { names }, changes: { scene } } = this;
    const lacking = recordings.filter(({ scene: own, outputs }) =>
      own === scene && !names.every((name) => outputs.curves.some((curve) => curve.name === name)));
    await Promise.all(lacking.map(async (recording) => {
      const { values, inputSteps } = recording;
      const result = await engine.ask("pinned", values, { curves: names, inputSteps });
      if (result?.parts) recording.outputs = result.parts.outputs;
    }));
    return lacking.length > 0;
  }

  /** Simulate the present scene with each of several changes; return those with a motion, with `parts` and `about` as `show` gets them. */
  async motionsOf(all) {
    const { engine, choice: { names: curves }, changes: { scene } } = this;
    const motions = await Promise.all(all.map(async ({ values, inputSteps, ...given }) => {
      const about = { ...changesInWords(changesOf(scene, values, inputSteps)), scene, values, inputSteps };
      return { ...given, about, parts: (await engine.ask("pinned", values, { curves, inputSteps }).catch(() => null))?.parts };
    }));
    return motions.filter(({ parts }) => parts);
  }

  /** Return a sentence on the fault of a run with `values`; "" without one. `hasMotion`: whether the run has a motion up to the fault. */
  faultOf(run, hasMotion, values) {
    const { scene } = this.changes;
    if (run.status === 0) return "";
    const text = run.status === SHARED.kernel.STARTS_INSIDE_WALL
      ? this.#inWords(startText(run, scene, this.#overlapOf(run, values))) : this.#wordsOf(run).filter(Boolean).join(": ");
    return `The simulation ${hasMotion ? `stopped at t = ${timeOf(run)}` : "cannot start"}: ${text}.`;
  }

  /** Return the result of `faultWords` in the words of the controls. */
  #wordsOf(run) {
    return faultWords(run, this.changes).map((text) => this.#inWords(text));
  }

  /**
   * Return two texts for a run with `values` that stopped. The first tells when, and with which changes it began to stop or, without any,
   * what to change; the second why it stopped and, with changes, what to change. Without changes and advice, the first tells why.
   */
  #stopText(run, values) {
    const { changes } = this;
    const { names } = this.#failures[STOPPED];
    const [cause, advice, part] = this.#wordsOf(run);
    const reason = [cause, part].filter(Boolean).join(": ");
    const wordsOf = wordsFor(changes);
    const textAt = (name) => writtenValue(changes, name, changes.valueOf(name, values));
    const culprits = names.map((name) => `${wordsOf(name)} = ${textAt(name)}`).join(", ");
    const stopped = `the simulation stopped at t = ${timeOf(run)}`;
    const sentences = (...all) => all.filter(Boolean).map((text) => `${capitalized(text)}.`).join(" ");
    if (culprits) return [`With ${culprits}, ${stopped}.`, sentences(reason, advice)];
    return advice ? [sentences(`${stopped}: ${advice}`), sentences(reason)] : [sentences(`${stopped}: ${reason}`), ""];
  }

  #overlapOf(run, values) {
    return overlapOf(run, this.changes.scene, (name) => this.changes.valueOf(name, values));
  }

  #inWords(sentence) {
    return withControls(withBoxWalls(sentence, this.changes.valueOf), this.changes);
  }

  /** Show a sentence on a fault in the address, `notice`, until something changes. */
  notify(notice) {
    this.#notice = notice;
    this.#tell();
  }

  #tell() {
    const all = [this.#notice, this.#sentence].filter(Boolean).join(" ");
    byId("status").classList.add("begun");
    byId("status").textContent = readable(all);
    byId("status").hidden = !all;
    if (this.#status === SHARED.kernel.FRICTION_WITH_RIGID_WALLS) byId("status").append(" ", this.#withoutFriction());
    if (all && this.#reach !== COMPLETE) this.#offerUndo(this.#failures[this.#reach]);
    if (!all || !this.#reason) return;
    const reason = make("p", { textContent: readable(this.#reason) });
    byId("status").append(make("details", {}, make("summary", { textContent: "Why, and what may help" }), reason));
  }

  /**
   * Keep a `run` that came further than a failure as the last one before it; else keep the names of the parameters with whose change the
   * runs began to fail, or, after these changes were taken back, of all parameters that differ from the last run before.
   */
  #keepFailures(run, { parts, status }) {
    this.#reach = parts ? (status ? STOPPED : COMPLETE) : REFUSED;
    this.#failures.forEach((failure, reach) => {
      if (this.#reach > reach) Object.assign(failure, { last: run, names: [] });
      const { last, names } = failure;
      const present = last?.scene === run.scene ? Object.keys({ ...last.values, ...run.values }) : [];
      const different = present.filter((name) => last.values[name] !== run.values[name]);
      const kept = names.filter((name) => different.includes(name));
      failure.names = kept.length ? kept : different;
    });
  }

  /** Offer to take back the changes with which the runs began to fail, and name their parameters; or to undo an edit that is refused. */
  #offerUndo({ last, names }) {
    const { changes } = this;
    const isEdited = this.#reach === REFUSED && last && last.scene !== changes.scene;
    if (!names.length && !isEdited) return;
    const textContent = isEdited ? "Undo the edit" : `Undo the change of ${names.map(wordsFor(changes)).join(", ")}`;
    const button = make("button", { type: "button", className: "action", textContent });
    button.addEventListener("click", () => (isEdited ? byId("undo").click() : changes.takeBack(names, last)));
    byId("status").append(" ", button);
  }

  /** Return a button that sets all coefficients of friction at walls to 0, for a scene with rigid walls and friction, which cannot run. */
  #withoutFriction() {
    const { changes } = this;
    const button = make("button", { type: "button", className: "action", textContent: "Set the friction of walls to 0" });
    const ofWalls = ({ filePath }) => filePath?.[0] === "contact" && filePath.at(-1).endsWith("friction");
    const names = changes.scene.parameters.filter(ofWalls).map(({ name }) => name);
    button.addEventListener("click", () => changes.set(Object.fromEntries(names.map((name) => [name, 0]))));
    return button;
  }
}

/** Return the time that a run has reached as text. */
function timeOf({ reached }) {
  return `${Number(reached.toPrecision(6))}\u202fs`;
}

/**
 * Return `changes` as `changed`: words for a parameter → text of its value or, for an input with steps, of all its values. The function
 * `unchangedText` gives the text of any other parameter by its words; it makes these texts when it is first called.
 */
function changesInWords(changes) {
  const { scene, values, inputSteps } = changes;
  const wordsOf = wordsFor(changes);
  const texts = new Map(Object.entries(values).map(([name, value]) => [name, writtenValue(changes, name, value)]));
  for (const [name, steps] of Object.entries(inputSteps)) {
    const later = steps.map(([time, value]) => `${writtenValue(changes, name, value)} from ${time} s`);
    texts.set(name, [texts.get(name), ...later].filter(Boolean).join(", "));
  }
  let others;
  return {
    changed: new Map([...texts].map(([name, text]) => [wordsOf(name), text])),
    unchangedText: (words) => (others ??= unchangedInWords(changesOf(scene, values, inputSteps))).get(words),
  };
}

/** Return the texts of the values of all parameters without a change: words for a parameter → text. */
function unchangedInWords(changes) {
  const wordsOf = wordsFor(changes);
  const names = [...changes.parameters.keys()].filter((name) => !changes.isChanged(name));
  return new Map(names.map((name) => [wordsOf(name), writtenValue(changes, name, changes.valueOf(name))]));
}
