// The main parameters of a scene, which have controls of their own, and the words for all parameters.

import { boxWallText, capitalized, inputText, parameterText, signalText } from "../../scene/words.js";

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
// keys of a signal whose default is 0: such a key has a slider only if the signal gives another value
const TRIVIAL = Object.values(SHARED.signals.OTHER).flatMap((keys) => Object.keys(keys).filter((key) => keys[key] === 0));

const OF_STEP = /\.(time|value)\[\d+\]$/; // time or value of a step

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
 * Return the ends of the slider for a number of a signal, which follow from its key, its unit, its value in the scene, numbers of the
 * signal with the same unit (`beside`; for a rate of the frequency, the frequencies), and the stop time [s].
 */
function endsOfSignal({ key, unit, value }, beside, stop) {
  if (key === "phase") return [-Math.PI, Math.PI];
  if (unit === "s") return [0, Math.max(stop, 2 * value)];
  if (unit === "Hz" && value > 0) return [0, 3 * value];
  const size = Math.max(...beside.map(Math.abs)) || 1;
  return unit === "Hz/s" ? [-size / stop, size / stop] : [key === "amplitude" ? 0 : -2 * size, 2 * size];
}

/**
 * Return the entries for sliders of the signals' numbers. A number has no slider if its default and its value in the scene are 0, which
 * the list of all parameters has, or if it is of a step, which has a row and a point in the drawing.
 */
export function signalSliders({ scene, starts }) {
  const parts = scene.parameters.flatMap(({ name, unit }) => {
    const [, signal, all, key] = /^signal\.([^.]+)\.((\w+).*)$/.exec(name) ?? [];
    return signal ? [{ name, signal, words: signalText(signal, all), key, unit, value: starts[name] }] : [];
  });
  const hasSlider = ({ name, key, value }) => !OF_STEP.test(name) && (value !== 0 || !TRIVIAL.includes(key));
  return parts.filter(hasSlider).map((part) => {
    const { name, signal, words: label } = part;
    const unit = part.unit === "Hz/s" ? "Hz" : part.unit;
    const alike = parts.filter((other) => other.signal === signal && other.unit === unit && other.key !== "phase");
    const short = capitalized(label.slice(signal.length + 2)); // below a heading with the signal
    return { name, signal, label, short, ends: endsOfSignal(part, alike.map(({ value }) => value), starts["simulation.stop_time"]) };
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

/**
 * Return a list with the slider for the start: for a free base its height, from y − h to y + h, where y is the height in the scene and h
 * the larger of |y| and the length of the chain; else the angle of link 1; [] if the scene has no such parameter.
 */
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

/** Return a sentence in which the words of controls replace the names of parameters of the scene. */
export function withControls(sentence, changes) {
  const wordsOf = wordsFor(changes);
  const name = /\b[a-z]\w*(?:\[\d+\])?(?:\.\w+(?:\[\d+\])?)+/g;
  return sentence.replace(name, (found) => (changes.parameters.has(found) ? wordsOf(found) : found));
}

/**
 * Return the name of the law of walls or, if `ofStops`, of stops of joints, if this law does not use the number `key`: an impulse needs no
 * stiffness, and a law without losses no restitution; "" if the law uses the number.
 */
export function idleLaw(changes, key, ofStops) {
  const law = lawOf(changes, ofStops);
  const fact = { stiffness: "rigid", restitution: "lossless" }[key];
  return SHARED.laws[law]?.[fact] ? law : "";
}

/** Return the name of the present law of walls or, if `ofStops`, of stops of joints. */
export function lawOf(changes, ofStops) {
  const { contact, stops } = changes.scene.file;
  const model = changes.parameters.get("contact.model");
  return (ofStops && stops.model) || (model?.items[changes.valueOf(model.name) - 1]?.[0] ?? contact.model);
}
