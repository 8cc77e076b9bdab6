// The marks on a map: the outputs of runs as numbers, a ring at the present run, and a frame at the chosen run.

import { digits, numberText, withMinus } from "../../base/format.js";
import { colourOf, inkOn } from "./map_colours.js";
import { scaledTo } from "./map_scales.js";

const [BETWEEN, NUMBERS_ABOVE] = [10, 20]; // [pixels] least space beside a number, and least distance of two numbers above each other
const [LEAST_WIDTH, NUMBER_HEIGHT] = [34, 11]; // [pixels] least width that a number counts to have, and its height
const SIGN = 7; // [pixels] width of a sign of a number or of the label of a run
const RING_SIZE = 13; // [pixels] diameter of the ring at the present run
const MARK_RIM = 2; // [pixels] width of the mark around a run
const LABEL_PAD = 5; // [pixels] free space at both sides of the label of a run

/** Return an output as short text: the name of a place, or the number in the map's unit; the text has no unit. */
function outputText(value, { output, scale }) {
  if (output.places) return output.places[value];
  const shown = scaledTo(output, scale).factor * value;
  const size = Math.abs(shown);
  if (output.integer) return String(value);
  return withMinus(size === 0 || (size >= 1e-3 && size < 1e6) ? digits(shown) : numberText(Number(shown.toPrecision(3))));
}

/**
 * Return for the number beside the ring at [x, y]: x of the number's end at the ring (`from`), `y`, the number's `anchor`, and `middle`, x
 * of a position between ring and number. `wide`: width of a number [pixels].
 */
function ringOf([x, y], { left, width }, wide) {
  const [side, anchor] = x > left + width - wide - BETWEEN ? [-1, "end"] : [1, "start"];
  return { from: x + side * RING_SIZE, middle: x + side * 1.3 * RING_SIZE, y, anchor };
}

/** Return the corners of the mark around a cell with the middle `at` and a `size`, of which the map shows the part in `place`. */
function cellAt(at, size, { left, top, width, height }) {
  const limits = [[left, left + width], [top, top + height]];
  return [Math.max, Math.min].map((inner, end) => at.map((middle, k) =>
    inner(middle + (end - 0.5) * size[k], limits[k][end]) + (2 * end - 1) * MARK_RIM));
}

/**
 * Draw into the group `scales` the outputs of some runs as numbers, a ring with its output at the present run, and a frame with its output
 * at the run with the index `chosen`, if it is simulated. `place` is the rectangle { left, top, width, height } of the map on the screen.
 * `present` has the position `at` [x, y] of the present run and its output `value`, if it is known; null if this run is not in the map.
 */
export function markRuns(scales, map, place, { present, chosen }) {
  const { results, points } = map;
  const [width, height] = [place.width / (points - 1), place.height / (points - 1)];
  const middle = (index) => [place.left + (index % points) * width, place.top + (points - 1 - Math.floor(index / points)) * height];
  const write = (value, [x, y], kind, anchor = "middle", below = value) => scales.plain(outputText(value, map))
    .attr({ x, y: y + 4, "text-anchor": anchor, fill: inkOn(colourOf(map, below)), stroke: `rgb(${colourOf(map, below)})` })
    .addClass(`map-value ${kind}`);
  const texts = results.filter(Number.isFinite).map((value) => outputText(value, map));
  const wide = texts.reduce((most, { length }) => Math.max(most, SIGN * length), LEAST_WIDTH);
  const hasRoom = wide <= width && NUMBER_HEIGHT <= height;
  const steps = [Math.ceil((wide + BETWEEN) / width), Math.ceil(NUMBERS_ABOVE / height)];
  // an outer run has only half of a cell
  const isWritten = (number, k) => hasRoom && number > 0 && number < points - 1 && number % steps[k] === Math.floor(steps[k] / 2);
  const ring = present && ringOf(present.at, place, wide);
  const written = ring ? [[ring.middle, ring.y]] : []; // the middles of all numbers
  results.forEach((value, index) => {
    const at = middle(index);
    const isFree = !ring || Math.abs(at[0] - ring.middle) > 1.1 * (wide + BETWEEN) || Math.abs(at[1] - ring.y) > RING_SIZE;
    const isThere = isWritten(index % points, 0) && isWritten(Math.floor(index / points), 1);
    if (!isThere || !isFree || !Number.isFinite(value)) return;
    write(value, at, "");
    written.push(at);
  });
  const [x, y] = middle(chosen);
  const isOnNumber = ring && Math.abs(x - ring.from - (Math.sign(ring.from - present.at[0]) * wide) / 2) < (wide + width) / 2 + MARK_RIM
    && Math.abs(y - ring.y) < (NUMBER_HEIGHT + height) / 2 + MARK_RIM;
  const isRingChosen = ring && middle(chosen).every((at, k) => Math.abs(at - present.at[k]) < 1); // the label has the same number
  if (ring) {
    ["map-present-edge", "map-present"].forEach((kind) => scales.circle(RING_SIZE).center(...present.at).addClass(kind));
    const row = points - 1 - Math.round((ring.y - place.top) / height);
    const below = results[Math.max(row, 0) * points + Math.round((ring.middle - place.left) / width)]; // the output below the number
    if (!isRingChosen && !isOnNumber && Number.isFinite(present.value ?? NaN)) {
      write(present.value, [ring.from, ring.y], "of-present", ring.anchor, below ?? present.value);
    }
  }
  if (results[chosen] === undefined) return;
  const [[left, top], [right, bottom]] = cellAt([x, y], [width, height], place);
  ["map-present-edge", "map-present map-chosen"].forEach((kind) =>
    scales.rect(right - left, bottom - top).move(left, top).addClass(kind));
  if (!Number.isFinite(results[chosen]) || written.some((at) => at[0] === x && at[1] === y)) return; // its number is there
  writeLabel(scales, map, place, { value: results[chosen], x, y, height, written, wide });
}

/**
 * Write the output `value` of the run with the middle `x`, `y` and a `height`: above or below it, and so near that the text covers none of
 * the numbers with the middles `written` and the width `wide`, if there is such a place.
 */
function writeLabel(scales, map, { left, top, width }, { value, x, y, height, written, wide: number }) {
  const text = [outputText(value, map), scaledTo(map.output, map.scale).text].filter(Boolean).join("\u202f");
  const [wide, high] = [text.length * SIGN + 2 * LABEL_PAD, 18];
  const middle = Math.min(Math.max(x, left + wide / 2), left + width - wide / 2);
  const least = height / 2 + MARK_RIM + high / 2 + 2;
  const places = [0, 6, 12, 18, 24, 30].flatMap((more) => [y - least - more, y + least + more]).filter((at) => at - high / 2 > top);
  const covers = (at) => written.some(([across, down]) =>
    Math.abs(across - middle) < (wide + number) / 2 && Math.abs(down - at) < (high + NUMBER_HEIGHT) / 2);
  const at = places.find((one) => !covers(one)) ?? places[0];
  scales.rect(wide, high).radius(5).center(middle, at).addClass("map-label");
  scales.plain(text).attr({ x: middle, y: at + 4, "text-anchor": "middle" }).addClass("map-number map-label-text");
}
