// The camera of a drawing: the map from metres to pixels.

/**
 * A map from metres to pixels, with y upwards, that shows a view in a scene of some size, below a strip of some height. If
 * the scene has more room than the view needs, the anchor gives the fraction of this room to the left of and below the view.
 */
export class Camera {
  constructor({ view: [[x0, y0], [x1, y1]], anchor: [beside, below] }, width, height, strip) {
    const room = Math.max(height - strip, 1);
    this.scale = Math.min(width / (x1 - x0), room / (y1 - y0));
    this.left = beside * (width - this.scale * (x1 - x0)) - this.scale * x0;
    this.bottom = height - below * (room - this.scale * (y1 - y0)) + this.scale * y0;
    this.rectangle = [
      [-this.left / this.scale, (this.bottom - height) / this.scale],
      [(width - this.left) / this.scale, this.bottom / this.scale],
    ];
  }

  place(x, y) {
    return [this.left + this.scale * x, this.bottom - this.scale * y];
  }

  /** Return the position in the scene [m] of a place on the screen. */
  at(left, top) {
    return [(left - this.left) / this.scale, (this.bottom - top) / this.scale];
  }
}
