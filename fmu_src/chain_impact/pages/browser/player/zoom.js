// The zoom of the drawing: by the wheel, two fingers or keys, at any place, or at the present contact.

import { byId } from "../base/dom.js";
import { Camera } from "../drawing/camera.js";
import { STRIP } from "../drawing/scale_strip.js";

const KEY_FACTOR = 1.5; // factor of one press of a key
const MOST_ENLARGED = 1e6; // largest factor
const WHEEL_RATE = 2e-3; // [1/pixel] exponent of the factor for a turn of the wheel
// half the view of a contact: number of penetrations, and limits relative to the whole view
const [HALF_DEPTHS, LEAST_HALF, MOST_HALF] = [8, 1e-4, 0.2];

/** Return the middle of two positions [pixels] and their distance; for one position the distance is 1. */
function spread([[x0, y0], [x1, y1] = [x0 + 1, y0]]) {
  return [[(x0 + x1) / 2, (y0 + y1) / 2], Math.hypot(x1 - x0, y1 - y0) || 1];
}

export class Zoom {
  #fingers = new Map(); // number of a pointer → its position in the drawing [pixels]

  constructor(player) {
    this.player = player;
    const [view, button] = [byId("view"), byId("at-contact")];
    this.button = button;
    const at = ({ clientX, clientY }) => {
      const { left, top } = view.getBoundingClientRect();
      return [clientX - left, clientY - top];
    };
    view.addEventListener("wheel", (event) => {
      // a page that scrolls keeps the wheel until the drawing is enlarged
      if (!event.ctrlKey && !player.drawing.lens && document.scrollingElement.scrollHeight > innerHeight + 1) return;
      event.preventDefault();
      this.#free().by(Math.exp(-WHEEL_RATE * event.deltaY), at(event));
    }, { passive: false });
    view.addEventListener("dblclick", () => this.fit());
    view.addEventListener("pointerdown", (event) => event.target.closest("[data-grip]") || this.#fingers.set(event.pointerId, at(event)));
    view.addEventListener("pointermove", (event) => {
      if (!this.#fingers.has(event.pointerId) || !event.buttons) return;
      const [from, size] = spread([...this.#fingers.values()]);
      this.#fingers.set(event.pointerId, at(event));
      const [to, now] = spread([...this.#fingers.values()]);
      if (now !== size || player.drawing.lens) this.#free().by(now / size, from, to);
    });
    ["pointerup", "pointercancel", "pointerleave"].forEach((end) => view.addEventListener(end, ({ pointerId }) =>
      this.#fingers.delete(pointerId)));
    button.addEventListener("click", () => {
      const isAt = button.ariaPressed === "true";
      this.fit();
      if (!isAt) this.#press(true);
    });
  }

  /** Follow the contacts, or do not follow them any more. */
  #press(isAt) {
    this.contact = undefined;
    Object.assign(this.button, { ariaPressed: isAt, title: isAt ? "Show the whole chain again (Z)" : "Enlarge the contact (Z)" });
  }

  /** Do not follow the contacts any more. */
  #free() {
    this.#press(false);
    return this;
  }

  /** Show the whole view of the recording again. */
  fit() {
    this.#free();
    this.#look(null);
  }

  press(direction) {
    this.#free().by(KEY_FACTOR ** direction);
  }

  /** Enlarge the drawing by a factor, so that what is at `from` [pixels], by default in the middle, is then at `to`. */
  by(factor, from = this.player.drawing.size.map((length) => length / 2), to = from) {
    const { drawing } = this.player;
    if (!drawing.camera) return;
    const [at, goal] = [from, to].map((position) => drawing.camera.toMetres(...position));
    const { inner } = drawing.camera;
    const view = inner.map((end) => end.map((value, axis) => at[axis] + (value - goal[axis]) / factor));
    const [width, height] = drawing.size;
    const own = new Camera(this.player.recording, width, height, STRIP).inner;
    const ratio = (own[1][0] - own[0][0]) / (view[1][0] - view[0][0]);
    if (ratio < MOST_ENLARGED) this.#look(ratio > 1 ? view : null);
  }

  #look(view) {
    byId("view").style.touchAction = view ? "none" : ""; // one finger moves an enlarged drawing, and scrolls the page otherwise
    this.player.drawing.lens = view;
    this.player.drawSoon();
  }

  /**
   * While the button is pressed, look at the place of the present contact, before the frame is drawn. The whole chain is shown while the
   * contact's point is outside this view, and at the start, where the reader may move the chain.
   */
  follow(contact, frame) {
    if (this.button.ariaPressed !== "true") return;
    const isFar = !contact || frame === 0 || !this.#isIn(contact, frame);
    this.button.classList.toggle("waits", isFar);
    const near = isFar ? undefined : contact;
    if (near === this.contact) return;
    this.contact = near;
    this.#look(near ? this.#viewOf(near) : null);
  }

  /** Return half the side [m] of the view of a contact. */
  #halfOf({ max_penetration, atStop }) {
    const [low, high] = this.player.recording.view;
    const whole = Math.max(high[0] - low[0], high[1] - low[1]);
    const wanted = atStop || !(max_penetration > 0) ? Infinity : HALF_DEPTHS * max_penetration;
    return Math.min(Math.max(wanted, LEAST_HALF * whole), MOST_HALF * whole);
  }

  /** Return whether the point of a contact is, at a frame, in the view of this contact. */
  #isIn(contact, frame) {
    const { recording } = this.player;
    const [now, then] = [frame, recording.frameAt(contact.peakTime)].map((at) => recording.pointAt(at, contact.point));
    return now.every((value, axis) => Math.abs(value - then[axis]) < this.#halfOf(contact));
  }

  #viewOf(contact) {
    const { recording } = this.player;
    const { point, wall, peakTime } = contact;
    const half = this.#halfOf(contact);
    const frame = recording.frameAt(peakTime);
    const [centre, side] = [recording.pointAt(frame, point), recording.sidesAt(frame)[wall]];
    const gap = side ? side.normal[0] * centre[0] + side.normal[1] * centre[1] - side.offset : 0;
    const middle = centre.map((value, axis) => value - gap * (side?.normal[axis] ?? 0));
    return [-half, half].map((way) => middle.map((value) => value + way));
  }
}
