// The time at which two motions part.

const PARTED = 0.01; // distance of a point in one motion from the same point in the other, relative to the size of the motion
const [TIMES_COMPARED, HALVINGS] = [400, 16]; // numbers of times that are compared over the whole run, and of halvings of the interval then

/**
 * Return the first time [s] at which a point of a chain is clearly elsewhere (PARTED) in the other one of two recordings; undefined if this
 * is so at none of the compared times, which are equally spaced over the time that both last.
 */
export function partingTime(one, other) {
  const [[left, low], [right, high]] = one.view;
  const apart = PARTED * Math.max(right - left, high - low);
  const [start, end] = [Math.max(one.start, other.start), Math.min(one.end, other.end)];
  const points = Array.from({ length: Math.min(one.links, other.links) + 1 }, (_, point) => point);
  const isApart = (time) => {
    const frames = [one, other].map((recording) => recording.frameAt(time));
    return points.some((point) => {
      const [[x0, y0], [x1, y1]] = [one, other].map((recording, k) => recording.pointAt(frames[k], point));
      return Math.hypot(x1 - x0, y1 - y0) > apart;
    });
  };
  const timeOf = (sample) => start + ((end - start) * sample) / TIMES_COMPARED;
  const sample = Array.from({ length: TIMES_COMPARED + 1 }, (_, k) => k).find((k) => isApart(timeOf(k)));
  if (sample === undefined || sample === 0) return sample === 0 ? start : undefined;
  let [before, after] = [sample - 1, sample].map(timeOf);
  for (let k = 0; k < HALVINGS; k += 1) {
    const middle = (before + after) / 2;
    if (isApart(middle)) after = middle;
    else before = middle;
  }
  return after;
}
