// The scale of the map's colours: the values at its ends, and whether the scale is logarithmic or has steps.
// The twin in Python is `map_colours.py`.

import { areSame } from "../../base/ticks.js";
import { axisScale } from "./map_scales.js";

// colours at equal distances along viridis, a colour map of matplotlib (CC0), as [red, green, blue]
export const VIRIDIS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
// colours of classes, which have no order: Okabe & Ito, Color Universal Design (2008), and further ones for more classes
const CLASS_COLOURS = [
  [0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66], [110, 80, 160],
];
/** The colours of runs without an output, and of runs that fail, as [red, green, blue, opacity]. */
export const [WITHOUT, FAILED] = [[128, 128, 128, 70], [128, 128, 128, 200]];
/** The colours of outputs below and above the ends of the scale, which no colour of the scale resembles. */
export const BEYOND = [[214, 190, 255], [226, 45, 45]];
const { QUANTILE_MARGIN, LARGE_QUANTILE, MOST_COLOURS, WIDE_COLOURS } = SHARED.mapColours;

const [KNOTS, LEAST_KNOTS] = [9, 4]; // number of values between which colours have equally many runs, and the least number of them

const [SPIKE, LEAST_SPIKES] = [0.15, 0.01]; // see `areJumping`
const [MOST_RUNS, CROWDED] = [0.75, 1 / 3]; // see `areCrowded`, which only the page uses

/** Return the colour for a fraction of the scale, limited to 0 to 1, as [red, green, blue], each from 0 to 255. */
export function colourAt(share) {
  const position = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const at = Math.min(Math.floor(position), VIRIDIS.length - 2);
  return VIRIDIS[at].map((part, k) => Math.round(part + (position - at) * (VIRIDIS[at + 1][k] - part)));
}

/** Return the colour of the class with a number, from 0; more classes than CLASS_COLOURS have the same colours again. */
export function classColour(number) {
  return CLASS_COLOURS[number % CLASS_COLOURS.length];
}

/** Return the colour of an output of a map: of its class, on the scale, or one of BEYOND. */
export function colourOf({ output, scale }, value) {
  if (output.places) return classColour(value);
  const end = scale.bins ? -1 : scale.ends.findIndex((limit, k) => (k ? value > limit : value < limit));
  return BEYOND[end] ?? colourAt(scale.shareOf(value));
}

/**
 * Return whether neighbouring runs jump: of three neighbours in a row or column of `points` × `points` outputs, all with outputs, the
 * middle one is often (LEAST_SPIKES) above or below both others by more than SPIKE times the range of the colours.
 */
export function areJumping({ results, points, output, scale }) {
  if (output.places || !scale) return false;
  const least = SPIKE * (scale.ends[1] - scale.ends[0]);
  const spikes = results.flatMap((value, index) => [[1, index % points], [points, Math.floor(index / points)]].map(([step, place]) => {
    const [before, after] = [index - step, index + step].map((other) => (value ?? NaN) - (results[other] ?? NaN));
    return place > 0 && place < points - 1 && before * after > 0 && Math.min(Math.abs(before), Math.abs(after)) > least;
  }));
  return spikes.filter(Boolean).length > LEAST_SPIKES * spikes.length;
}

/** Return the colour of a number that is written on a colour: black or white, by the luminance of the colour. */
export function inkOn([red, green, blue]) {
  return 0.299 * red + 0.587 * green + 0.114 * blue > 128 ? "#000" : "#fff";
}

/** Return [lower, upper] quantile of increasing values: those at 1 − LARGE_QUANTILE and at LARGE_QUANTILE. */
function quantilesOf(values) {
  return [1 - LARGE_QUANTILE, LARGE_QUANTILE].map((share) => {
    const at = share * (values.length - 1);
    const [low, high] = [Math.floor(at), Math.ceil(at)].map((index) => values[index]);
    return low + (at - Math.floor(at)) * (high - low);
  });
}

/** Return the values at both ends of the colours: at each end the extreme value or, if this is far beyond the quantile, the quantile. */
function colourEnds(values, isLogarithmic) {
  const scaled = isLogarithmic ? values.map(Math.log) : values;
  const ends = quantilesOf(scaled);
  const width = ends[1] - ends[0];
  return [0, -1].map((end, k) => {
    const isFar = width > 0 && Math.abs(scaled.at(end) - ends[k]) > QUANTILE_MARGIN * width;
    return isFar ? (isLogarithmic ? Math.exp(ends[k]) : ends[k]) : values.at(end);
  });
}

/**
 * Return at most KNOTS of the increasing `values` from `low` to `high`, the ends of the colours: about equally many values lie between two
 * of them; undefined if these are fewer than LEAST_KNOTS.
 */
function knotsOf(values, [low, high]) {
  const within = values.filter((value) => value >= low && value <= high);
  const all = Array.from({ length: KNOTS }, (_, k) => within[Math.round((k * (within.length - 1)) / (KNOTS - 1))]);
  const knots = all.filter((value, k) => k === 0 || value > all[k - 1]);
  return knots.length < LEAST_KNOTS ? undefined : knots;
}

/** Return a function from a value to a fraction of the scale of colours, on which the `knots` have equal distances. */
function shareBetween(knots) {
  return (value) => {
    const next = Math.max(knots.findIndex((knot) => knot >= value), 1);
    const [low, high] = [knots[next - 1], knots[next]];
    const at = value > knots.at(-1) ? knots.length - 1 : next - 1 + (value - low) / (high - low);
    return at / (knots.length - 1);
  };
}

/** Return whether most (MOST_RUNS) of the increasing `values` lie in a part (CROWDED) of the scale of colours at one of its ends. */
function areCrowded(values, shareOf) {
  const [low, high] = [1 - MOST_RUNS, MOST_RUNS].map((share) => shareOf(values[Math.round(share * (values.length - 1))]));
  return high < CROWDED || low > 1 - CROWDED;
}

/** Return the limits of at most MOST_COLOURS colours for counts from `least` to `most`: one limit more than colours, 0.5 below counts. */
function countBins(least, most) {
  const numbersOf = (size) => [least, most].map((value) => Math.floor(value / size));
  // widths of a colour, in counts, up to 5e14
  const sizes = Array.from({ length: 45 }, (_, k) => [1, 2, 5][k % 3] * 10 ** Math.floor(k / 3));
  const size = sizes.find((width) => numbersOf(width)[1] - numbersOf(width)[0] < MOST_COLOURS);
  const [first, last] = numbersOf(size);
  return Array.from({ length: last - first + 2 }, (_, k) => size * (first + k) - 0.5);
}

/**
 * Return the scale of the colours for the outputs of a map; null without finite outputs. It has the `extremes` of the outputs, the values
 * at the `ends` of the colours, `shareOf`, a function from a value to a fraction of the scale, and either `bins` (for different counts: the
 * limits of the colours) or `isLogarithmic`. The `asked` scale is "linear", "logarithmic", "equal" (with `knots`: values between which
 * about equally many runs lie) or "": linear or, for a wide range, logarithmic; if most runs would then look alike (`areCrowded`), equal.
 * Only positive outputs have a logarithmic scale.
 */
export function colourScale(outputs, areCounts, asked = "") {
  const values = outputs.filter(Number.isFinite).sort((a, b) => a - b);
  if (!values.length) return null;
  const extremes = [values[0], values.at(-1)];
  if (areSame(...extremes)) return { extremes, ends: extremes, isLogarithmic: false, shareOf: () => 0.5 };
  if (areCounts) {
    const bins = countBins(...extremes);
    const shareOf = (value) => bins.findLastIndex((limit) => limit < value) / (bins.length - 2);
    return { extremes, ends: [bins[0], bins.at(-1)], bins, shareOf };
  }
  const isWide = asked === "logarithmic" || (asked === "" && extremes[1] / extremes[0] >= WIDE_COLOURS);
  const isLogarithmic = extremes[0] > 0 && isWide;
  const ends = colourEnds(values, isLogarithmic);
  const { shareOf } = axisScale(...ends, isLogarithmic);
  const isEqual = asked === "equal" || (asked === "" && areCrowded(values, shareOf));
  const knots = isEqual ? knotsOf(values, ends) : undefined;
  return { extremes, ends, isLogarithmic: isLogarithmic && !knots, knots, shareOf: knots ? shareBetween(knots) : shareOf };
}
