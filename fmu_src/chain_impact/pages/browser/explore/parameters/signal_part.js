// The part of the panel for a signal: its words, a small drawing of its course over the run, and its numbers, which the reader can fold.

import { make } from "../../base/dom.js";
import { textWithUnit } from "../../base/format.js";
import { shownIn } from "../../scene/angles.js";
import { inputText, signalText } from "../../scene/words.js";
import { attempt, explain, presentlyShown, refusal, resetButton, valueField } from "./parameter_fields.js";

// space above and below the curve, over the difference of its largest and smallest value
const [SPACE_AT_CURVE, SPACE_TO_DRAG] = [0.1, 0.4];
const DRAG_PARTS = 200; // a dragged point is rounded to about this part of the drawing
const SIGNAL_SVG = '<svg viewBox="0 0 1 1" preserveAspectRatio="none"><path class="zero"/><path class="course"/></svg>';

/** Return a value rounded to the power of ten that is at most `step`. */
function roundedForDrag(value, step) {
  const power = 10 ** -Math.floor(Math.log10(step));
  return Number((Math.round(value * power) / power).toPrecision(12));
}

/** Return, for each step of a signal, the names of the parameters for its time and its value; [] for a signal without steps. */
export function stepsOfSignal({ parameters }, signal) {
  const namesOf = (key) => [...parameters.keys()].filter((name) => name.startsWith(`signal.${signal}.${key}[`));
  const values = namesOf("value");
  return namesOf("time").map((time, k) => ({ time, value: values[k] }));
}

/** Return the row of a step: fields for its time and its value, and a function that brings them up to date. */
function stepRow(changes, signal, names) {
  const row = make("div", { className: "main-parameter step" });
  const parts = [names.time, names.value].map((name) => {
    const { field, refresh } = valueField(changes, changes.parameters.get(name));
    const [unit, reset] = [make("small"), resetButton(changes, name, field)];
    field.id = `main-${name}`;
    row.append(field, unit, reset);
    return () => {
      refresh();
      field.setAttribute("aria-label", `${signalText(signal, name.slice(`signal.${signal}.`.length))}, ${name}`);
      unit.textContent = presentlyShown(changes, name).text;
      reset.classList.toggle("shown", changes.isChanged(name));
    };
  });
  row.prepend(make("span", { textContent: "from" }));
  row.append(refusal());
  return { row, refresh: () => {
    parts.forEach((refresh) => refresh());
    explain(row);
  } };
}

/** A drawing of a signal over the run, with the present time and, for a signal with steps, a point for each, which the reader can drag. */
class SignalDrawing {
  constructor(changes, inputs, steps) {
    Object.assign(this, { changes, inputs, steps });
    this.element = make("div", { className: "signal-drawing", innerHTML: SIGNAL_SVG });
    this.element.setAttribute("aria-hidden", "true");
    this.now = make("span", { className: "signal-now" });
    this.points = steps.map((names, k) => this.#point(names, k));
    this.element.append(this.now, ...this.points);
  }

  #point(names, k) {
    const point = make("span", { className: "signal-point", title: "Drag to change time and value" });
    point.addEventListener("pointerdown", ({ pointerId }) => {
      point.setPointerCapture(pointerId);
      this.dragged = point;
    });
    point.addEventListener("pointermove", (event) => point === this.dragged && this.#drag(event, names, k));
    ["pointerup", "pointercancel"].forEach((end) => point.addEventListener(end, () => {
      this.dragged = undefined;
      this.show();
    }));
    point.addEventListener("click", (event) => event.preventDefault()); // a drag does not fold the part
    return point;
  }

  /** Give step `k` the time and the value at the pointer; its time stays between those of its neighbours, and within the run. */
  #drag({ clientX, clientY }, { time, value }, k) {
    const { changes, steps, run, low, high } = this;
    const { left, top, width, height } = this.element.getBoundingClientRect();
    const share = (part) => Math.min(Math.max(part, 0), 1);
    const [stop, { factor }] = [run.time.at(-1), presentlyShown(changes, value)];
    const timeOf = (other, none) => (steps[other] ? changes.valueOf(steps[other].time) : none);
    const least = stop / DRAG_PARTS;
    const at = Math.max(Math.min(roundedForDrag(stop * share((clientX - left) / width), least), timeOf(k + 1, Infinity) - least),
      timeOf(k - 1, -least) + least);
    const to = factor * (high - (high - low) * share((clientY - top) / height));
    attempt(changes, document.getElementById(`main-${value}`), () => changes.set({
      [time]: Number(at.toPrecision(12)),
      [value]: roundedForDrag(to, factor * (high - low) / DRAG_PARTS) / factor,
    }));
  }

  /** Return the least and the largest value of the signal in the run and, if it has steps, of 0 and the values of the steps, too. */
  get #ends() {
    const given = this.steps.map(({ value }) => this.changes.valueOf(value));
    const all = [...this.curves.map(({ values }) => values), given.length ? [0, ...given] : []];
    return [Math.min, Math.max].map((end) => all.flatMap((values) => Array.from(values)).reduce((one, other) => end(one, other)));
  }

  /** Return the range of the signal as text. */
  get text() {
    const [{ unit }] = this.curves;
    const [low, high] = [...new Set(this.#ends)].map((value) => textWithUnit(value, shownIn({ unit }), 3));
    return high ? `${low.replace(/\u202f.*/, "")} … ${high}` : low;
  }

  /** Draw the signal in a run, by default in the run that is drawn. */
  show(run = this.run) {
    this.curves = run?.curves.filter(({ name }) => this.inputs.includes(name)) ?? [];
    if (!this.curves.length) return;
    this.run = run;
    const [low, high] = this.#ends;
    const room = (this.steps.length ? SPACE_TO_DRAG : SPACE_AT_CURVE) * (high - low) || Math.abs(high) || 1;
    if (!this.dragged) Object.assign(this, { low: low - room, high: high + room });
    const stop = run.time.at(-1);
    const yOf = (value) => (this.high - value) / (this.high - this.low);
    const [zero, course] = this.element.querySelectorAll("path");
    zero.setAttribute("d", `M0 ${yOf(0)}H1`);
    const placesOf = ({ values }) => Array.from(run.time, (time, k) => `${(time / stop).toFixed(4)} ${yOf(values[k]).toFixed(3)}`);
    course.setAttribute("d", this.curves.map((curve) => `M${placesOf(curve).join("L")}`).join(""));
    this.points.forEach((point, k) => {
      const { time, value } = this.steps[k];
      const at = this.changes.valueOf(time) / stop;
      point.hidden = at > 1;
      Object.assign(point.style, { left: `${100 * at}%`, top: `${100 * yOf(this.changes.valueOf(value))}%` });
    });
  }
}

/**
 * Return the part of the panel for a signal, with functions that bring it up to date: `refresh` after a change, and `follow` at another
 * time [s], or for another run with its inputs. `rows`: the rows of the signal's numbers, unless it has steps.
 */
export function signalPart(changes, signal, rows, isOpen) {
  const inputs = changes.scene.file.signals[signal].input;
  const [words, range, drawing] = [make("span"), make("small"), new SignalDrawing(changes, inputs, stepsOfSignal(changes, signal))];
  const steps = drawing.steps.map((names) => stepRow(changes, signal, names));
  const title = `Signal ${signal}: a change of its numbers acts on the whole run`;
  const heading = make("summary", { title }, words, " ", range, drawing.element);
  const part = make("details", { className: "signal", open: isOpen }, heading, ...[...rows, ...steps].map(({ row }) => row));
  let shown;
  return {
    part,
    refresh: () => {
      steps.forEach(({ refresh }) => refresh());
      words.textContent = inputs.map((input) => inputText(input, changes.valueOf)).join("; ");
      drawing.show();
    },
    follow: ({ time, inputs: run }) => {
      if (run && run !== shown) {
        drawing.show(run);
        range.textContent = drawing.curves.length ? drawing.text : "";
        shown = run;
      }
      if (run) drawing.now.style.left = `${100 * Math.min(time / run.time.at(-1), 1)}%`;
    },
  };
}
