// Finds positions for labels at which no label covers another label, or a mark, line or ring that is reserved.

// widths of a usual letter and of a narrow one, and height of a line, relative to the size of the letters; they are approximate
const [LETTER_WIDTH, NARROW_WIDTH, LINE_HEIGHT] = [0.72, 0.42, 1.2];
const NARROW_LETTERS = /[fijlrt.,:'\s]/g;
const BESIDE_LINE = 3; // [pixels] least distance between a label and a drawn line
const BESIDE_TEXT = 8; // [pixels] least distance between two labels side by side, so that they do not read as one text
// a place at which a label would cover what labels should avoid is tried AVOIDED places (two rounds of directions) later
const AVOIDED = 16;
const FROM_EDGE = 3; // [pixels] least distance between a label and an edge of the drawing
const BESIDE_RING = 2; // [pixels] least distance between a label and the line of a ring
// [pixels] half the side of the square that is kept free around a mark, with room for the outline of a label beside it
const HALF = 7;

/**
 * Return the rectangle [left, top, right, bottom] of a text whose vertical middle is y; `anchor` says which part of the text is at x: its
 * start, middle or end.
 */
function boxOf(text, [x, y], size, anchor) {
  const narrow = text.match(NARROW_LETTERS)?.length ?? 0;
  const width = size * (LETTER_WIDTH * (text.length - narrow) + NARROW_WIDTH * narrow);
  const left = x - { start: 0, middle: 0.5, end: 1 }[anchor] * width;
  return [left, y - (LINE_HEIGHT * size) / 2, left + width, y + (LINE_HEIGHT * size) / 2];
}

/**
 * Return whether a straight line between two positions enters the rectangle of a text, enlarged by BESIDE_LINE on each side. The line does
 * if a part of it lies both between the left and the right side and between the top and the bottom of the enlarged rectangle.
 */
export function isCrossed([left, top, right, bottom], [[x0, y0], [x1, y1]]) {
  let [from, to] = [0, 1];
  for (const [start, length, low, high] of [[x0, x1 - x0, left, right], [y0, y1 - y0, top, bottom]]) {
    const ends = [low - BESIDE_LINE - start, high + BESIDE_LINE - start];
    if (length === 0 && (ends[0] > 0 || ends[1] < 0)) return false;
    if (length === 0) continue;
    const shares = ends.map((end) => end / length).sort((a, b) => a - b);
    [from, to] = [Math.max(from, shares[0]), Math.min(to, shares[1])];
  }
  return from < to;
}

/** Return whether the rectangle of a text covers a part of a ring's line, or comes nearer to it than BESIDE_RING. */
function meetsRing([left, top, right, bottom], { position: [x, y], radius }) {
  const nearest = Math.hypot(Math.max(left - x, x - right, 0), Math.max(top - y, y - bottom, 0));
  const farthest = Math.hypot(Math.max(x - left, right - x), Math.max(y - top, bottom - y));
  return nearest < radius + BESIDE_RING && farthest > radius - BESIDE_RING;
}

export class LabelSpace {
  #taken = []; // the rectangles of labels and marks that have been placed
  #rings = []; // the rings that labels must not cover: {position, radius [pixels]}
  #lines = []; // the lines that labels must not cover: [position of one end, of the other]
  #avoided = []; // functions of a rectangle that return true if it covers what labels should avoid

  /** The free space for labels in a drawing of some width and height [pixels], below a strip of some height. */
  constructor(width, height, strip) {
    this.limits = [FROM_EDGE, strip, width - FROM_EDGE, height - FROM_EDGE];
  }

  /** Keep labels away from a square around a position; `half` is half of its side [pixels]. */
  reserveAround([x, y], half = HALF) {
    this.#taken.push([x - half, y - half, x + half, y + half]);
  }

  /** Keep labels away from the line of a ring, {position, radius}. */
  reserveRing(ring) {
    this.#rings.push(ring);
  }

  /** Keep labels away from the lines that connect successive positions. */
  reserveLine(positions) {
    positions.slice(1).forEach((to, k) => this.#lines.push([positions[k], to]));
  }

  /** Let labels avoid the rectangles [left, top, right, bottom] for which `covers` returns true, unless other free places are far away. */
  avoid(covers) {
    this.#avoided.push(covers);
  }

  /**
   * Return the first of the candidates {at, anchor} at which the text's box is free (`#isFree`) and `isAllowed` accepts its middle, and
   * keep later labels off the box; undefined if there is none. A box over what labels should avoid puts the candidate AVOIDED places back.
   */
  findPosition(text, size, candidates, isAllowed = () => true) {
    let [best, least] = [undefined, Infinity];
    for (let k = 0; k < Math.min(candidates.length, least); k += 1) {
      const { at, anchor } = candidates[k];
      const box = boxOf(text, at, size, anchor);
      if (!this.#isFree(box) || !isAllowed([(box[0] + box[2]) / 2, (box[1] + box[3]) / 2])) continue;
      const rank = this.#avoided.some((covers) => covers(box)) ? k + AVOIDED : k;
      if (rank < least) [best, least] = [{ ...candidates[k], box }, rank];
    }
    if (best) this.#take(best.box);
    return best;
  }

  /** Return whether a rectangle lies in the drawing, and overlaps no placed label or mark. */
  isClear(box) {
    const [left, top, right, bottom] = this.limits;
    if (box[0] < left || box[1] < top || box[2] > right || box[3] > bottom) return false;
    return !this.#taken.some((other) => box[0] < other[2] && box[2] > other[0] && box[1] < other[3] && box[3] > other[1]);
  }

  /** Return whether a rectangle lies in the drawing, and covers no placed label, mark, ring or line. */
  #isFree(box) {
    if (!this.isClear(box)) return false;
    return !this.#rings.some((ring) => meetsRing(box, ring)) && !this.#lines.some((line) => isCrossed(box, line));
  }

  #take([left, top, right, bottom]) {
    this.#taken.push([left - BESIDE_TEXT, top, right + BESIDE_TEXT, bottom]);
  }
}

/** The positions that labels keep, relative to what they name, while one impact lasts, so that they do not jump in slow motion. */
export class KeptPositions {
  #kept = new Map(); // key of a label → its `offset` [pixels] and `anchor`
  #number; // the number of the impact

  /** Forget the positions if another impact, or none, lasts at a time. */
  follow(impacts, time) {
    const number = impacts.find(({ onset, impactEnd }) => onset <= time && time <= impactEnd)?.number;
    if (number === undefined || number !== this.#number) this.#kept.clear();
    this.#number = number;
  }

  /**
   * Return the result of `findPosition` of a `space` for the label with a `key` beside [x, y]; the kept position is tried before the
   * candidates.
   */
  findPosition(space, key, [x, y], text, size, candidates, isAllowed) {
    const kept = this.#kept.get(key);
    const first = kept ? [{ at: [x + kept.offset[0], y + kept.offset[1]], anchor: kept.anchor }] : [];
    const label = space.findPosition(text, size, [...first, ...candidates], isAllowed);
    if (label) this.#kept.set(key, { offset: [label.at[0] - x, label.at[1] - y], anchor: label.anchor });
    return label;
  }
}

/**
 * Return candidates {at, anchor} for a label around a position: first in the direction of the unit vector [dx, dy], then in directions that
 * deviate more and more from this direction, all at `distance` [pixels] times the first of `multiples`; then the same for each further
 * entry of `multiples`.
 */
export function positionsAround([x, y], [dx, dy], distance, multiples = [1, 2]) {
  const turns = [0, 1, -1, 2, -2, 3, -3, 4].map((eighth) => (eighth * Math.PI) / 4);
  return multiples.flatMap((times) => turns.map((turn) => {
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    const [wx, wy] = [c * dx - s * dy, s * dx + c * dy];
    return { at: [x + times * distance * wx, y + times * distance * wy], anchor: anchorOf(wx) };
  }));
}

/**
 * Return the attribute text-anchor of a label for a position: the end of the text that is nearer to the position or, for a label that is
 * more above or below the position than beside it, the middle. `dx`: horizontal component of the unit vector from position to label.
 */
function anchorOf(dx) {
  return Math.abs(dx) < 0.5 ? "middle" : dx > 0 ? "start" : "end";
}

/**
 * Return a unit vector on the screen, away from the chain at a point: along the link at an end, outwards at a bend, else across the links.
 */
export function outOfChain(positions, point) {
  const [x, y] = positions[point];
  const directions = [positions[point - 1], positions[point + 1]].filter(Boolean).map(([x1, y1]) => {
    const length = Math.hypot(x1 - x, y1 - y) || 1;
    return [(x1 - x) / length, (y1 - y) / length];
  });
  const bend = [0, 1].map((axis) => directions.reduce((sum, direction) => sum - direction[axis], 0));
  const size = Math.hypot(...bend);
  return size > 0.2 ? bend.map((component) => component / size) : [directions[0][1], -directions[0][0]];
}

/** Return a unit vector on the screen out of a body: from its middle to `position`, after the body is scaled to a square. */
export function outOfBody(position, corners) {
  const vector = position.map((at, axis) => {
    const reach = corners.map((corner) => corner[axis]);
    const [low, high] = [Math.min(...reach), Math.max(...reach)];
    return (2 * at - low - high) / (high - low || 1);
  });
  const size = Math.hypot(...vector) || 1;
  return vector.map((component) => component / size);
}
