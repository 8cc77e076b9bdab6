// The camera of a drawing: the map from metres to pixels.

// [across, up] parts of the free space that lie beyond a wall if only the other side is open, so that the motion is nearer to the middle
const BEYOND_WALL = [0.3, 0.15];
const LABEL_ROOM = 12; // [pixels] the size of a label: a number beside a wall at the edge of the view needs this room

/**
 * A map from metres, with y upwards, to pixels of a drawing, with y downwards. It shows the `view` of a recording (a rectangle in metres)
 * below the strip at the top of the drawing, whose height is `strip` [pixels], with a margin of LABEL_ROOM. If there is more room, there is
 * free space beside the view, or above and below it. The recording's `anchor` tells which of these sides are open: [1 if only the left
 * one is, 0 if only the right one is, else 0.5; the same for below and above]. Most of the free space lies at an open side. `inner` is the
 * rectangle [m] without the margin.
 */
export class Camera {
  constructor({ view: [[x0, y0], [x1, y1]], anchor }, width, height, strip) {
    const [beside, below] = anchor.map((open, axis) => BEYOND_WALL[axis] + (1 - 2 * BEYOND_WALL[axis]) * open);
    const [across, up] = [width, height - strip].map((size) => Math.max(size - 2 * LABEL_ROOM, 1));
    this.scale = Math.min(across / (x1 - x0), up / (y1 - y0));
    this.left = LABEL_ROOM + beside * (across - this.scale * (x1 - x0)) - this.scale * x0;
    this.bottom = height - LABEL_ROOM - below * (up - this.scale * (y1 - y0)) + this.scale * y0;
    this.rectangle = [
      [-this.left / this.scale, (this.bottom - height) / this.scale],
      [(width - this.left) / this.scale, this.bottom / this.scale],
    ];
    this.inner = [[LABEL_ROOM, height - LABEL_ROOM], [width - LABEL_ROOM, strip + LABEL_ROOM]].map((corner) => this.toMetres(...corner));
  }

  /** Return the position in the drawing [pixels] of a position [m]. */
  toScreen(x, y) {
    return [this.left + this.scale * x, this.bottom - this.scale * y];
  }

  /** Return the position [m] of a position in the drawing [pixels]. */
  toMetres(left, top) {
    return [(left - this.left) / this.scale, (this.bottom - top) / this.scale];
  }
}
