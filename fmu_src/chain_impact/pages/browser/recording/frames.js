// Computes the frames of a recording, the parts of a `Recording`, from rows of numbers.

import { STOPS } from "../scene/geometry.js";
import { frameTimes, PACING, slowSpans } from "./pacing.js";
import { placeIn } from "./recording.js";
import { viewOf } from "./view.js";

const COORDINATES = 2_000_000; // largest number of coordinates of points in all frames together, for more than FEWEST_FRAMES frames
const FEWEST_FRAMES = 200; // number of frames that a recording may have in any case

/**
 * Return the impacts in the form of a `Recording`. An unknown `end` becomes `endTime`, the end of the recording [s]. The peak force
 * becomes null if it is 0, or if the largest penetration is 0, as at a rigid wall: the force of this wall only holds the point after the
 * impulse. `impactEnd` [s] is the time at which the slow motion of an impact ends: `end` or, in a long contact, an earlier time, which
 * follows from the largest penetration and the impact speed.
 */
export function impactsUntil(impacts, endTime) {
  return impacts.map((impact) => {
    const { onset, impact_speed, peak_force, max_penetration } = impact;
    const end = impact.end ?? endTime;
    const lasting = (PACING.LONGEST_IMPACT * max_penetration) / Math.max(impact_speed, PACING.LEAST_SPEED);
    const hasForce = peak_force > 0 && max_penetration !== 0;
    return { ...impact, end, impactEnd: Math.min(end, onset + lasting), peak_force: hasForce ? peak_force : null };
  });
}

/**
 * Return the simulated times [s] of the frames from `start` to `end` [s], and the number of frames per second on the screen. `impactTime`:
 * the time [s] that an impact in slow motion takes on the screen; `rate`: wanted frames per second, which are less if there would be too
 * many frames.
 */
export function timesOf(impacts, start, end, pointCount, impactTime, rate) {
  const most = Math.min(PACING.MOST_FRAMES, Math.max(FEWEST_FRAMES, Math.floor(COORDINATES / (2 * pointCount))));
  return frameTimes(start, end, slowSpans(impacts), impactTime, most, rate);
}

/**
 * Return values at frames, interpolated between rows, from values at rows. The given array has `width` values for each row, row after row;
 * the result has `width` values for each frame, frame after frame. `places`: the place of each frame among the rows, from `placeIn`.
 */
function interpolatedColumn(values, places, width) {
  const column = new Float64Array(places.length * width);
  places.forEach(([row, share], frame) => {
    for (let k = 0; k < width; k += 1) {
      const first = values[row * width + k];
      column[frame * width + k] = first + share * (values[(row + 1) * width + k] - first);
    }
  });
  return column;
}

/** Return the first and the last frame of each span of frames in which the values are positive. */
function spansOf(values) {
  const spans = [];
  values.forEach((value, frame) => {
    if (!(value > 0)) return;
    if (spans.length && spans.at(-1)[1] === frame - 1) spans.at(-1)[1] = frame;
    else spans.push([frame, frame]);
  });
  return spans;
}

function largest(values) {
  return values.reduce((most, value) => Math.max(most, value), 0);
}

/** Return the moments at both stops of a joint, one output that is positive at joint_min, in the form of the forces of two walls. */
function ofStops({ n, columns: { moment } }) {
  return STOPS.map((wall, k) => ({ point: n, wall, force: moment.map((value) => Math.max(k ? -value : value, 0)) }));
}

/**
 * Return the parts of a `Recording`. Positions and displacements of walls are at the frames, interpolated between rows;
 * forces, energies and other drawn quantities are at the rows; sticking is spans of frames.
 *
 * @param rows the recording at its rows:
 * @param rows.name the name of the scene.
 * @param rows.links the number of links.
 * @param rows.pointCount the number of points.
 * @param rows.time the times of the rows [s].
 * @param rows.x x [m] row after row, a value for each point in each row.
 * @param rows.y y in the same order.
 * @param rows.drawn the quantities of `drawn_outputs.py`: group → entries { n, name, columns: name → a value for each row }.
 * @param rows.impacts the impacts, from `impactsUntil`.
 * @param rows.walls the free sides of the walls: name → { normal, offset [m] }.
 * @param rows.moved the displacements [m] of moving walls along their normals: name → a value for each row; may be missing.
 * @param rows.stops the joints with stops: { joint, arc, marks }.
 * @param rows.radius the largest radius [m] of a point that may touch; 0 if it is too small to be seen.
 * @param rows.ball the point at the centre of a ball; null if the chain is not a ball.
 * @param rows.touching the points that may touch: [point, its radius [m]].
 * @param rows.pointNames the points that have a name: [point, its name].
 * @param rows.bodies the links with points: [link, corners [m] in the link's axes].
 * @param rows.rail the slider: { lines, limits, carriage, stops }; null without a slider.
 * @param rows.pinned whether the base is pinned.
 * @param frames times, the times of the frames [s], and frameRate, the number of frames per second on the screen; the frames are
 *   the rows if the times are the array `rows.time` itself.
 */
export function framesOf(rows, { times, frameRate }) {
  const { name, links, pointCount, drawn, impacts, walls, stops, radius, ball, touching, pointNames, bodies, rail } = rows;
  const places = times === rows.time ? null : Array.from(times, (time) => placeIn(rows.time, time));
  const at = (values, width = 1) => (places && values ? interpolatedColumn(values, places, width) : values);
  const spansAbove = (values) => spansOf(places ? places.map(([row]) => values[row]) : values);
  const [x, y] = [rows.x, rows.y].map((all) => at(all, pointCount));
  // of a ball without a radius, the centre alone is seen
  const positions = ball === null || radius > 0 ? [x, y] : [x, y].map((all) => all.filter((_, k) => k % pointCount === ball));
  const atWalls = drawn.contacts.map(({ n, name: wall, columns }) => ({ point: n, wall, ...columns }));
  const forces = [...atWalls, ...drawn.stops.flatMap(ofStops)]
    .filter(({ force }) => force.some((value) => value > 0))
    .map(({ sticking, ...course }) => ({ ...course, spans: sticking ? spansAbove(sticking) : [] }));
  const stuckJoints = drawn.joints.map(({ n, columns: { sticking } }) => ({ joint: n, spans: spansAbove(sticking) }));
  const energies = Object.entries(drawn.energies[0]?.columns ?? {}).filter(([, values]) => values.some((value) => value !== 0))
    .sort(([a], [b]) => (a === "total") - (b === "total")); // the total energy is last, so that it is drawn above the other curves
  const peaks = [
    ...impacts.filter(({ atStop }) => !atStop).map(({ peak_force }) => peak_force ?? 0),
    ...forces.filter(({ wall }) => wall in walls || wall in (rail?.stops ?? {})).map(({ force }) => largest(force)),
    ...drawn.loads.map(({ columns: { x: along, y: up } }) => largest(along.map((value, row) => Math.hypot(value, up[row])))),
  ];
  return {
    name, links, pointCount, rowTime: rows.time, time: times, frameRate, x, y,
    energies: Object.fromEntries(energies), forces, drawn, stuckJoints, impacts,
    walls, stops, radius, ball, touching, pointNames, bodies, rail,
    traced: ball ?? links, // the point with a trace: the centre of a ball, else the tip
    moved: Object.entries(rows.moved ?? {}).map(([wall, values]) => [wall, at(values)]),
    peakForce: largest(peaks),
    ...viewOf(...positions, ball === null || radius > 0 ? pointCount : 1, walls, radius, rows.pinned, rail?.carriage),
  };
}
