// The rings around recent impacts, which grow and fade, and the rule for the numbers beside them.

import { impulseText } from "../base/format.js";
import { hasImpulseOnly } from "../recording/recording.js";

const RING_TIME = 0.25; // [s] simulated time for which an impact has a ring
// [pixels] RING: diameter of a ring at the onset, and the growth of the diameter in RING_TIME; RINGS_APART: difference of the diameters of
// two rings at one position
const [RING, RINGS_APART] = [20, 7];
const SAME_POSITION = 12; // [pixels] rings that are nearer to each other count as being at one position
const OWN_DISTANCE = 0.8; // the distance of a number from its ring must be smaller than this times its distance from any other ring
const NUMBERED_PART = 0.5; // fraction of RING_TIME for which a ring has its number beside it
const PALE_OPACITY = 0.1; // a ring with a smaller opacity may lie behind a label
const MOST_RINGS = 3; // largest number of rings at one position: those of its last impacts
const IMPULSE_ARROW = 72; // [pixels] length of the arrow of the largest impulse
const NUMBERS = 8; // largest number of impacts that have their numbers at one time

/** Return the impacts that have rings at a frame: those with an onset at the time of the frame, or less than RING_TIME before. */
export function recentImpacts(recording, frame) {
  const now = recording.timeAt(frame);
  return recording.impacts.filter(({ onset }) => onset <= now && onset > now - RING_TIME);
}

/**
 * Return the rings of recent impacts at the time `now` [s]. `places` has a {position [pixels], away (direction from the wall)} for each
 * impact. A ring has the place's position and direction, the impact's `number`, `radius` [pixels], `opacity`, `isSeen` (labels keep off the
 * ring) and `isNumbered` (the number is shown). Of several rings at one position, a later impact has the larger ring at its onset;
 * at most MOST_RINGS are shown there.
 */
export function ringsOf(recent, places, now) {
  return recent.flatMap(({ onset, number }, k) => {
    const age = (now - onset) / RING_TIME;
    const [before, after] = [places.slice(0, k), places.slice(k + 1)]
      .map((others) => others.filter(({ position }) => apart(position, places[k].position) < SAME_POSITION).length);
    if (after >= MOST_RINGS) return [];
    const same = Math.min(before, MOST_RINGS - 1 - after); // number of rings at this position that began before
    return {
      ...places[k],
      number,
      radius: (RING + RINGS_APART * same + RING * Math.sqrt(age)) / 2,
      opacity: (1 - age) ** 2,
      isSeen: (1 - age) ** 2 > PALE_OPACITY,
      isNumbered: recent.length - k <= NUMBERS && age <= NUMBERED_PART,
    };
  });
}

/**
 * Return the arrows of the impulses of rigid walls at recent impacts, whose `rings` are still seen: each with the `position` and `away` of
 * its ring, its `length` [pixels] and its `text`. The lengths are in proportion to the cube roots of the impulses.
 */
export function impulsesOf({ impacts }, rings) {
  const recent = rings.filter(({ number, isSeen }) => isSeen && isImpulse(impacts[number - 1]));
  if (!recent.length) return [];
  const most = Math.max(...impacts.filter(isImpulse).map(({ impulse }) => impulse));
  return recent.map(({ number, ...ring }) => {
    const impact = impacts[number - 1];
    return { ...ring, length: IMPULSE_ARROW * Math.cbrt(impact.impulse / most), text: impulseText(impact) };
  });
}

/** Return whether an impact is an impulse of a rigid wall: neither that of a stop of a joint, nor that of a rest, which grows with time. */
const isImpulse = (impact) =>
  hasImpulseOnly(impact) && !impact.atStop && impact.impulse > 0 && Number.isFinite(impact.separation_speed ?? NaN);

/** Return a function: middle of a place for a ring's number → whether it is clearly nearer to the ring than to rings at other positions. */
export function isOwnPlace({ position }, rings) {
  const others = rings.filter((other) => apart(other.position, position) >= SAME_POSITION);
  return (middle) => others.every((other) => apart(middle, position) < OWN_DISTANCE * apart(middle, other.position));
}

function apart([x0, y0], [x1, y1]) {
  return Math.hypot(x1 - x0, y1 - y0);
}
