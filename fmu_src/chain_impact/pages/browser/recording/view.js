// The view of a motion: the rectangle that the motion and the walls near it need.
// The twin in Python is `recording/view.py`.

import { endsOf } from "../base/range.js";
import { freeRegionWithin } from "./free_region.js";

export const VIEW = SHARED.view;

/**
 * Return the lines of a pinned base's ground mark at the start: above the base if the mean height of all other points over the motion is
 * less than that of the base, else below the base. `x` and `y` contain the coordinates of all points in all rows.
 */
function pinLines(x, y, points) {
  const size = VIEW.PIN_HEIGHT * sizeOf(x, y);
  let sum = 0;
  y.forEach((value, k) => {
    if (k % points) sum += value - y[k - (k % points)];
  });
  const side = sum < 0 ? 1 : -1;
  return VIEW.PIN_LINES.map((line) => line.map(([dx, dy]) => [x[0] + size * dx, y[0] + side * size * dy]));
}

/**
 * Return the corners of the free region between the walls if all of it lies near the motion, else an empty list. `low`, `high`: corners of
 * the rectangle around the motion, `width`: its longer side; near means at most ROOM_DISTANCE times the width beyond this rectangle.
 */
function enclosureOf(walls, [low, high], width) {
  const around = [low.map((end) => end - VIEW.ROOM_DISTANCE * width), high.map((end) => end + VIEW.ROOM_DISTANCE * width)];
  const { corners } = freeRegionWithin(walls, around);
  const isInside = (corner) => corner.every((value, axis) => value > around[0][axis] && value < around[1][axis]);
  return corners.every(isInside) ? corners : [];
}

/**
 * Return the number of the point at the centre of a ball; null if the chain is no ball. The chain is a ball if it is free and has one link
 * without further points, and only one end of the link may touch a wall. Besides, this end must be the centre of mass, or have a radius of
 * at least the link's length. `centre` [m]: distance of the centre of mass from the link's proximal end; `length` [m]: of the link.
 */
export function ballOf({ links, pinned, rail, bodies, touching }, centre, length) {
  if (links !== 1 || pinned || rail || bodies.length || touching.length !== 1) return null;
  const [[end, radius]] = touching;
  const isCentre = Math.abs(centre - end * length) <= VIEW.SAME_LENGTH * length;
  return isCentre || radius >= length * (1 - VIEW.SAME_LENGTH) ? end : null;
}

/** Return the longer side [m] of the rectangle around all positions in a motion, given by the arrays of all x and of all y. */
export function sizeOf(x, y) {
  return Math.max(...[x, y].map((all) => endsOf(all)).map(([low, high]) => high - low));
}

/**
 * Return `view`, `anchor` (see camera.js) and `pin`, the ground mark, of a recording. `x` and `y` have the coordinates of its `points`
 * points, row after row. `radius`: the largest radius of a point; `carriage`: the corners of a carriage relative to the base.
 */
export function viewOf(x, y, points, walls, radius, pinned, carriage = []) {
  const bases = [x, y].map((all) => endsOf(all.filter((_, k) => k % points === 0)));
  const spaces = [x, y].map((all, axis) =>
    endsOf([...endsOf(all), ...carriage.flatMap((corner) => bases[axis].map((end) => end + corner[axis]))]));
  const reach = [spaces.map(([low]) => low - radius), spaces.map(([, high]) => high + radius)];
  const width = Math.max(reach[1][0] - reach[0][0], reach[1][1] - reach[0][1]);
  const pin = pinned ? pinLines(x, y, points) : [];
  const travels = [x, y].map((all, axis) => bases[axis].map((end) => end - all[0]));
  const pins = pin.flat().flatMap((position) => [0, 1].map((end) => position.map((value, axis) => value + travels[axis][end])));
  const enclosure = enclosureOf(walls, reach, width);
  const corners = [...reach, ...pins, ...enclosure];
  const open = [[1, 1], [1, 1]]; // 1: open space, 0: a wall; [[to the left, below], [to the right, above]]
  for (const { normal, offset } of Object.values(walls)) {
    if (!enclosure.length) {
      const corner = normal.map((part, axis) => reach[part > 0 ? 0 : 1][axis]);
      const gap = normal[0] * corner[0] + normal[1] * corner[1] - offset;
      if (!(gap >= -width && gap <= VIEW.WALL_DISTANCE * width)) continue;
      corners.push(corner.map((value, axis) => value - Math.max(0, gap) * normal[axis]));
    }
    normal.forEach((part, axis) => {
      if (part > VIEW.LEAST_NORMAL_COMPONENT) open[0][axis] = 0;
      if (part < -VIEW.LEAST_NORMAL_COMPONENT) open[1][axis] = 0;
    });
  }
  const spans = [0, 1].map((axis) => endsOf(corners.map((corner) => corner[axis])));
  const margin = VIEW.FILM_MARGIN * Math.max(...spans.map(([low, high]) => high - low), VIEW.LEAST_VIEW);
  return {
    view: [spans.map(([low]) => low - margin), spans.map(([, high]) => high + margin)],
    anchor: [0, 1].map((axis) => 0.5 + 0.5 * (open[0][axis] - open[1][axis])),
    pin,
  };
}
