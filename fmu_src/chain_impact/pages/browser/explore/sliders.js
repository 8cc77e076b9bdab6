// The knobs for the most important parameters, and the list of all parameters.

import { make } from "../base/dom.js";
import { breakable, numberText, unitText } from "../base/format.js";

/** The parameters with a knob: name, label, and the ends of the knob's slider. */
export const KNOBS = [
  { name: "contact.model", label: "Contact law" },
  { name: "contact.stiffness", label: "Stiffness", logarithmic: true, decades: 3 },
  { name: "contact.restitution", label: "Restitution", ends: [0, 1] },
  { name: "contact.friction", label: "Friction", ends: [0, 1.5] },
  { name: "contact.static_friction", label: "Static friction", ends: [0, 1.5] },
  { name: "stop.stiffness", label: "Stiffness of stops", logarithmic: true, decades: 3 },
  { name: "stop.restitution", label: "Restitution of stops", ends: [0, 1] },
  { name: "gravity.y", label: "Gravity, y", ends: [-20, 20] },
  { name: "solver.tolerance", label: "Tolerance", logarithmic: true, ends: [-12, -3] },
  { name: "simulation.stop_time", label: "Stop time", spread: 3 },
];
const STEPS = 400; // number of steps of a slider
// numbers of a signal that get a knob only if the scene gives them, because they are 0 otherwise
const TRIVIAL = ["mean", "frequency_rate", "phase", "initial", "start", "rise"];

/** Make a change; if its value is refused, mark the field, and show the reason in its row. */
function attempt(field, change) {
  try {
    field.setCustomValidity("");
    change();
  } catch (error) {
    field.setCustomValidity(error.message);
  }
  explain(field.closest(".knob, .parameter"));
}

/** Return the element of a row that shows why a value is refused. */
function refusal() {
  const place = make("p", { className: "refusal" });
  place.setAttribute("role", "alert");
  return place;
}

/** Show in a row why the value in it is refused, until the value changes, or show nothing. */
function explain(row) {
  const refused = [...row.querySelectorAll("input, select")].find((field) => !field.checkValidity());
  row.querySelector(".refusal").textContent = refused ? `Not taken: ${refused.validationMessage}.` : "";
}

/** Return a field for a number, or a choice, whose value follows the changes. */
export function valueField(changes, parameter) {
  const { name, items, text, allowed, derived } = parameter;
  const field = items.length
    ? make("select", {}, ...items.map(([id], k) => new Option(id, String(k + 1))))
    : make("input", { type: "text", autocomplete: "off", spellcheck: false });
  field.title = `${name}: ${text}; ${allowed}${derived?.text ?? ""}`;
  field.setAttribute("aria-label", name);
  field.addEventListener("change", () => attempt(field, () => changes.set({ [name]: field.value })));
  const refresh = () => {
    const value = changes.valueOf(name);
    if (document.activeElement !== field || items.length) {
      field.setCustomValidity("");
      field.value = items.length ? String(value) : numberText(value);
    } else if (field.checkValidity()) {
      field.value = numberText(value);
    }
  };
  return { field, refresh };
}

function resetButton(changes, name, field) {
  const button = make("button", { type: "button", className: "reset", textContent: "↺", title: `As in the scene: ${name}` });
  button.setAttribute("aria-label", `Reset ${name}`);
  button.addEventListener("click", () => attempt(field, () => changes.reset(name)));
  return button;
}

/** Return the functions between the place of a slider and its value. */
function scaleOf({ ends, logarithmic, decades, spread }, start) {
  if (logarithmic) {
    const middle = Math.log10(start);
    const [low, high] = ends ?? [Math.floor(middle - decades), Math.ceil(middle + decades)];
    return { toPlace: (value) => (Math.log10(value) - low) / (high - low), toValue: (place) => 10 ** (low + place * (high - low)) };
  }
  const [low, high] = spread ? [0, spread * start] : ends;
  return { toPlace: (value) => (value - low) / (high - low), toValue: (place) => low + place * (high - low) };
}

/** Return a value with as many digits as a slider can distinguish. */
function rounded(value) {
  return Number(value.toPrecision(3));
}

/**
 * Return a knob: label, field, slider, reset button. While the motion plays, the slider of an input acts from the present
 * time on, which `now` returns.
 */
function knob(changes, entry, now) {
  const parameter = changes.parameters.get(entry.name);
  const { field, refresh } = valueField(changes, parameter);
  const unit = unitText(parameter.unit);
  const label = make("label", { className: "knob-label", textContent: breakable(entry.label), title: entry.name });
  if (unit) label.append(" ", make("small", { textContent: unit }));
  const row = make("div", { className: "knob" }, label, resetButton(changes, entry.name, field), field);
  const told = refusal();
  field.id = `knob-${entry.name}`;
  label.htmlFor = field.id;
  if (parameter.items.length) {
    const sentence = make("p", { className: "sentence" });
    row.append(sentence, told);
    row.classList.add("choice-knob");
    return { name: entry.name, row, refresh: () => {
      refresh();
      explain(row);
      sentence.textContent = parameter.items[changes.valueOf(entry.name) - 1][1];
      row.classList.toggle("changed", changes.isChanged(entry.name));
    } };
  }
  const { toPlace, toValue } = scaleOf(entry, changes.starts[entry.name]);
  const slider = make("input", { type: "range", min: 0, max: STEPS, step: 1 });
  let isDragged = false;
  slider.setAttribute("aria-label", entry.label);
  slider.addEventListener("input", () => {
    const value = rounded(toValue(slider.value / STEPS));
    const { isPlaying, time } = now();
    const from = Number(time.toFixed(6));
    isDragged = true;
    if (entry.isInput && isPlaying && from > 0) attempt(slider, () => changes.hold(entry.name, value, from));
    else attempt(slider, () => changes.set({ [entry.name]: Math.max(value, entry.spread ? rounded(changes.starts[entry.name] / 100) : value) }));
  });
  // a slider that is dragged back to its value has no event `change`
  ["change", "pointerup", "pointercancel"].forEach((end) => slider.addEventListener(end, () => {
    isDragged = false;
  }));
  row.append(slider, told);
  /** Show the value at the present time, except in a field with the focus or with a refused text. */
  const follow = () => {
    const value = changes.valueAt(entry.name, now().time);
    if (document.activeElement !== field && field.checkValidity()) field.value = numberText(value);
    if (entry.name in changes.held ? !isDragged : document.activeElement !== slider) slider.value = String(STEPS * toPlace(value));
    slider.style.setProperty("--done", `${100 * Math.min(Math.max(toPlace(value), 0), 1)}%`);
    slider.setAttribute("aria-valuetext", `${numberText(value)} ${unit}`);
  };
  return { name: entry.name, row, follow, refresh: () => {
    refresh();
    slider.setCustomValidity("");
    explain(row);
    follow();
    row.classList.toggle("changed", changes.isChanged(entry.name));
  } };
}

/**
 * Return the knobs of the inputs, from −x to x: x is the value that the weight of the chain needs, half a turn, the length of
 * the chain, or the speed after a fall through this length.
 */
function inputKnobs({ scene, starts }) {
  const sum = (key) => Array.from({ length: scene.links }, (_, k) => starts[`link[${k + 1}].${key}`]).reduce((a, b) => a + b, 0);
  const [weight, length] = [10 * sum("mass"), sum("length")]; // [N] and [m], of the chain
  const ends = { "N.m": weight * length, N: weight, rad: Math.PI, "rad/s": 10, m: length, "m/s": Math.sqrt(2 * 10 * length) };
  return scene.inputs.map((name) => {
    const end = Number(ends[scene.parameters.find((one) => one.name === name).unit].toPrecision(3));
    return { name, label: name, ends: [-end, end], isInput: true };
  });
}

/** Return the ends of the slider for a number of a signal, by its key, its value and the other values of the signal. */
function endsOfSignal(key, value, beside, stop) {
  if (key === "phase") return [-Math.PI, Math.PI];
  if (["start", "rise", "duration", "time"].includes(key)) return [0, Math.max(stop, 2 * value)];
  if (key === "frequency" && value > 0) return [0, 3 * value];
  const size = Math.max(...beside.map(Math.abs)) || 1;
  return key === "frequency_rate" ? [-size / stop, size / stop] : [key === "amplitude" ? 0 : -2 * size, 2 * size];
}

/**
 * Return the knobs of the signals: for the numbers that a form needs, and for other numbers that the scene gives. The list
 * has all numbers.
 */
function signalKnobs({ scene, starts }) {
  const parts = scene.parameters.flatMap(({ name }) => {
    const [, signal, key] = /^signal\.(\w+)\.(\w+)/.exec(name) ?? [];
    return signal ? [{ name, signal, key, value: starts[name] }] : [];
  });
  const alike = (key) => (["frequency", "frequency_rate"].includes(key) ? ["frequency"] : ["value", "mean", "amplitude", "initial", "final"]);
  return parts.filter(({ key, value }) => value !== 0 || !TRIVIAL.includes(key)).map(({ name, signal, key, value }) => {
    const beside = parts.filter((one) => one.signal === signal && alike(key).includes(one.key)).map((one) => one.value);
    return { name, label: name.slice("signal.".length), ends: endsOfSignal(key, value, beside, starts["simulation.stop_time"]) };
  });
}

/**
 * Return the knobs that the scene has; if walls have their own friction or restitution, one knob for each of these walls.
 */
function knobsOf(changes) {
  const { parameters, scene } = changes;
  const walls = Object.keys(scene.walls);
  return KNOBS.flatMap((entry) => {
    const [, key] = /^contact\.(friction|static_friction|restitution)$/.exec(entry.name) ?? [];
    const own = key ? walls.filter((wall) => parameters.has(`wall.${wall}.${key}`)) : [];
    const common = own.length > 0 && own.length === walls.length ? [] : [entry];
    return [...common, ...own.map((wall) => ({ ...entry, name: `wall.${wall}.${key}`, label: `${entry.label} at ${wall}` }))];
  }).filter(({ name }) => parameters.has(name)).concat(inputKnobs(changes));
}

/**
 * Fill an element with the knobs of the scene, and again when another scene is opened. `now` returns the present time, and
 * whether the motion plays; call the returned function when they change.
 */
export function showKnobs(element, changes, now) {
  let knobs;
  const fill = () => {
    knobs = [...signalKnobs(changes), ...knobsOf(changes)].map((entry) => knob(changes, entry, now));
    element.replaceChildren(...knobs.map(({ row }) => row));
  };
  const refresh = () => knobs.forEach((one) => one.refresh());
  changes.onOpen(fill);
  changes.onChange(refresh);
  fill();
  refresh();
  return () => knobs.forEach(({ name, follow }) => name in changes.held && follow());
}

/**
 * Fill the list of all parameters when it is first opened; `search` leaves the parameters whose name or meaning contains a
 * text.
 */
export function showList(details, changes) {
  const [search, body] = [details.querySelector("input[type=search]"), details.querySelector(".parameters")];
  let rows;
  const refresh = () => rows?.forEach((row) => row.refresh());
  const filter = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    rows.forEach(({ row, text }) => {
      row.hidden = !words.every((word) => text.includes(word));
    });
    details.querySelector(".nothing").hidden = rows.some(({ row }) => !row.hidden);
  };
  const fill = () => {
    if (rows || !details.open) return;
    rows = changes.scene.parameters.map((parameter) => listRow(changes, parameter));
    body.replaceChildren(...rows.map(({ row }) => row));
    refresh();
    filter();
  };
  details.addEventListener("toggle", fill);
  search.addEventListener("input", filter);
  changes.onOpen(() => {
    rows = undefined;
    fill();
  });
  changes.onChange(refresh);
}

function listRow(changes, parameter) {
  const { name, unit, text, allowed } = parameter;
  const { field, refresh } = valueField(changes, parameter);
  const words = make("span", { className: "parameter-name", title: `${text}; ${allowed}` }, breakable(name));
  const row = make("div", { className: "parameter" }, words, resetButton(changes, name, field), field,
    make("small", { textContent: unitText(unit) }), refusal());
  return {
    row,
    text: `${name} ${text}`.toLowerCase(),
    refresh: () => {
      refresh();
      explain(row);
      row.classList.toggle("changed", changes.isChanged(name));
    },
  };
}
