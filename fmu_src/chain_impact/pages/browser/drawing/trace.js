// The trace of the tip, or of the centre of a ball, on the screen: a smooth curve through the frames, with corners at impacts.

const APART = 1.5; // [pixels] least distance between positions of the trace
const OFF = 0.05; // [pixels] largest distance of the trace's curve from the straight lines with which it is drawn
// largest distance of a curve from its chord, relative to the difference between the slopes of curve and chord at one end
const BEND = 4 / 27;
const MOST_PARTS = 16; // largest number of parts of the curve between two frames
const MOST = 20_000; // largest number of positions of a trace
const CELL = 6; // [pixels] size of the cells in which the trace is searched for

/**
 * Return positions of the traced point on the screen, each at least APART from the position before, and the frame of each position; the
 * frame may have a fraction.
 */
export function traceOf(recording, camera) {
  const count = recording.time.length;
  const most = Math.min(MOST_PARTS, Math.max(1, Math.floor(MOST / count)));
  const at = Array.from(recording.time, (_, frame) => camera.toScreen(...recording.pointAt(frame, recording.traced)));
  const slopes = slopesOf(at, recording);
  const [frames, positions] = [[0], [at[0]]];
  for (let frame = 0; frame < count - 1; frame += 1) {
    const curve = curveBetween(at[frame], at[frame + 1], ...slopes[frame]);
    const parts = Math.min(most, Math.max(1, Math.ceil(Math.sqrt(curve.bend / OFF))));
    for (let part = 1; part <= parts; part += 1) {
      const [here, before] = [curve.at(part / parts), positions.at(-1)];
      if (Math.hypot(here[0] - before[0], here[1] - before[1]) >= APART) {
        frames.push(frame + part / parts);
        positions.push(here);
      }
    }
  }
  return { frames, positions };
}

/**
 * Return a function that returns whether the trace, up to a frame, enters a box [left, top, right, bottom] of a drawing with some width.
 */
export function traceFinder({ frames, positions }, width) {
  const columns = Math.ceil(width / CELL);
  const cellAt = (x, y) => columns * Math.floor(y / CELL) + Math.floor(x / CELL);
  const firstFrames = new Map(); // for each cell of the trace, the frame in which the trace first enters the cell
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
 * Return the slopes of the curve at both ends of each step between frames, in pixels per step; undefined if an impact begins
 * in the step.
 */
function slopesOf(at, recording) {
  const { time, impacts } = recording;
  const broken = new Set(impacts.map(({ onset }) => Math.floor(recording.frameAt(onset))));
  const steps = Array.from({ length: at.length - 1 }, (_, k) => broken.has(k) ? undefined : time[k + 1] - time[k]);
  const speed = (k) => [0, 1].map((axis) => (at[k + 1][axis] - at[k][axis]) / steps[k]);
  // the slope of the parabola through three frames without an impact between them
  const within = at.map((_, k) => {
    const [h0, h1] = [steps[k - 1], steps[k]];
    if (!(h0 > 0 && h1 > 0)) return undefined;
    const [before, after] = [speed(k - 1), speed(k)];
    return before.map((value, axis) => (h1 * value + h0 * after[axis]) / (h0 + h1));
  });
  return steps.map((h, k) => {
    if (!(h > 0)) return [];
    const chord = speed(k);
    // where the slope at one end is unknown, the curve is a parabola
    const other = (slope) => slope && chord.map((value, axis) => 2 * value - slope[axis]);
    const [from, to] = [within[k] ?? other(within[k + 1]), within[k + 1] ?? other(within[k])];
    return [from, to].map((slope) => (slope ?? chord).map((value) => h * value));
  });
}

/**
 * Return the cubic curve with given slopes between two positions, and its distance from the straight line; without slopes, the
 * straight line.
 */
function curveBetween(from, to, first, last) {
  const chord = [0, 1].map((axis) => to[axis] - from[axis]);
  const [start, end] = [first, last].map((slope) => (slope ?? chord).map((value, axis) => value - chord[axis]));
  return {
    bend: BEND * (Math.hypot(...start) + Math.hypot(...end)),
    at: (u) => chord.map((length, axis) => from[axis] + u * length + u * (1 - u) * ((1 - u) * start[axis] - u * end[axis])),
  };
}
