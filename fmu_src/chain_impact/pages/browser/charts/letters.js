// The letters of compared motions on the curves of a chart.

export const LETTER_DOT = 6; // [pixels] radius of the dot around a letter
const LETTERS_FREE = 2.4; // least distance between two such dots, relative to LETTER_DOT
const PLACES_APART = 4; // [pixels] distance along a curve between the places that are tried for a dot
const FAR_FROM_CURVES = 30; // [pixels] a dot at this distance from all other curves is not better at a larger one
// horizontal positions of equally good places for the letters, relative to the width of the chart: of A, and from each letter to the next
const [LETTERS_FROM, LETTERS_APART] = [0.1, 0.19];

/**
 * Return the places along a curve, a list of positions, at distances of at most `step`, which lie inside of the box: `inset` from its
 * edges, and `half` more from those at its sides.
 */
function placesAlong(curve, step, { left, top, width, height }, inset, half = 0) {
  const side = inset + half;
  const isInside = ([x, y]) => x >= left + side && x <= left + width - side && y >= top + inset && y <= top + height - inset;
  const places = [];
  let last;
  curve.forEach((at, k) => {
    const from = curve[k - 1] ?? at;
    const length = Math.hypot(at[0] - from[0], at[1] - from[1]);
    if (length < step && last && Math.hypot(at[0] - last[0], at[1] - last[1]) < step) return;
    const count = Math.min(Math.max(1, Math.ceil(length / step)), 2000);
    for (let n = 1; n <= count; n += 1) {
      last = from.map((value, axis) => value + (n / count) * (at[axis] - value));
      if (isInside(last)) places.push(last);
    }
  });
  return places;
}

/**
 * Return the position of the letter of each of some compared curves, {course, letter, half}: where the curve is far from all other curves
 * and from the positions `taken`, to which the position is added. A curve without such a place has none (undefined) or, if it is the first
 * with its letter, the best place of those in the box, if any is. `own`: the courses of the present motion; a course is a list of
 * positions [pixels of the canvas]; `half`: half of the width of a letter beyond its dot; `box`: that of the plot; `density`: pixels of
 * the canvas for a pixel of the page.
 */
export function letterPositions(compared, own, taken, box, density) {
  const [step, far, apart] = [PLACES_APART * density, FAR_FROM_CURVES * density, LETTERS_FREE * LETTER_DOT * density];
  const tried = compared.map(({ course, half }) => placesAlong(course, step, box, LETTER_DOT * density, half));
  const present = own.map((course) => placesAlong(course, step, box, 0));
  const distance = ([x, y], places) => places.reduce((least, [px, py]) => Math.min(least, Math.hypot(px - x, py - y)), far);
  return compared.map(({ letter, half = 0 }, k) => {
    const goal = box.left + (LETTERS_FROM + LETTERS_APART * (letter.codePointAt(0) - "A".codePointAt(0))) * box.width;
    const others = [...present, ...tried.filter((_, other) => other !== k)];
    const ranked = tried[k].map((at) => ({
      at,
      isFree: taken.every(([x, y]) => Math.hypot(Math.max(0, Math.abs(x - at[0]) - 2 * half), y - at[1]) > apart),
      // among equally good places, that nearest to the goal wins
      worth: Math.min(...others.map((places) => distance(at, places)), far) - (step * Math.abs(at[0] - goal)) / box.width,
    }));
    const isFirst = compared.findIndex((other) => other.letter === letter) === k;
    const free = ranked.filter(({ isFree }) => isFree);
    const best = (free.length || !isFirst ? free : ranked).reduce((one, other) => (one && one.worth >= other.worth ? one : other), null);
    if (best) taken.push(best.at);
    return best?.at;
  });
}
