// The rate: simulated seconds per second on the screen, at most 1. The rate is smaller in and near each impact that is shown in slow
// motion, so that the impact takes a given time on the screen, and grows linearly with the distance in time from the impact, up to 1.
// The twin in Python is `recording/pacing.py`.

export const PACING = SHARED.pacing;

/** Return [onset, impactEnd] [s] of the impacts in slow motion, in the order of time; see SLOW_COUNT and SLOW_SPEED in `pacing.py`. */
export function slowSpans(impacts) {
  const fastest = [...impacts].sort((a, b) => b.linearSpeed - a.linearSpeed).slice(0, PACING.SLOW_COUNT);
  return fastest
    .filter(({ linearSpeed }) => linearSpeed >= PACING.SLOW_SPEED * fastest[0].linearSpeed)
    .map(({ onset, impactEnd }) => [onset, impactEnd])
    .sort((a, b) => a[0] - b[0]);
}

/** Return `count` equally spaced numbers from one number to another, both included. */
function between(from, to, count) {
  const step = (to - from) / (count - 1);
  return Array.from({ length: count }, (_, k) => (k < count - 1 ? from + k * step : to));
}

/** Return values at `allX`, linearly interpolated between the `values` at `nodes`; `allX` and `nodes` increase. */
function interpolated(allX, nodes, values) {
  let at = 0;
  return allX.map((x) => {
    while (at < nodes.length - 2 && nodes[at + 1] <= x) at += 1;
    return values[at] + ((values[at + 1] - values[at]) / (nodes[at + 1] - nodes[at])) * (x - nodes[at]);
  });
}

/**
 * Return the simulated times [s] of the frames from `start` to `endTime`, which have equal distances in time on the screen, and the number
 * of frames per second on the screen: about `rate`, or less if there would be more than `most` frames. `spans`: the slow impacts, from
 * `slowSpans`. On the screen, the first LONGEST_SLOW [s] of an impact in slow motion take about `impactTime` [s], or the impact's duration
 * if this is longer; an impact without duration takes less. With `impactTime` 0 nothing is slow.
 */
export function frameTimes(start, endTime, spans, impactTime, most, rate = PACING.FRAME_RATE) {
  // an impact without a duration takes a small share, INSTANT, of `impactTime`
  const shown = impactTime > 0 ? spans.map(([a, b]) =>
    [a, Math.max(a + PACING.LEAST_DURATION, Math.min(b, a + PACING.LONGEST_SLOW)), b > a ? 1 : PACING.INSTANT]) : [];
  const moments = between(start, endTime, 2 + Math.min(Math.floor((endTime - start) / PACING.FLIGHT_STEP), 2 * most));
  for (const [onset, end] of shown) {
    for (const near of PACING.RAMP_DISTANCES) moments.push(onset - PACING.SPEED_RAMP * near, end + PACING.SPEED_RAMP * near);
    for (const share of PACING.CONTACT_SHARES) moments.push(onset + (end - onset) * share);
  }
  const clipped = Float64Array.from(moments, (time) => Math.min(Math.max(time, start), endTime)).sort();
  const grid = clipped.filter((time, k) => k === 0 || time > clipped[k - 1]);
  const slowness = grid.map((time) => 1 / shown.reduce((slowest, [onset, end, share]) => {
    const distance = Math.max(0, onset - time, time - end);
    return Math.min(slowest, Math.min(1, (end - onset) / (share * impactTime)) + distance / (share * PACING.SPEED_RAMP));
  }, 1));
  // the time on the screen is the integral of 1/rate over the simulated time, by the trapezoidal rule
  const screen = new Float64Array(grid.length);
  for (let k = 1; k < grid.length; k += 1) {
    screen[k] = screen[k - 1] + ((grid[k] - grid[k - 1]) * (slowness[k] + slowness[k - 1])) / 2;
  }
  const whole = screen[screen.length - 1];
  const count = Math.min(most, 2 + Math.floor(whole * rate));
  const times = interpolated(between(0, whole, count), screen, grid);
  [times[0], times[count - 1]] = [start, endTime];
  return { times: Float64Array.from(times), frameRate: (count - 1) / whole };
}
