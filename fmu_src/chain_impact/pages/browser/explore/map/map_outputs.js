// The outputs that a map can show.

import { idleLaw } from "../parameters/main_parameters.js";

// a map first shows the first of these outputs that the scene has and no rigid law leaves unknown (`rigidLaw`)
const MAIN_OUTPUTS = ["joint_force", "peak_force", "stop.peak_moment"];
/** The outputs that a map tells of a run that the reader points at. */
export const TOLD_OUTPUTS = [...MAIN_OUTPUTS, "impact.count", "energy.dissipated"];

/** Return the indices, in the record, of the words (8 bytes each) of a run that a map needs: its status and the outputs. */
export function wordsOfRun({ layout }, outputs) {
  return [layout.status, ...outputs.flatMap(({ words }) => words)];
}

/**
 * Return run `number`, from 0, of a study: its status, and the name of each of the `outputs` → its value. `rows` and `firsts` are the
 * results of the study (worker.js) for the words that `wordsOfRun` returned for the same `outputs`. An output with several words has the
 * largest of their values. An output without words is one of the first impact; it is null if the run has no impact, or if the impact has
 * no such value.
 */
export function runIn(outputs, { rows, firsts }, number) {
  const first = (number * rows.length) / firsts.length;
  const integers = new BigInt64Array(rows.buffer);
  let at = first + 1;
  const values = Object.fromEntries(outputs.map(({ name, words, integer }) => {
    const all = words.map((_, k) => (integer ? Number(integers[at + k]) : rows[at + k]));
    at += words.length;
    return [name, all.length ? Math.max(...all) : firsts[number]?.[name] ?? null];
  }));
  return { status: Number(integers[first]), values };
}

/**
 * Return an output from the `values` of a run; for a place, its index in `places`. The result is null if the run has no such impact, or if
 * a rigid law leaves the output unknown, so that its value is 0 though the run has impacts.
 */
export function outputIn(values, { name, rigid, places }) {
  if (places && values[name]) return places.indexOf(values[name]);
  return rigid && values[name] === 0 && values["impact.count"] > 0 ? null : values[name];
}

/**
 * Return a list with the output `name` as a map needs it; the list is empty if the scene does not have the output. Besides name, unit and
 * `integer` (whether it is an integer), an output of a map has `words`: indices in the record; the map shows the largest of the values
 * there.
 */
function outputsLike({ columns }, name) {
  return columns.filter((column) => column.name === name).map(({ unit, integer, word }) => ({ name, unit, integer, words: [word] }));
}

/**
 * Return the outputs that are largest values of a run: at walls and stops of the slider, at stops of joints, and of forces in joints.
 * Their names are those of a sweep.
 */
function largestOf({ contactPoints, sliderStops, stops, columns, layout: { peaks } }) {
  const touch = contactPoints.length + sliderStops.length;
  const largest = Object.entries(SHARED.peaks)
    .filter(([, { atStops }]) => (atStops ? stops.length : touch))
    .map(([name, { unit }]) => ({ name, unit, integer: false, words: [peaks[name]] }));
  const loads = columns.filter(({ isPeakLoad }) => isPeakLoad).map(({ word }) => word);
  const ofJoints = { name: "joint_force", unit: SHARED.impactUnits.AT_WALL.joint_force, integer: false, words: loads };
  return loads.length ? [...largest, ofJoints] : largest;
}

/** Return the outputs of the first impact, with the names of a sweep; the place of the impact tells what touches, and the wall. */
function ofFirst({ contactPoints, sliderStops, stops }) {
  const touch = contactPoints.length + sliderStops.length;
  const units = [["onset", "s"], ...(touch ? [["peak_force", SHARED.impactUnits.AT_WALL.peak_force]] : []), ["place", "1"]];
  return touch + stops.length
    ? units.map(([key, unit]) => ({ name: `impact[1].${key}`, unit, integer: key === "place", isPlace: key === "place", words: [] })) : [];
}

/** Let some maps show the output `name`: the maps' `results` become its values or, for a place, indices in a list of all places. */
export function takeOutput(maps, name) {
  const placesIn = ({ runs }) => runs.map((values) => values?.[name]).filter(Boolean);
  maps.forEach((map) => {
    const output = map.outputs.find((one) => one.name === name);
    map.output = output.isPlace ? { ...output, places: [...new Set(maps.flatMap(placesIn))].sort() } : output;
    map.results = Array.from(map.runs, (values) => values && outputIn(values, map.output));
  });
}

/**
 * Return the outputs that a map can show: the number of impacts, the onset of the last, those of the first (`ofFirst`), the largest values
 * (`largestOf`), and the total and the dissipated energy and the position of the tip at the end of a run.
 */
export function outputsOf(scene) {
  const tip = `point[${scene.links}]`;
  const first = ["impact.count", "impact.last_time"].flatMap((name) => outputsLike(scene, name));
  const last = ["energy.total", "energy.dissipated", `${tip}.x`, `${tip}.y`].flatMap((name) => outputsLike(scene, name));
  return [...first, ...ofFirst(scene), ...largestOf(scene), ...last];
}

/** If all runs of a map fail, return why the first one does, and which parameters beside the map's two are changed in all; else "". */
export function failureOf({ names, values, faults, runs }) {
  if (faults.size < runs.length) return "";
  const changed = Object.keys(values).filter((name) => !names.includes(name));
  const others = changed.length ? ` All have changed values of ${changed.join(", ")}.` : "";
  return `All ${faults.size} runs fail; the first one: ${faults.get(0)}.${others}`;
}

/** Return the outputs of a map. Each has `rigid`: the rigid law, if any, under which the output 0 means "unknown" in a run with impacts. */
export function presentOutputs(changes) {
  return outputsOf(changes.scene).map((output) => ({ ...output, rigid: rigidLaw(changes, output.name) }));
}

/**
 * Return the rigid law of the walls if `name` is a peak force, or of the stops of joints if it is `stop.peak_moment`: an impulse has no
 * peak. The result is "" if the law is not rigid, and for all other outputs.
 */
function rigidLaw(changes, name) {
  const isForce = ["peak_force", "impact[1].peak_force", "stop.peak_moment"].includes(name);
  return isForce ? idleLaw(changes, "stiffness", name === "stop.peak_moment") : "";
}

/**
 * Return the output that a map shows first: the first of the scene's MAIN_OUTPUTS that no rigid law leaves unknown. If rigid laws leave all
 * of these unknown, the result is the number of impacts; if the scene has none of MAIN_OUTPUTS, the total energy.
 */
export function mainOutput(changes, outputs) {
  const named = (name) => outputs.filter((output) => output.name === name);
  const largest = MAIN_OUTPUTS.flatMap(named);
  return [...largest.filter(({ name }) => !rigidLaw(changes, name)), ...named(largest.length ? "impact.count" : "energy.total")][0];
}
