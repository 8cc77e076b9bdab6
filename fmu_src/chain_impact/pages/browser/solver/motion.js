// A motion for the player, from two runs of the kernel. The first run finds the impacts. The second run has rows at the frames, which are
// close where the motion is shown slowly, and more rows for smooth curves; rows do not change the solution.

import { mapValues } from "../base/map_values.js";
import { framesOf, impactsUntil, timesOf } from "../recording/frames.js";
import { PACING } from "../recording/pacing.js";
import { lastBefore } from "../recording/recording.js";
import { ballOf, sizeOf, VIEW } from "../recording/view.js";
import { pointText, radiusOf, STOPS, wallsAt } from "../scene/geometry.js";
import { outputCurveText } from "../scene/output_words.js";
import { boxWallText, inputText } from "../scene/words.js";
import { rowTimes } from "./kernel.js";
import { bodiesOf, railOf } from "../scene/bodies.js";

const PARTS = 100; // the rows of the first run are divided into at most this many parts, between which a newer request can replace the run
const ROWS_OF_INPUTS = 2000; // number of rows of the first run if inputs change over time, for their curves
const GOLDEN = (Math.sqrt(5) - 1) / 2;
const EVEN_ROWS = 1000; // number of rows at equal distances in the second run: about two for each pixel of a chart
// The second run has additional rows within the first impacts. MOST_REFINED_IMPACTS: number of these impacts;
// TIMES_WITHIN_IMPACT: number of additional rows in each of two parts of an impact: the part that is shown slowly, and the
// part after it. `recording/curves.py` describes the others.
const { EARLY_TIMES, MOST_REFINED_IMPACTS, LONG_CONTACT, EARLIEST_SHARE, TIMES_WITHIN_IMPACT } = SHARED.curves;

/** Return the impacts of a run of the kernel in the form that `impactsUntil` takes. */
export function impactsOf(impacts, scene, valueOf) {
  return impacts.map((impact) => {
    const { point, end } = impact;
    const wall = scene.wallNames[impact.wall];
    const atStop = scene.stops.length > 0 && STOPS.includes(wall);
    const stopped = scene.sliderStops.includes(wall) ? "slider" : atStop && `joint ${point}`;
    return {
      ...impact,
      what: stopped || pointText(new Map(scene.pointNames), point),
      wall,
      boxWall: boxWallText(wall, valueOf),
      end: Number.isFinite(end) ? end : null,
      linearSpeed: impact.impact_speed * (atStop ? valueOf(`link[${point}].length`) : 1),
      atStop,
    };
  });
}

/** Return the ranges of joints with stops: the number `joint`, both ends of its `arc`, and `marks` of the stops, as joint angles [rad]. */
function rangesOf(scene, valueOf) {
  return scene.stops.map((joint) => {
    const [low, high] = STOPS.map((stop) => valueOf(`link[${joint}].${stop}`));
    const from = low ?? high - SHARED.jointStops.OPEN_ANGLE;
    const to = Math.min(high ?? low + SHARED.jointStops.OPEN_ANGLE, from + 2 * Math.PI);
    return { joint, arc: [from, to], marks: [low, high].filter((end) => end !== undefined) };
  });
}

/**
 * Return one coordinate of all points in one array: row after row, and in each row one value for each point. `each` has an array for each
 * point, with the coordinate in all rows.
 */
function interleaved(each) {
  const rows = new Float64Array(each[0].length * each.length);
  each.forEach((column, point) => column.forEach((value, row) => {
    rows[row * each.length + point] = value;
  }));
  return rows;
}

/** Return the indices in the record of all words that the page draws: displacements of walls, coordinates of points, quantities. */
function drawnWords({ drawn: { points, groups }, moved }) {
  const entries = Object.values(groups).flat();
  return [...moved.map(({ word }) => word), ...points.flat(), ...entries.flatMap(({ words }) => Object.values(words))];
}

/**
 * Return the rows of a recording as the argument `rows` of `framesOf`. Two arguments are functions: `valueOf` from the name of a
 * parameter to its value, `column` from an index in the record to the values there in all rows.
 */
function rowsOf(scene, valueOf, { time, impacts, column }) {
  const { drawn: { points, groups }, moved } = scene;
  const [x, y] = [0, 1].map((axis) => interleaved(points.map((pair) => column(pair[axis]))));
  const size = sizeOf(x, y);
  const touching = scene.contactPoints.map((point) => [point, radiusOf(scene, valueOf, point)]);
  const largest = Math.max(0, ...touching.map(([, radius]) => radius));
  const shape = {
    links: scene.links,
    pinned: scene.pinned,
    touching,
    bodies: bodiesOf(scene, valueOf),
    rail: railOf(Array.from(time, (_, row) => [x, y].map((all) => all[row * points.length])), size, valueOf),
  };
  return {
    ...shape,
    ball: ballOf(shape, valueOf("link[1].center_of_mass"), valueOf("link[1].length")),
    name: scene.name,
    pointCount: points.length,
    time,
    x,
    y,
    drawn: mapValues(groups, (entries) => entries.map(({ n, name, words }) => ({ n, name, columns: mapValues(words, column) }))),
    impacts,
    walls: wallsAt(scene, valueOf),
    moved: Object.fromEntries(moved.map(({ ownerName, word }) => [ownerName, column(word)])),
    stops: rangesOf(scene, valueOf),
    radius: largest > VIEW.LEAST_SEEN_RADIUS * size ? largest : 0,
    pointNames: scene.pointNames,
  };
}

/**
 * Return { time, curves } of inputs for a run: of driven inputs, whose values are the run's columns, and of inputs that the reader has
 * set, by the changes `values` or with steps. A curve has `words` for its input.
 */
function inputCurves({ scene, parameters }, { time, columns }, { values, inputSteps }, valueOf) {
  const driven = scene.driven.map(({ name, unit }, k) => ({ name, unit, values: columns[k] }));
  const given = scene.inputs.filter((name) => name in values || name in inputSteps).map((name) => ({
    name,
    unit: parameters.get(name).unit,
    isStepped: true,
    values: time.map((now) => inputSteps[name]?.findLast(([from]) => from <= now)?.[1] ?? valueOf(name)),
  }));
  return { time, curves: [...driven, ...given].map((curve) => ({ ...curve, words: inputText(curve.name, valueOf) })) };
}

/**
 * Return `parts`, those of a `Recording` (null without a motion), and how the first run ended; the generator yields the fraction of both
 * runs that is done.
 *
 * @param options `curves`: the names of the outputs that are wanted over time. `inputSteps`: inputs with other values from some times on:
 * name → pairs of a time [s] and a value.
 */
export function* motion(kernel, values, { curves = [], inputSteps = {} } = {}) {
  const { scene } = kernel;
  const valueOf = (name) => {
    const parameter = kernel.parameters.get(name);
    return parameter && (values[name] ?? parameter.start);
  };
  const stopTime = valueOf("simulation.stop_time");
  const began = performance.now();
  const steps = stepsForKernel(kernel, inputSteps);
  const chosen = scene.columns.filter(({ name }) => curves.includes(name));
  const run = (number, times, outputs, timesPerCall) =>
    withProgress(kernel.run(values, times, outputs, { timesPerCall, inputSteps: steps }), number, 2);

  const firstTimes = scene.driven.length || steps.length ? unevenTimes(stopTime, ROWS_OF_INPUTS) : rowTimes(stopTime, stopTime / PARTS);
  const first = yield* run(0, firstTimes, scene.driven, Math.ceil(firstTimes.length / PARTS));
  const spent = performance.now() - began;
  const { status, part, reached, statistics, impacts } = first;
  const end = status === 0 ? stopTime : Math.min(reached, stopTime);
  const ending = { status, part, reached, statistics, impacts, spent };
  if (first.time.length === 0 || !(end > 0)) return { ...ending, parts: null };

  const shown = impactsUntil(impactsOf(impacts.filter(({ onset }) => onset <= end), scene, valueOf), end);
  const { times, frameRate } = timesOf(shown, 0, end, scene.drawn.points.length, PACING.IMPACT_TIME, frameRateOf(scene, valueOf, stopTime));
  const words = drawnWords(scene);
  const { time, columns } = yield* run(1, withFurther(times, shown), [...words.map((word) => ({ word })), ...chosen]);
  if (time.length < 2) return { ...ending, parts: null };
  const column = (word) => columns[words.indexOf(word)];
  const rows = rowsOf(scene, valueOf, { time, impacts: shown, column });
  const inputs = inputCurves(kernel, first, { values, inputSteps }, valueOf);
  const outputs = { time, curves: chosen.map(({ name, unit, integer }, k) => {
    const text = outputCurveText(name, SHARED.quantities[unit], valueOf);
    return { name, unit, isStepped: integer, values: columns[words.length + k], words: text };
  }) };
  const frames = times.slice(0, lastBefore(times, time.at(-1)) + 1);
  return { ...ending, parts: { ...framesOf(rows, { times: frames, frameRate }), inputs, outputs } };
}

/** Return inputs with steps as `run` of the kernel takes them: one step after the other, in the order of time. */
export function stepsForKernel(kernel, inputSteps) {
  const all = Object.entries(inputSteps).flatMap(([name, pairs]) =>
    pairs.map(([time, value]) => ({ time, word: kernel.parameters.get(name).word, value })));
  return all.sort((a, b) => a.time - b.time);
}

/** Return, in order, the `times` of frames [s] and, for curves, times at equal distances and times within the first impacts. */
function withFurther(times, impacts) {
  const [start, endTime] = [times[0], times.at(-1)];
  const even = Array.from({ length: EVEN_ROWS }, (_, k) => start + ((endTime - start) * k) / EVEN_ROWS);
  const inside = impacts.slice(0, MOST_REFINED_IMPACTS).flatMap(({ onset, impactEnd, end }) =>
    [[onset, impactEnd], [impactEnd, end]].filter(([from, to]) => to > from).flatMap(([from, to]) =>
      Array.from({ length: TIMES_WITHIN_IMPACT }, (_, k) => from + ((to - from) * k) / (TIMES_WITHIN_IMPACT - 1))));
  const long = impacts.slice(0, MOST_REFINED_IMPACTS).filter(({ onset, end }) => end - onset > LONG_CONTACT * (endTime - start));
  const early = long.flatMap(({ onset, end }) =>
    Array.from({ length: EARLY_TIMES }, (_, k) => onset + (end - onset) * EARLIEST_SHARE ** (1 - k / EARLY_TIMES)));
  const all = Float64Array.from([...times, ...even, ...[...inside, ...early].filter((time) => time < endTime)]).sort();
  return all.filter((time, k) => k === 0 || time > all[k - 1]);
}

/**
 * Return the wanted frames per second on the screen: FRAME_RATE or, if the fastest sine that drives an input before `stopTime` needs more,
 * as many as this sine needs.
 */
function frameRateOf({ parameters }, valueOf, stopTime) {
  const sines = parameters.filter(({ filePath }) => filePath?.[0] === "signals" && filePath[2] === "frequency").flatMap(({ name }) => {
    const lasting = stopTime - (valueOf(name.replace(/frequency$/, "start")) ?? 0);
    if (lasting <= 0 || valueOf(name.replace(/frequency$/, "amplitude")) === 0) return [];
    return [valueOf(name), valueOf(name) + lasting * valueOf(`${name}_rate`)].map(Math.abs);
  });
  return Math.max(PACING.FRAME_RATE, PACING.FRAMES_OF_A_PERIOD * Math.max(0, ...sines));
}

/**
 * Return `count` + 1 increasing times [s]: one at an uneven place in each of `count` equal intervals from 0 to `stopTime`, and `stopTime`.
 * With times at equal distances, a fast oscillation could look like a slow one, or like none.
 */
function unevenTimes(stopTime, count) {
  const times = Float64Array.from({ length: count + 1 }, (_, k) => ((k + ((k * GOLDEN) % 1)) * stopTime) / count);
  times[count] = stopTime;
  return times;
}

/** Advance a generator, the run `number` (from 0) of several `runs`; yield the fraction of all runs that is done, and return its result. */
function* withProgress(run, number, runs) {
  let step = run.next();
  while (!step.done) {
    yield (number + step.value) / runs;
    step = run.next();
  }
  return step.value;
}
