// The view of a motion: the space that the motion needs, and the walls near it. `view.py` does the same for pictures and
// films.

import { freeRegionWithin } from "./half_planes.js";

const NEAR_WALL = 0.2; // largest distance of a wall that is shown from the motion, over the width of the motion
const ENCLOSING = 1; // largest distance of walls that together enclose the motion, over the width of the motion
const MARGIN = 0.06; // margin around the view, over the size of the view
const UPRIGHT = 0.5; // least component of a wall's normal along an axis with which the wall bounds the view on this axis
const PIN = 0.08; // height of the mark of a pinned base, over the width of the motion
const LEAST = 1e-6; // [m] size assumed for a chain that does not move
const PIN_LINES = [
  [[0, 0], [-0.4, 0.65], [0.4, 0.65], [0, 0]],
  [[-0.75, 0.65], [0.75, 0.65]],
  ...[-0.7, -0.35, 0, 0.35].map((x) => [[x, 0.65], [x + 0.25, 1]]),
];

/** Return the least and the largest of some numbers. */
function ends(numbers) {
  let [low, high] = [Infinity, -Infinity];
  for (const number of numbers) {
    low = Math.min(low, number);
    high = Math.max(high, number);
  }
  return [low, high];
}

/**
 * Return the lines of a pinned base's mark at the start, above the base if the chain is on average below it; `x` and `y`
 * contain all points.
 */
function pinLines(x, y, points) {
  const [width, height] = [x, y].map((all) => ends(all)).map(([low, high]) => high - low);
  const size = PIN * Math.max(width, height);
  let sum = 0;
  y.forEach((value, k) => {
    if (k % points) sum += value - y[k - (k % points)];
  });
  const side = sum < 0 ? 1 : -1;
  return PIN_LINES.map((line) => line.map(([dx, dy]) => [x[0] + size * dx, y[0] + side * size * dy]));
}

/** Return the corners of the free region between the walls, if it ends on all sides within ENCLOSING of the motion. */
function enclosureOf(walls, [low, high], width) {
  const around = [low.map((end) => end - ENCLOSING * width), high.map((end) => end + ENCLOSING * width)];
  const { corners } = freeRegionWithin(walls, around);
  const isInside = (corner) => corner.every((value, axis) => value > around[0][axis] && value < around[1][axis]);
  return corners.every(isInside) ? corners : [];
}

/** Return view, anchor and pin of a recording whose points are at `x` and `y`, in rows of all points. */
export function viewOf(x, y, points, walls, radius, pinned) {
  const [[left, right], [bottom, top]] = [ends(x), ends(y)];
  const reach = [[left - radius, bottom - radius], [right + radius, top + radius]];
  const width = Math.max(reach[1][0] - reach[0][0], reach[1][1] - reach[0][1]);
  const pin = pinned ? pinLines(x, y, points) : [];
  const travels = [x, y].map((all) => ends(all.filter((_, k) => k % points === 0)).map((end) => end - all[0]));
  const pins = pin.flat().flatMap((position) => [0, 1].map((end) => position.map((value, axis) => value + travels[axis][end])));
  const enclosure = enclosureOf(walls, reach, width);
  const corners = [...reach, ...pins, ...enclosure];
  const open = [[1, 1], [1, 1]]; // fractions to the left and below, to the right and above
  for (const { normal, offset } of Object.values(walls)) {
    if (!enclosure.length) {
      const corner = normal.map((part, axis) => reach[part > 0 ? 0 : 1][axis]);
      const gap = normal[0] * corner[0] + normal[1] * corner[1] - offset;
      if (!(gap >= -width && gap <= NEAR_WALL * width)) continue;
      corners.push(corner.map((value, axis) => value - Math.max(0, gap) * normal[axis]));
    }
    normal.forEach((part, axis) => {
      if (part > UPRIGHT) open[0][axis] = 0;
      if (part < -UPRIGHT) open[1][axis] = 0;
    });
  }
  const spans = [0, 1].map((axis) => ends(corners.map((corner) => corner[axis])));
  const margin = MARGIN * Math.max(...spans.map(([low, high]) => high - low), LEAST);
  return {
    view: [spans.map(([low]) => low - margin), spans.map(([, high]) => high + margin)],
    anchor: [0, 1].map((axis) => 0.5 + 0.5 * (open[0][axis] - open[1][axis])),
    pin,
  };
}
