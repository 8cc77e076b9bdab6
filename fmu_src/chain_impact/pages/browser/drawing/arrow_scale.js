// The lengths of the arrows of forces. The weight of a link and the peak of an impact can differ by a factor of a thousand,
// and both must be visible: the length is proportional to the cube root of the force, and at least LEAST_ARROW. A ruler shows the scale.
// Arrows of impulses have a scale of the same kind.
// The twin in Python is `pictures/film/arrow_scale.py`.

import { amountText } from "../base/format.js";

// DECADES: largest number of powers of ten on the ruler of forces; LONGEST_ARROW: length of the largest force's arrow, relative to the
// shorter side of the drawing
const { DECADES, LONGEST_ARROW } = SHARED.view;
const LEAST_ARROW = 9; // [pixels] length of the arrows of small forces, which would be too short to be seen
const MARKS_FROM = 6; // [pixels] least distance of a mark of the ruler from its left end
const LETTER = 6.5; // [pixels] approximate width of a letter of the ruler's numbers
const NUMBERS_APART = 6; // [pixels] least distance between two numbers

export class ArrowScale {
  /** Make the scale for forces up to the largest, `peak` [N, or another `unit`], in a drawing of some `width` and `height` [pixels]. */
  constructor(peak, width, height, unit = "N") {
    Object.assign(this, { peak, unit, longest: LONGEST_ARROW * Math.min(width, height) });
  }

  /** Return the length [pixels] that a force [N] has on the scale, however short. */
  #lengthOnScale(force) {
    return this.peak > 0 ? this.longest * Math.cbrt(force / this.peak) : 0;
  }

  /** Return the length [pixels] of the arrow for a force [N], which is at least LEAST_ARROW. */
  lengthOf(force) {
    return Math.max(LEAST_ARROW, this.#lengthOnScale(force));
  }

  /** Return whether a force's length on the scale is at least LEAST_ARROW; otherwise `lengthOf` gives LEAST_ARROW, not this length. */
  isOnScale(force) {
    return this.#lengthOnScale(force) >= LEAST_ARROW;
  }

  /**
   * Return the marks of the ruler, from right to left: of the DECADES powers of ten [N] up to the largest force, those for whose texts
   * there is room. `at` is the distance [pixels] of a mark from the ruler's left end, `text` the text of the mark's force. With fewer than
   * two marks, the ruler goes on to the next power of ten.
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
      const text = amountText(force, this.unit, 0);
      const half = (LETTER * text.length) / 2;
      if (at < MARKS_FROM || at + half > free) return [];
      free = at - half - NUMBERS_APART;
      return [{ at, text }];
    });
  }
}
