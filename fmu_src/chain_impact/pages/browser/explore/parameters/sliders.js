// The sliders of the main parameters, of inputs and of signals.

import { make } from "../../base/dom.js";
import { numberText, readable, textWithUnit } from "../../base/format.js";
import { lawText } from "../../scene/words.js";
import { idleLaw, lawOf, mainParametersOf, signalSliders } from "./main_parameters.js";
import { attempt, explain, presentlyShown, refusal, resetButton, turnsText, valueField } from "./parameter_fields.js";
import { signalPart } from "./signal_part.js";

const INPUTS_TITLE = "Forces, moments and targets that nothing else sets. While the motion plays, a slider acts from that moment on.";
const STEPS = 400; // number of steps from one end of a slider to the other

/**
 * Return two functions for the slider of an entry (`MAIN_PARAMETERS` in main_parameters.js): `toValue`, from a position of the slider (0 to
 * 1) to a value of the parameter, and `toPosition`, from a value to a position. `start`: the parameter's value in the scene.
 */
function scaleOf({ ends, logarithmic, decades, spread }, start) {
  if (logarithmic) {
    const middle = Math.log10(start);
    const [low, high] = ends ?? [Math.floor(middle - decades), Math.ceil(middle + decades)];
    return {
      toPosition: (value) => (Math.log10(value) - low) / (high - low),
      toValue: (position) => 10 ** (low + position * (high - low)),
    };
  }
  const [low, high] = spread ? [0, spread * start] : ends;
  return { toPosition: (value) => (value - low) / (high - low), toValue: (position) => low + position * (high - low) };
}

/** Return the value at a position of a slider, rounded to three significant digits. */
function rounded(value) {
  return Number(value.toPrecision(3));
}

/**
 * Return for a main parameter: `label`, an element; `shown`, a function that returns the factor and the unit with which the parameter is
 * shown; and `relabel`, a function that shows words and unit in the label.
 */
function labelOf(changes, entry) {
  const { name } = entry;
  const shown = () => presentlyShown(changes, name);
  const [words, element] = [make("span"), make("small")];
  const label = make("label", { className: "main-parameter-label", title: name }, words);
  const { items } = changes.parameters.get(name);
  // a short unit stands in the line of the last word
  if (shown().text || items.length) label.append(!items.length && shown().text.length < 3 ? "\u00a0" : " ", element);
  const relabel = () => {
    words.textContent = (entry.short ?? entry.label).replace(/ (?=\d)/g, "\u00a0"); // the line is not broken before a number
    element.textContent = items.length ? items[changes.valueOf(name) - 1][0] : shown().text; // a choice has its name in scene files
  };
  return { label, shown, relabel };
}

/**
 * Return the row of a main parameter (label, field, reset button, and a slider for a number or a sentence on a choice), with functions that
 * bring it up to date. `now` is a function that returns the present time and whether the motion plays: while it plays, the slider of an
 * input acts from this time on.
 */
function mainParameter(changes, entry, now) {
  const { name } = entry;
  const parameter = changes.parameters.get(name);
  const { field, write, refresh } = valueField(changes, parameter);
  const { label, shown, relabel } = labelOf(changes, entry);
  const row = make("div", { className: "main-parameter" }, label, resetButton(changes, name, field), field);
  field.id = `main-${name}`;
  label.htmlFor = field.id;
  const { element, since, follow, show } = parameter.items.length
    ? choiceSentence(changes, parameter)
    : slider(changes, entry, { field, write, now, shown });
  row.classList.toggle("choice-parameter", parameter.items.length > 0);
  const noEffect = make("p", { className: "no-effect", id: `no-effect-${name}` });
  field.setAttribute("aria-describedby", noEffect.id);
  row.append(element, ...(since ? [since] : []), noEffect, refusal());
  return { name, row, follow, refresh: () => {
    refresh();
    show();
    relabel();
    field.setAttribute("aria-label", `${entry.label}, ${name}`); // the label contains the words that are seen, and the name in the scene
    explain(row);
    const law = idleLaw(changes, name.split(".").at(-1), name.startsWith("stop."));
    row.classList.toggle("idle", Boolean(law));
    noEffect.textContent = law ? `No effect with ${lawText(law)}.` : turnsText(changes, name);
    row.classList.toggle("changed", changes.isChanged(name));
  } };
}

/**
 * Return the least value that the slider of a parameter may set: a value above 0 for an entry whose slider goes from 0 to `spread` times
 * the start value, and for a restitution if the contact law does not allow 0; else −∞.
 */
function leastOf(changes, { name, spread }) {
  if (spread) return rounded(changes.starts[name] / 100);
  const isRefused = name.endsWith("restitution") && SHARED.laws[lawOf(changes, name.startsWith("stop."))]?.allows_zero === false;
  return isRefused ? rounded(1 / STEPS) : -Infinity;
}

/** Return an element for the sentence on a parameter's choice, and `show`, a function that writes the sentence on the present choice. */
function choiceSentence(changes, { name, items }) {
  const element = make("p", { className: "sentence" });
  return { element, show: () => {
    element.textContent = readable(items[changes.valueOf(name) - 1][1]);
  } };
}

/**
 * Return words for the time [s] from which on an input has the value that it has at `time`: the time of the last step up to `time`; "" if
 * there is no step up to `time`. The reader makes steps while the motion plays.
 */
function sinceText({ inputSteps }, name, time) {
  const [from] = (inputSteps[name] ?? []).findLast(([start]) => start <= time) ?? [];
  return from === undefined ? "" : `Held since ${numberText(Number(from.toPrecision(4)))} s.`;
}

/**
 * Return the slider of a parameter; for an input also `since`, an element that tells from when on its value holds; and two functions:
 * `follow` sets slider and field to the value at the present time; `show`, for use after a change, also removes the slider's mark of a
 * refused value.
 */
function slider(changes, entry, { field, write, now, shown }) {
  const { name } = entry;
  const { toPosition, toValue } = scaleOf(entry, changes.starts[name]);
  const element = make("input", { type: "range", min: 0, max: STEPS, step: 1 });
  let isDragged = false;
  // an angle is round in degrees
  const inShownDigits = (value, { factor }) => (factor === 1 ? rounded(value) : Number((rounded(factor * value) / factor).toPrecision(6)));
  const chosen = () => Math.max(inShownDigits(toValue(element.value / STEPS), shown()), leastOf(changes, entry));
  const since = entry.isInput && make("p", { className: "sentence" });
  element.addEventListener("input", () => {
    const value = chosen();
    const { isPlaying, time } = now();
    const from = Number(time.toFixed(6));
    isDragged = true;
    if (entry.isInput && isPlaying && from > 0) attempt(changes, element, () => changes.setFrom(name, value, from));
    else attempt(changes, element, () => changes.set({ [name]: value }));
  });
  // dragging a slider back to its first value causes no event `change`, so other events end the drag, too
  ["change", "pointerup", "pointercancel"].forEach((end) => element.addEventListener(end, () => {
    isDragged = false;
  }));
  /**
   * Show the value at the present time. A field in which the reader types, or whose text is refused, stays. So does a slider that is
   * dragged, or whose position stands for the value: the steps of the slider and of the rounded values differ, so that an arrow key could
   * lead back to the same position.
   */
  const follow = () => {
    const value = changes.valueAt(name, now().time);
    if (document.activeElement !== field && field.checkValidity()) write(value);
    if (!isDragged && chosen() !== value) element.value = String(STEPS * toPosition(value));
    element.classList.toggle("outside", Math.abs(toPosition(value) - 0.5) > 0.501);
    element.style.setProperty("--done", `${100 * Math.min(Math.max(toPosition(value), 0), 1)}%`);
    element.setAttribute("aria-label", [entry.label, shown().text].filter(Boolean).join(", "));
    if (since) since.textContent = sinceText(changes, name, now().time);
    element.setAttribute("aria-valuetext", textWithUnit(value, shown()));
  };
  return { element, since, follow, show: () => {
    element.setCustomValidity("");
    follow();
  } };
}

/**
 * Return a part of the page with the rows of inputs, which the reader can fold, and a function that tells in its heading how many inputs
 * are 0. The part is open if no signal acts, or if the reader has set more inputs.
 */
function inputsPart(changes, rows) {
  const count = make("small");
  const part = make("details", { className: "inputs" }, make("summary", { title: INPUTS_TITLE }, "Inputs ", count),
    ...rows.map(({ row }) => row));
  // number of inputs that are not 0
  let before = changes.scene.driven.length === 0 ? -1 : rows.filter(({ name }) => changes.starts[name] !== 0).length;
  return { part, tell: () => {
    const zero = rows.filter(({ name }) => changes.valueOf(name) === 0 && !(name in changes.inputSteps)).length;
    count.textContent = zero === rows.length ? "all are 0" : zero ? `${rows.length - zero} of ${rows.length} not 0` : "";
    if (rows.length - zero > before) part.open = true;
    before = rows.length - zero;
  } };
}

/**
 * Fill an element with the main parameters, signals and inputs of the scene, at once and each time that a scene is opened. `now` is a
 * function that returns the present time, whether the motion plays, and the inputs of the run. Return a function that must be called when
 * the time or the run changes.
 */
export function showMainParameters(element, changes, now) {
  let [rows, signals, tellInputs] = [];
  const lawOfStops = make("p", { className: "note" }); // the law is no parameter: only the scene file can change it
  const fill = () => {
    const rowsOf = (entries) => entries.map((entry) => ({ ...mainParameter(changes, entry, now), entry }));
    const ofSignals = rowsOf(signalSliders(changes));
    const others = rowsOf(mainParametersOf(changes).filter(({ isListed }) => !isListed));
    const inputs = others.filter(({ entry }) => entry.isInput);
    rows = [...ofSignals, ...others];
    signals = Object.keys(changes.scene.file.signals).map((signal, k) =>
      signalPart(changes, signal, ofSignals.filter(({ entry }) => entry.signal === signal), k === 0));
    element.replaceChildren(...others.filter(({ entry }) => !entry.isInput).map(({ row }) => row), ...signals.map(({ part }) => part));
    const { part, tell } = inputsPart(changes, inputs);
    tellInputs = tell;
    if (inputs.length) element.append(part);
    element.querySelector("[id^='main-stop.']")?.closest(".main-parameter").before(lawOfStops);
  };
  const refresh = () => {
    [...rows, ...signals].forEach((row) => row.refresh());
    tellInputs();
    lawOfStops.textContent = `Contact law of stops: ${lawText(lawOf(changes, true))}`;
  };
  changes.onOpen(fill);
  changes.onChange(refresh);
  fill();
  refresh();
  return () => {
    signals.forEach(({ follow }) => follow(now()));
    rows.forEach(({ name, follow }) => name in changes.inputSteps && follow());
  };
}
