// The rings at recent impacts, which widen and fade, and the rule for their numbers.

const RING_TIME = 0.25; // [s] simulated time for which the position of an impact is marked
// [pixels] width of the line of a ring, and difference in width between successive rings at one position
const [RING, RINGS_APART] = [20, 7];
const SAME = 12; // [pixels] largest distance of rings that count as being at one position
const OWN = 0.8; // largest distance of a number from its ring, relative to the distance from any other ring
const NUMBERED_PART = 0.5; // part of RING_TIME for which a ring has its number beside it
const PALE = 0.1; // opacity below which a ring may lie behind a label
const NUMBERS = 8; // largest number of recent impacts with a number

/** Return the impacts that have rings at a frame. */
export function recentImpacts(recording, frame) {
  const now = recording.timeAt(frame);
  return recording.impacts.filter(({ onset }) => onset <= now && onset > now - RING_TIME);
}

/**
 * Return the rings of recent impacts at a time. `places` are {position [pixels], away}. A ring has its place, `number`, `radius` [pixels],
 * `opacity`, `isSeen` (whether labels keep off the ring) and `isNumbered` (whether it has its number). At one position, each ring begins
 * wider than the ring before.
 */
export function ringsOf(recent, places, now) {
  return recent.map(({ onset, number }, k) => {
    const age = (now - onset) / RING_TIME;
    const same = places.slice(0, k).filter(({ position }) => apart(position, places[k].position) < SAME).length;
    return {
      ...places[k],
      number,
      radius: (RING + RINGS_APART * same + RING * Math.sqrt(age)) / 2,
      opacity: (1 - age) ** 2,
      isSeen: (1 - age) ** 2 > PALE,
      isNumbered: recent.length - k <= NUMBERS && age <= NUMBERED_PART,
    };
  });
}

/** Return a function that returns whether a number, in the middle of a place, is nearer to its own ring than to any other ring. */
export function isOwnPlace({ position }, rings) {
  const others = rings.filter((other) => apart(other.position, position) >= SAME);
  return (middle) => others.every((other) => apart(middle, position) < OWN * apart(middle, other.position));
}

function apart([x0, y0], [x1, y1]) {
  return Math.hypot(x1 - x0, y1 - y0);
}
