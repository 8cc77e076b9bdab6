// The sliders of the main parameters, of inputs and of signals.

import { make } from "../../base/dom.js";
import { numberText, readable, textWithUnit } from "../../base/format.js";
import { idleLaw, lawOf, mainParametersOf, signalSliders } from "./main_parameters.js";
import { attempt, explain, presentlyShown, refusal, resetButton, valueField } from "./parameter_fields.js";

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
  if (shown().text) label.append(" ", element);
  const relabel = () => {
    words.textContent = entry.label.replace(/ (?=\d)/g, "\u00a0"); // the line is not broken before a number
    element.textContent = shown().text;
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
    noEffect.textContent = law && `No effect with ${law}.`;
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
  const chosen = () => Math.max(rounded(toValue(element.value / STEPS)), leastOf(changes, entry));
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
 * Fill an element with the main parameters, inputs and signals of the scene, at once and each time that a scene is opened. `now` is a
 * function that returns the present time and whether the motion plays. Return a function that must be called when the time changes.
 */
export function showMainParameters(element, changes, now) {
  let rows;
  const lawOfStops = make("p", { className: "note" }); // the law is no parameter: only the scene file can change it
  const fill = () => {
    const entries = mainParametersOf(changes).filter(({ isListed }) => !isListed);
    rows = [...entries, ...signalSliders(changes)].map((entry) => mainParameter(changes, entry, now));
    element.replaceChildren(...rows.map(({ row }) => row));
    element.querySelector("[id^='main-stop.']")?.closest(".main-parameter").before(lawOfStops);
  };
  const refresh = () => {
    rows.forEach((row) => row.refresh());
    lawOfStops.textContent = `Contact law of stops: ${lawOf(changes, true)}`;
  };
  changes.onOpen(fill);
  changes.onChange(refresh);
  fill();
  refresh();
  return () => rows.forEach(({ name, follow }) => name in changes.inputSteps && follow());
}
