// The lengths of the arrows of forces. The weight of a link and the peak of an impact can differ by a factor of a thousand,
// and both must be visible: the length is proportional to the cube root of the force. A ruler shows this scale.

import { forceText } from "../base/format.js";

// largest number of powers of ten on the ruler; and length of the arrow for the largest force, relative to the smaller side of the drawing
const { DECADES, LONGEST_ARROW } = SHARED.view;
const LEAST_ARROW = 9; // [pixels] least length of an arrow, so that a small force is visible
const MARKS_FROM = 6; // [pixels] least distance of a mark from the foot of the ruler
const LETTER = 6.5; // [pixels] approximate width of a letter of the ruler's numbers
const NUMBERS_APART = 6; // [pixels] least distance between two numbers

export class ArrowScale {
  /** The scale for a largest force [N], in a drawing of a width and height [pixels]. */
  constructor(peak, width, height) {
    Object.assign(this, { peak, longest: LONGEST_ARROW * Math.min(width, height) });
  }

  /** Return the length [pixels] of a force [N] on the scale. */
  #lengthOnScale(force) {
    return this.peak > 0 ? this.longest * Math.cbrt(force / this.peak) : 0;
  }

  /** Return the length [pixels] of the arrow for a force [N], which is at least LEAST_ARROW. */
  lengthOf(force) {
    return Math.max(LEAST_ARROW, this.#lengthOnScale(force));
  }

  /** Return whether the length of a force's arrow is that of the scale, and not lengthened to LEAST_ARROW. */
  isOnScale(force) {
    return this.#lengthOnScale(force) >= LEAST_ARROW;
  }

  /**
   * Return the marks of the ruler: powers of ten whose numbers have room. `at` is the distance [pixels] of a mark from the foot of the
   * ruler, and `text` its number. If fewer than two marks have room below the largest force, the ruler continues to the next power of ten.
   */
  get marks() {
    const highest = Math.floor(Math.log10(this.peak));
    const marks = this.#marksTo(highest);
    return marks.length > 1 ? marks : this.#marksTo(highest + 1);
  }

  #marksTo(highest) {
    let free = Infinity;
    return Array.from({ length: DECADES }, (_, k) => 10 ** (highest - k)).flatMap((force) => {
      const at = this.#lengthOnScale(force);
      const text = forceText(force, 0);
      const half = (LETTER * text.length) / 2;
      if (at < MARKS_FROM || at + half > free) return [];
      free = at - half - NUMBERS_APART;
      return [{ at, text }];
    });
  }
}
