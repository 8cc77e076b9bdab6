// The rings around recent impacts, which grow and fade, and the numbers beside them.

import { impulseText } from "../base/format.js";
import { hasImpulseOnly } from "../recording/recording.js";

const RING_TIME = 0.25; // [s] simulated time for which an impact has a ring
const RING = 20; // [pixels] diameter of a ring at the onset, and the growth of the diameter in RING_TIME
// [pixels] least radius of a ring that a later one leaves, and least distance between the lines of two rings
const [LEAST_RADIUS, RINGS_APART] = [7, 3];
const OWN_DISTANCE = 0.8; // the distance of a number from its ring must be smaller than this times its distance from any other ring
const NUMBERED_PART = 0.5; // fraction of RING_TIME for which a ring has its number beside it
const PALE_OPACITY = 0.1; // a ring with a smaller opacity may lie behind a label
const NUMBERS = 8; // largest number of impacts that have their numbers at one time
const SHOWN_RUNS = 3; // largest number of runs of successive numbers that stand beside a ring

/** Return the impacts that have rings at a frame: those with an onset at the time of the frame, or less than RING_TIME before. */
export function recentImpacts(recording, frame) {
  const now = recording.timeAt(frame);
  return recording.impacts.filter(({ onset }) => onset <= now && onset > now - RING_TIME);
}

/**
 * Return the rings of recent impacts at the time `now` [s], none of which meets another. `places` has a {position [pixels], away (direction
 * from the wall)} for each impact. A ring has the place's position and direction, the impact's `number`, `radius` [pixels], `opacity`,
 * `isSeen` (labels keep off the ring) and `numbers`, those that are shown beside it. Later rings leave less room to earlier ones: one that
 * has no room is left out, and the nearest ring has its number.
 */
export function ringsOf(recent, places, now) {
  const rings = [];
  for (let k = recent.length - 1; k >= 0; k -= 1) {
    const { onset, number } = recent[k];
    const age = (now - onset) / RING_TIME;
    const numbers = recent.length - k <= NUMBERS && age <= NUMBERED_PART ? [number] : [];
    const roomBeside = ({ position, radius }) => apart(position, places[k].position) - radius - RINGS_APART;
    const room = Math.min(...rings.map(roomBeside));
    if (room < LEAST_RADIUS) rings.find((ring) => roomBeside(ring) === room).numbers.unshift(...numbers);
    else {
      const radius = Math.min((RING + RING * Math.sqrt(age)) / 2, room);
      rings.unshift({ ...places[k], number, numbers, radius, opacity: (1 - age) ** 2, isSeen: (1 - age) ** 2 > PALE_OPACITY });
    }
  }
  return rings;
}

/** Return the numbers of impacts, in ascending order, as text such as "#7, 9–11"; only the last SHOWN_RUNS runs of successive numbers. */
export function numbersText(numbers) {
  const runs = [];
  for (const number of numbers) {
    if (runs.at(-1)?.at(-1) === number - 1) runs.at(-1).push(number);
    else runs.push([number]);
  }
  const parts = runs.map((run) => (run.length > 2 ? `${run[0]}–${run.at(-1)}` : run.join(", ")));
  return `#${parts.slice(-SHOWN_RUNS).join(", ")}`;
}

/**
 * Return the impulses of rigid walls at recent impacts, whose `rings` are still seen: each with the `position` and `away` of its ring, its
 * `impulse` [N·s] and its `text`.
 */
export function impulsesOf({ impacts }, rings) {
  return rings.map(({ number, ...ring }) => ({ ...ring, impact: impacts[number - 1] }))
    .filter(({ impact, isSeen }) => isSeen && isImpulse(impact))
    .map(({ impact, ...ring }) => ({ ...ring, impulse: impact.impulse, text: impulseText(impact) }));
}

/** Return the largest impulse of rigid walls [N·s], or 0 without any. */
export function largestImpulse({ impacts }) {
  return Math.max(0, ...impacts.filter(isImpulse).map(({ impulse }) => impulse));
}

/** Return whether an impact is an impulse of a rigid wall: neither that of a stop of a joint, nor that of a rest, which grows with time. */
const isImpulse = (impact) =>
  hasImpulseOnly(impact) && !impact.atStop && impact.impulse > 0 && Number.isFinite(impact.separation_speed ?? NaN);

/** Return a function: middle of a place for the numbers of a ring → whether it is clearly nearer to the ring than to any other. */
export function isOwnPlace(ring, rings) {
  const others = rings.filter((other) => other !== ring);
  return (middle) => others.every((other) => apart(middle, ring.position) < OWN_DISTANCE * apart(middle, other.position));
}

function apart([x0, y0], [x1, y1]) {
  return Math.hypot(x1 - x0, y1 - y0);
}
