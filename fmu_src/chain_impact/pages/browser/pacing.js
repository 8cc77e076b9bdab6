// How fast the simulated time passes: slower through impacts, so that they are seen. Films do the same, in `pacing.py`.
// In an impact the rate is such that it takes a given time. Before and after it the rate changes with the distance in time:
// each stretch, half as far from the impact as the one before, takes as long.

const RAMP = 0.05; // s
const LONGEST = 0.1; // s
const SHORTEST = 1e-4; // s
export const FRAME_RATE = 60; // in a second on the screen
const FLIGHT_STEP = 1 / 240; // s
const SLOW_SPEED = 0.05; // of the fastest impact
const SLOW_COUNT = 100; // impacts
const NEAR = Array.from({ length: 48 }, (_, k) => 1e-3 ** (1 - k / 47));
const WITHIN = Array.from({ length: 25 }, (_, k) => k / 24);

/** Onset and end [s] of the impacts to be shown slowly, of all with their speeds. */
export function slowSpans(impacts) {
  const fastest = [...impacts].sort((a, b) => b.endSpeed - a.endSpeed).slice(0, SLOW_COUNT);
  return fastest
    .filter(({ endSpeed }) => endSpeed >= SLOW_SPEED * fastest[0].endSpeed)
    .map(({ onset, impactEnd }) => [onset, impactEnd])
    .sort((a, b) => a[0] - b[0]);
}

/** Numbers between two, evenly. */
function between(from, to, count) {
  return Array.from({ length: count }, (_, k) => from + ((to - from) * k) / (count - 1));
}

/** The values at some places of a curve through increasing places. */
function interpolated(wanted, places, values) {
  let at = 0;
  return wanted.map((place) => {
    while (at < places.length - 2 && places[at + 1] < place) at += 1;
    const share = (place - places[at]) / (places[at + 1] - places[at] || 1);
    return values[at] + Math.min(Math.max(share, 0), 1) * (values[at + 1] - values[at]);
  });
}

/** The simulated times of frames that follow each other evenly on the screen, and how many there are in a second: a `rate`, if there are not too many. */
export function frameTimes(start, stop, spans, impactTime, most, rate = FRAME_RATE) {
  const shown = impactTime > 0 ? spans.map(([a, b]) => [a, a + Math.min(Math.max(b - a, SHORTEST), LONGEST)]) : [];
  const places = between(start, stop, 2 + Math.min(Math.floor((stop - start) / FLIGHT_STEP), 2 * most));
  for (const [onset, end] of shown) {
    for (const near of NEAR) places.push(onset - RAMP * near, end + RAMP * near);
    for (const share of WITHIN) places.push(onset + (end - onset) * share);
  }
  const clipped = Float64Array.from(places, (time) => Math.min(Math.max(time, start), stop)).sort();
  const grid = clipped.filter((time, k) => k === 0 || time > clipped[k - 1]);
  const slowness = grid.map((time) => 1 / shown.reduce((rate, [onset, end]) => {
    const distance = Math.max(0, onset - time, time - end);
    return Math.min(rate, Math.min(1, (end - onset) / impactTime) + distance / RAMP);
  }, 1));
  // the time on the screen: ∫ dt / rate, by the trapezoidal rule
  const screen = new Float64Array(grid.length);
  for (let k = 1; k < grid.length; k += 1) {
    screen[k] = screen[k - 1] + ((grid[k] - grid[k - 1]) * (slowness[k] + slowness[k - 1])) / 2;
  }
  const whole = screen[screen.length - 1];
  const count = Math.min(most, 2 + Math.floor(whole * rate));
  const times = interpolated(between(0, whole, count), screen, grid);
  [times[0], times[count - 1]] = [start, stop];
  return { times: Float64Array.from(times), frameRate: (count - 1) / whole };
}
