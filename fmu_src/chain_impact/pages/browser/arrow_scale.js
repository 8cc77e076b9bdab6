// How long the arrows of forces are. The weight of a link and the peak of an impact can be a thousand times apart, and both
// are to be seen: the length grows with the cube root of the force. A ruler tells it.

import { forceText } from "./format.js";

const LONGEST_ARROW = 0.26; // of the smaller side of the scene, for the largest force
const LEAST_ARROW = 9; // pixels, so that a small force is seen
const MARKS_FROM = 6; // pixels from the foot of the ruler, nearer to which it has no marks
const LETTER = 6.5; // pixels, about the width of a letter of its numbers
const NUMBERS_APART = 6; // pixels between two numbers

export class ArrowScale {
  /** The scale for a largest force [N] in a scene of so many pixels. */
  constructor(peak, width, height) {
    Object.assign(this, { peak, longest: LONGEST_ARROW * Math.min(width, height) });
  }

  /** The length of the arrow of a force [N] in pixels; 0 where it would be too short to be seen, if that may be. */
  lengthOf(force, least = LEAST_ARROW) {
    const length = this.longest * Math.cbrt(force / this.peak);
    return least === 0 && length < LEAST_ARROW ? 0 : Math.max(least, length);
  }

  /** The powers of ten on the ruler: `at`, pixels from its foot, and `text`, for those whose numbers have room. */
  get marks() {
    const highest = Math.floor(Math.log10(this.peak));
    let free = Infinity;
    return [0, 1, 2, 3, 4, 5].map((k) => 10 ** (highest - k)).flatMap((force) => {
      const at = this.lengthOf(force, 1);
      if (at < MARKS_FROM) return [];
      const text = forceText(force, 0);
      const half = (LETTER * text.length) / 2;
      if (at + half > free) return [{ at, text: "" }];
      free = at - half - NUMBERS_APART;
      return [{ at, text }];
    });
  }
}
