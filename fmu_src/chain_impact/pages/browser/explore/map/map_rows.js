// The rows of a map that grows: the order of their simulation, and the outputs that are shown for runs not simulated yet.

import { areaOf } from "./map_scales.js";

export const POINTS = 41; // number of values of each parameter in the map
export const COARSE_POINTS = 9; // number of values of each parameter in the preview

/**
 * Return the indices of the rows of a map in the order of their simulation: row 0, then the rows ordered by the largest power of 2 that
 * divides their index, beginning with the largest power.
 */
export function rowOrder(points) {
  const largest = 2 ** Math.floor(Math.log2(Math.max(points - 1, 1)));
  const stepOf = (row) => (row === 0 ? 2 * largest : row & -row); // the largest power of 2 that divides the index of the row
  return Array.from({ length: points }, (_, row) => row).sort((a, b) => stepOf(b) - stepOf(a) || a - b);
}

/**
 * Return the outputs of all runs of a map with `points` values of each parameter. A run that is not simulated yet has the output of the
 * nearest run of the map `coarse`, which has fewer values of each parameter; if `coarse` gives none, the output in the same column of the
 * nearest simulated row; undefined if no row is simulated.
 */
export function completed({ results, points, coarse }) {
  const known = Array.from({ length: points }, (_, row) => row).filter((row) => results[row * points] !== undefined);
  return Array.from(results, (value, index) => {
    if (value !== undefined) return value;
    const [column, row] = [index % points, Math.floor(index / points)];
    const nearest = known.reduce((best, other) => (Math.abs(other - row) < Math.abs(best - row) ? other : best), known[0]);
    const before = coarseAt(coarse, column / (points - 1), row / (points - 1));
    return before === undefined ? results[nearest * points + column] : before;
  });
}

/**
 * Return the output of that run of the map `coarse` which is nearest to the fractions `shares` of both axes; undefined if there is no
 * map `coarse`, or if this run is not simulated.
 */
function coarseAt(coarse, ...shares) {
  if (!coarse) return undefined;
  const [column, row] = shares.map((share) => Math.round(share * (coarse.points - 1)));
  return coarse.results[row * coarse.points + column];
}

/** Return whether a map and a request have the same two parameters, the same ends of both axes and the same `values`. */
export function hasAreaOf(map, request) {
  const partsOf = (one) => areaOf(one) + JSON.stringify(one.values);
  return partsOf(map) === partsOf(request);
}

/** Return name → value of the two parameters of a map in the run with an index. */
export function valuesAt({ names, axes, points }, index) {
  return { [names[0]]: axes[0][index % points], [names[1]]: axes[1][Math.floor(index / points)] };
}

/**
 * Return a map as data for JSON, which `unpackedMap` reads: a run is a list of its outputs, null if it has failed, 0 without a simulation.
 */
export function packedMap({ names, axes, values, outputs, points, runs, rows, faults, known, seconds = 0 }) {
  const listOf = (all) => all && outputs.map(({ name }) => all[name] ?? null);
  return {
    names, axes, values, outputs, points, rows, seconds,
    runs: Array.from(runs, (all) => (all === undefined ? 0 : listOf(all))),
    faults: [...faults],
    known: [...known].map(([at, run]) => [at, { ...run, values: listOf(run.values) }]),
  };
}

/** Return the map of the data that `packedMap` has made. */
export function unpackedMap({ runs, faults, known, ...map }) {
  const valuesOf = (list) => list && Object.fromEntries(map.outputs.map(({ name }, k) => [name, list[k]]));
  return {
    ...map,
    runs: runs.map((list) => (list === 0 ? undefined : valuesOf(list))),
    faults: new Map(faults),
    known: new Map(known.map(([at, run]) => [at, { ...run, values: valuesOf(run.values) }])),
  };
}
