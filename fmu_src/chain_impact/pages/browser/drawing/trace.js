// The trace of the tip, or of the centre of a ball, on the screen: a smooth curve through its positions at the frames, with corners at
// impacts.

const POINT_DISTANCE = 1.5; // [pixels] least distance between two successive points of the drawn trace
// [pixels] allowed distance of the curve from the drawn straight lines, if MOST_POINTS and MOST_PARTS allow enough lines
const CURVE_TOLERANCE = 0.05;
// largest distance of a cubic curve from its chord, divided by the difference between its slope at one end and the chord's slope (slopes in
// pixels per step between frames); the distances that follow from the two ends add up
const BEND = 4 / 27;
const MOST_PARTS = 16; // largest number of straight lines with which the curve between two frames is drawn
const MOST_POINTS = 20_000; // largest number of points of the drawn trace
const CELL = 6; // [pixels] size of the cells in which the search for the trace divides the drawing

/**
 * Return { positions, frames }. `positions` are the points of the trace on the screen, each at least POINT_DISTANCE from the point before.
 * `frames` tells for each point at which frame the tip or ball is there; the frame's number has a fraction for a point between two frames.
 */
export function traceOf(recording, camera) {
  const count = recording.time.length;
  const most = Math.min(MOST_PARTS, Math.max(1, Math.floor(MOST_POINTS / count)));
  const at = Array.from(recording.time, (_, frame) => camera.toScreen(...recording.pointAt(frame, recording.traced)));
  const slopes = slopesOf(at, recording);
  const [frames, positions] = [[0], [at[0]]];
  for (let frame = 0; frame < count - 1; frame += 1) {
    const curve = curveBetween(at[frame], at[frame + 1], ...slopes[frame]);
    const parts = Math.min(most, Math.max(1, Math.ceil(Math.sqrt(curve.bend / CURVE_TOLERANCE))));
    for (let part = 1; part <= parts; part += 1) {
      const [here, before] = [curve.at(part / parts), positions.at(-1)];
      if (Math.hypot(here[0] - before[0], here[1] - before[1]) >= POINT_DISTANCE) {
        frames.push(frame + part / parts);
        positions.push(here);
      }
    }
  }
  return { frames, positions };
}

/**
 * Return a function (rectangle [left, top, right, bottom], frame) → whether a trace, a result of `traceOf`, enters the rectangle, or comes
 * nearer to it than about CELL, up to the frame. `width`: of the drawing [pixels].
 */
export function traceFinder({ frames, positions }, width) {
  const columns = Math.ceil(width / CELL);
  const cellAt = (x, y) => columns * Math.floor(y / CELL) + Math.floor(x / CELL);
  const firstFrames = new Map(); // cell → the frame at which the trace first enters it
  const fill = () => positions.forEach(([x, y], k) => {
    const [x0, y0] = positions[Math.max(k - 1, 0)];
    const parts = Math.ceil(Math.hypot(x - x0, y - y0) / CELL) || 1;
    for (let part = 1; part <= parts; part += 1) {
      const cell = cellAt(x0 + (part / parts) * (x - x0), y0 + (part / parts) * (y - y0));
      if (!firstFrames.has(cell)) firstFrames.set(cell, frames[k]);
    }
  });
  return ([left, top, right, bottom], frame) => {
    if (!firstFrames.size) fill(); // the cells are filled at the first call, because a page may not show the trace
    for (let y = top; y < bottom + CELL; y += CELL) {
      for (let x = left; x < right + CELL; x += CELL) {
        if (firstFrames.get(cellAt(Math.min(x, right), Math.min(y, bottom))) <= frame) return true;
      }
    }
    return false;
  };
}

/**
 * Return for each step between frames the slopes [x, y] of the curve at the step's start and end [pixels per step]; an empty list if an
 * impact begins in the step or the step has no duration. `at`: position on the screen at each frame.
 */
function slopesOf(at, recording) {
  const { time, impacts } = recording;
  const broken = new Set(impacts.map(({ onset }) => Math.floor(recording.frameAt(onset))));
  const steps = Array.from({ length: at.length - 1 }, (_, k) => broken.has(k) ? undefined : time[k + 1] - time[k]);
  const speed = (k) => [0, 1].map((axis) => (at[k + 1][axis] - at[k][axis]) / steps[k]);
  // slope [pixels/s] at each frame of the parabola through the positions at this frame and its two neighbours; undefined beside an impact,
  // and at the first and the last frame
  const within = at.map((_, k) => {
    const [h0, h1] = [steps[k - 1], steps[k]];
    if (!(h0 > 0 && h1 > 0)) return undefined;
    const [before, after] = [speed(k - 1), speed(k)];
    return before.map((value, axis) => (h1 * value + h0 * after[axis]) / (h0 + h1));
  });
  return steps.map((h, k) => {
    if (!(h > 0)) return [];
    const chord = speed(k);
    // if the slope at one end is unknown, the curve of the step is a parabola; if both are unknown, a straight line
    const other = (slope) => slope && chord.map((value, axis) => 2 * value - slope[axis]);
    const [from, to] = [within[k] ?? other(within[k + 1]), within[k + 1] ?? other(within[k])];
    return [from, to].map((slope) => (slope ?? chord).map((value) => h * value));
  });
}

/**
 * Return the cubic curve between two positions with the slopes `first` and `last` at its ends: `at`, a function from the fraction of the
 * step to the position, and `bend`, a bound on the distance from the straight line. Without slopes, the curve is the straight line.
 */
function curveBetween(from, to, first, last) {
  const chord = [0, 1].map((axis) => to[axis] - from[axis]);
  const [start, end] = [first, last].map((slope) => (slope ?? chord).map((value, axis) => value - chord[axis]));
  return {
    bend: BEND * (Math.hypot(...start) + Math.hypot(...end)),
    at: (u) => chord.map((length, axis) => from[axis] + u * length + u * (1 - u) * ((1 - u) * start[axis] - u * end[axis])),
  };
}
