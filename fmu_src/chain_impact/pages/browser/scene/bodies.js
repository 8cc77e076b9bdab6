// The shapes that the page draws: outlines of links that have points besides their ends; and the line, the carriage
// and the stops of a slider.
// The twin in Python is `scene/display/outlines.py`.

import { discOf } from "./geometry.js";

const { CARRIAGE, CIRCLE_CORNERS, FREE_END, STOP_MARK } = SHARED.bodies;

/**
 * Return one half of the convex hull of points that are sorted by x: its corners from the first point to the last, but without the last,
 * with which the other half begins (Andrew, 1979).
 */
function halfHull(points) {
  const hull = [];
  for (const [x, y] of points) {
    while (hull.length > 1) {
      const [[ax, ay], [bx, by]] = hull.slice(-2);
      if ((bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0) break;
      hull.pop();
    }
    hull.push([x, y]);
  }
  return hull.slice(0, -1);
}

/** Return the corners [x, y] of the convex hull of discs [x, y, radius] [m], each as CIRCLE_CORNERS points or, with radius 0, as one. */
function outlineOf(discs) {
  const rims = discs.flatMap(([x, y, radius]) => Array.from({ length: radius > 0 ? CIRCLE_CORNERS : 1 }, (_, k) =>
    [x + radius * Math.cos((2 * Math.PI * k) / CIRCLE_CORNERS), y + radius * Math.sin((2 * Math.PI * k) / CIRCLE_CORNERS)]));
  rims.sort(([x0, y0], [x1, y1]) => x0 - x1 || y0 - y1);
  return [...halfHull(rims), ...halfHull(rims.reverse())];
}

/**
 * Return [number, corners of the outline] of each link that has points besides its ends; the corners [m] are along the link and to its
 * left. A link end in `touching` has the radius `contact.radius`, any other end the radius 0.
 */
export function bodiesOf({ sites, contactPoints: touching }, valueOf) {
  const links = [...new Set(sites.map(({ link }) => link))];
  return links.map((link) => {
    const ends = [[0, link], [valueOf(`link[${link + 1}].length`), link + 1]];
    const discs = sites.filter((site) => site.link === link).map((site) => discOf(site, valueOf));
    return [link + 1, outlineOf([
      ...ends.map(([x, point]) => [x, 0, touching.includes(point) ? valueOf("contact.radius") : 0]),
      ...discs,
    ])];
  });
}

/**
 * Return the `lines` of a slider and its stops, its positions at the stops (`limits`), the corners of the `carriage` relative to the
 * base, and the free sides of the `stops`; null without a slider. A stop is drawn half a carriage beyond the last position that
 * the base can reach. `bases`: position of the base in each row, `size`: size of the motion [m].
 */
export function railOf(bases, size, valueOf) {
  const angle = valueOf("slider.angle");
  if (angle === undefined) return null;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [x0, y0] = bases[0];
  const reached = bases.map(([x, y]) => (x - x0) * c + (y - y0) * s);
  const at = (along, left) => [x0 + c * along - s * left, y0 + s * along + c * left];
  const half = STOP_MARK * size;
  const stops = [["slider_min", -half], ["slider_max", half]]
    .map(([name, beyond]) => [name, valueOf(name.replace("_", ".")), beyond]);
  const [low, high] = stops.map(([, position, beyond]) => (position === undefined ? undefined : position + beyond));
  const ends = [low ?? Math.min(...reached) - FREE_END * size, high ?? Math.max(...reached) + FREE_END * size];
  const ticks = [low, high].filter((end) => end !== undefined).map((end) => [-1, 1].map((side) => at(end, side * half)));
  const start = x0 * c + y0 * s;
  return {
    lines: [ends.map((end) => at(end, 0)), ...ticks],
    limits: Object.fromEntries(stops.filter(([, position]) => position !== undefined)), // name → position [m]
    carriage: CARRIAGE.map(([along, left]) =>
      [half * (c * along - s * left), half * (s * along + c * left)]),
    stops: {
      ...(low === undefined ? {} : { slider_min: { normal: [c, s], offset: start + low } }),
      ...(high === undefined ? {} : { slider_max: { normal: [-c, -s], offset: -start - high } }),
    },
  };
}
