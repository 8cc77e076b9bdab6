// The sliders of the main parameters, of inputs and of signals.

import { make } from "../../base/dom.js";
import { numberText, readable } from "../../base/format.js";
import { boxWallText, inputText, parameterText, signalText } from "../../scene/words.js";
import { attempt, explain, presentUnit, refusal, resetButton, valueField } from "./parameter_fields.js";

/**
 * The main parameters, each with a name, a label, and the ends of its slider: `ends` (exponents of ten on a logarithmic slider); or the
 * nearest powers of ten that are at least `decades` powers below and above the scene's value; or 0 and `spread` times this value. A
 * parameter without any of these is a choice, or has no slider.
 */
export const MAIN_PARAMETERS = [
  { name: "contact.model", label: "Contact law" },
  { name: "contact.stiffness", label: "Stiffness", logarithmic: true, decades: 3 },
  { name: "contact.restitution", label: "Restitution", ends: [0, 1] },
  { name: "contact.friction", label: "Friction", ends: [0, 1.5] },
  { name: "contact.static_friction", label: "Static friction", ends: [0, 1.5] },
  { name: "stop.stiffness", label: "Stiffness of stops", logarithmic: true, decades: 3 },
  { name: "stop.restitution", label: "Restitution of stops", ends: [0, 1] },
  { name: "gravity.y", label: "Gravity, y", ends: [-20, 20] },
  { name: "solver.tolerance", label: "Solver tolerance", logarithmic: true, isListed: true }, // it has no slider
  { name: "simulation.stop_time", label: "Stop time", spread: 3 },
];
const STEPS = 400; // number of steps from one end of a slider to the other
// keys of a signal whose default is 0: such a key has a slider only if the signal gives another value
const TRIVIAL = Object.values(SHARED.signals.OTHER).flatMap((keys) => Object.keys(keys).filter((key) => keys[key] === 0));

/**
 * Return two functions for the slider of an entry (`MAIN_PARAMETERS`): `toValue`, from its position (0 to 1) to the value of the parameter,
 * and `toPosition`, back. `start`: the parameter's value in the scene.
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

/** Return the value at a position of a slider rounded to three significant digits, by which most neighbouring positions differ. */
function rounded(value) {
  return Number(value.toPrecision(3));
}

/**
 * Return for a main parameter: `label`, an element; `text`, a function that returns the parameter's unit; and `relabel`, a function that
 * shows words and unit in the label, without the unit if the text in the field, which is the argument, is in degrees.
 */
function labelOf(changes, entry) {
  const { name } = entry;
  const text = () => presentUnit(changes, name);
  const [words, element] = [make("span"), make("small", { textContent: text() })];
  const label = make("label", { className: "main-parameter-label", title: name }, words);
  if (text()) label.append(" ", element);
  const relabel = (shown) => {
    words.textContent = entry.label.replace(/ (?=\d)/g, "\u00a0"); // the line is not broken before a number
    // a text such as "90 deg" contains its unit, so no unit is shown beside it
    element.textContent = /deg/.test(shown) ? "" : text();
  };
  return { label, text, relabel };
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
  const { label, text, relabel } = labelOf(changes, entry);
  const row = make("div", { className: "main-parameter" }, label, resetButton(changes, name, field), field);
  field.id = `main-${name}`;
  label.htmlFor = field.id;
  const { element, since, follow, show } = parameter.items.length
    ? choiceSentence(changes, parameter)
    : slider(changes, entry, { field, write, now, unit: text });
  row.classList.toggle("choice-parameter", parameter.items.length > 0);
  row.append(element, ...(since ? [since] : []), refusal());
  return { name, row, follow, refresh: () => {
    refresh();
    show();
    relabel(field.value);
    field.setAttribute("aria-label", `${entry.label}, ${name}`); // the label contains the words that are seen, and the name in the scene
    explain(row);
    const law = idleLaw(changes, name.split(".").at(-1), name.startsWith("stop."));
    row.classList.toggle("idle", Boolean(law));
    label.title = law ? `${name}: no effect with ${law}` : name;
    row.classList.toggle("changed", changes.isChanged(name));
  } };
}

/**
 * Return the name of the law of walls or, if `ofStops`, of stops of joints, if this law does not use the number `key`: an impulse needs no
 * stiffness, and a law without losses no restitution; "" if the law uses the number.
 */
export function idleLaw(changes, key, ofStops) {
  const law = lawOf(changes, ofStops);
  const fact = { stiffness: "impulsive", restitution: "lossless" }[key];
  return SHARED.laws[law]?.[fact] ? law : "";
}

/** Return the name of the present law of walls or, if `ofStops`, of stops of joints. */
function lawOf(changes, ofStops) {
  const { contact, stops } = changes.scene.file;
  const model = changes.parameters.get("contact.model");
  return (ofStops && stops.model) || (model?.items[changes.valueOf(model.name) - 1]?.[0] ?? contact.model);
}

/** Return the least value that the slider of a parameter may set: above 0 if the slider begins at 0 and 0 is not allowed, else −∞. */
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
 * Return words for the time [s] from which on an input has the value that it has at `time`: that of the last step up to then, which the
 * reader made while the motion played; "" if there is no such step.
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
function slider(changes, entry, { field, write, now, unit }) {
  const { name } = entry;
  const { toPosition, toValue } = scaleOf(entry, changes.starts[name]);
  const element = make("input", { type: "range", min: 0, max: STEPS, step: 1 });
  let isDragged = false;
  const since = entry.isInput && make("p", { className: "sentence" });
  element.addEventListener("input", () => {
    const value = rounded(toValue(element.value / STEPS));
    const { isPlaying, time } = now();
    const from = Number(time.toFixed(6));
    isDragged = true;
    if (entry.isInput && isPlaying && from > 0) attempt(element, () => changes.setFrom(name, value, from));
    else attempt(element, () => changes.set({ [name]: Math.max(value, leastOf(changes, entry)) }));
  });
  // dragging a slider back to its first value causes no event `change`, so other events end the drag, too
  ["change", "pointerup", "pointercancel"].forEach((end) => element.addEventListener(end, () => {
    isDragged = false;
  }));
  /** Show the value at the present time. A field in which the reader types, or whose text is refused, stays; so does a slider in use. */
  const follow = () => {
    const value = changes.valueAt(name, now().time);
    if (document.activeElement !== field && field.checkValidity()) write(value);
    if (name in changes.inputSteps ? !isDragged : document.activeElement !== element) element.value = String(STEPS * toPosition(value));
    element.style.setProperty("--done", `${100 * Math.min(Math.max(toPosition(value), 0), 1)}%`);
    element.setAttribute("aria-label", [entry.label, unit()].filter(Boolean).join(", "));
    if (since) since.textContent = sinceText(changes, name, now().time);
    element.setAttribute("aria-valuetext", [numberText(value), unit()].filter(Boolean).join(" "));
  };
  return { element, since, follow, show: () => {
    element.setCustomValidity("");
    follow();
  } };
}

/**
 * Return the entries for sliders of the inputs, each from −x to x. The unit decides x: weight of the chain [N], weight times length [N·m],
 * half a turn [rad], 10 rad/s, length of the chain [m], speed after a fall through this length [m/s]; 1 for any other unit. Weight and
 * fall are those at 10 m/s² for any gravity.
 */
function inputSliders({ scene, starts, valueOf }) {
  const sum = (key) => Array.from({ length: scene.links }, (_, k) => starts[`link[${k + 1}].${key}`]).reduce((a, b) => a + b, 0);
  const [weight, length] = [10 * sum("mass"), sum("length")]; // weight [N] and length [m] of the chain
  const ends = { "N.m": weight * length, N: weight, rad: Math.PI, "rad/s": 10, m: length, "m/s": Math.sqrt(2 * 10 * length) };
  return scene.inputs.map((name) => {
    const { unit } = scene.parameters.find((parameter) => parameter.name === name);
    const end = Number((ends[unit] ?? 1).toPrecision(3));
    return { name, get label() { return inputText(name, valueOf); }, ends: [-end, end], isInput: true };
  });
}

/**
 * Return the ends of the slider for a number of a signal, which follow from its key, its value in the scene, similar numbers of the signal
 * (`beside`), and the stop time [s].
 */
function endsOfSignal(key, value, beside, stop) {
  if (key === "phase") return [-Math.PI, Math.PI];
  if (["start", "rise", "duration", "time"].includes(key)) return [0, Math.max(stop, 2 * value)];
  if (key === "frequency" && value > 0) return [0, 3 * value];
  const size = Math.max(...beside.map(Math.abs)) || 1;
  return key === "frequency_rate" ? [-size / stop, size / stop] : [key === "amplitude" ? 0 : -2 * size, 2 * size];
}

/**
 * Return the entries for sliders of the signals' numbers. A number has no slider if its default and its value in the scene are 0; the list
 * of all parameters has it.
 */
function signalSliders({ scene, starts }) {
  const parts = scene.parameters.flatMap(({ name }) => {
    const [, signal, all, key] = /^signal\.([^.]+)\.((\w+).*)$/.exec(name) ?? [];
    return signal ? [{ name, signal, label: signalText(signal, all), key, value: starts[name] }] : [];
  });
  const alike = (key) =>
    (["frequency", "frequency_rate"].includes(key) ? ["frequency"] : ["value", "mean", "amplitude", "initial", "final"]);
  return parts.filter(({ key, value }) => value !== 0 || !TRIVIAL.includes(key)).map(({ name, signal, label, key, value }) => {
    const beside = parts.filter((other) => other.signal === signal && alike(key).includes(other.key)).map((other) => other.value);
    return { name, label, ends: endsOfSignal(key, value, beside, starts["simulation.stop_time"]) };
  });
}

/**
 * Return the entries, like those of `MAIN_PARAMETERS`, for the sliders of the scene's main parameters and inputs. A wall with its own
 * friction or restitution has entries of its own; if all walls have, the entry of the common value is left out.
 */
export function mainParametersOf(changes) {
  const { parameters, scene } = changes;
  const walls = Object.keys(scene.walls);
  return MAIN_PARAMETERS.flatMap((entry) => {
    const [, key] = /^contact\.(friction|static_friction|restitution)$/.exec(entry.name) ?? [];
    const ofWalls = key ? walls.filter((wall) => parameters.has(`wall.${wall}.${key}`)) : [];
    const common = ofWalls.length > 0 && ofWalls.length === walls.length ? [] : [entry];
    return [...common, ...ofWalls.map((wall) => ({ ...entry, name: `wall.${wall}.${key}`, get label() {
      const words = boxWallText(wall, changes.valueOf); // the words change with gravity
      return `${entry.label} at ${words ? `the ${words}` : wall}`;
    } }))];
  }).filter(({ name }) => parameters.has(name)).concat(startSlider(changes), inputSliders(changes));
}

/** Return a list with the slider for the start: height y of a free base, ± the larger of chain length and |y|; else angle of link 1. */
function startSlider({ scene: { links, file }, starts }) {
  const { "initial.y": y, "initial.angle[1]": angle } = starts;
  const length = Array.from({ length: links }, (_, k) => starts[`link[${k + 1}].length`]).reduce((a, b) => a + b, 0);
  const reach = Number(Math.max(length, Math.abs(y)).toPrecision(2));
  if (file.chain.base === "free" && y !== undefined) return [{ name: "initial.y", label: "Initial height", ends: [y - reach, y + reach] }];
  return angle === undefined ? [] : [{ name: "initial.angle[1]", label: "Initial angle of link\u00a01", ends: [-Math.PI, Math.PI] }];
}

/** Return a function from the name of a parameter of the scene to its words: those of its slider, or else words made from the name. */
export function wordsFor(changes) {
  const labels = new Map(mainParametersOf(changes).map(({ name, label }) => [name, label]));
  return (name) => {
    const [, signal, key] = /^signal\.([^.]+)\.(.+)$/.exec(name) ?? [];
    const wall = boxWallText(name.replace(/^box\./, ""), changes.valueOf);
    return labels.get(name) ?? (signal ? signalText(signal, key) : wall ? `Position of the ${wall}` : parameterText(name));
  };
}

/**
 * Fill an element with the main parameters, inputs and signals of the scene, each time that a scene is opened. `now` is a function that
 * returns the present time and whether the motion plays; the returned function must be called when either changes.
 */
export function showMainParameters(element, changes, now) {
  let rows;
  const fill = () => {
    const entries = mainParametersOf(changes).filter(({ isListed }) => !isListed);
    rows = [...entries, ...signalSliders(changes)].map((entry) => mainParameter(changes, entry, now));
    element.replaceChildren(...rows.map(({ row }) => row));
  };
  const refresh = () => rows.forEach((row) => row.refresh());
  changes.onOpen(fill);
  changes.onChange(refresh);
  fill();
  refresh();
  return () => rows.forEach(({ name, follow }) => name in changes.inputSteps && follow());
}
