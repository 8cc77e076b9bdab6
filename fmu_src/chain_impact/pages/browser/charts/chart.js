// The base class of all charts, which uPlot draws: axes, curves of compared motions, and a vertical line at the present time.

import { fixed, impulseText, ticksOf, withMinus } from "../base/format.js";
import { ticksBetween } from "../base/ticks.js";
import { placeText, pointName } from "../scene/words.js";
import { LETTER_DOT, letterPositions } from "./letters.js";

/** [s] time that a chart shows before and after an impact without a duration. */
export const MOMENT = 1e-3;
// least number of ticks on a vertical axis: FEWEST_TICKS or, if they would be nearer to each other than TICKS_APART, FEWEST_IF_LOW
const [FEWEST_TICKS, FEWEST_IF_LOW] = [3, 2];
const TICKS_APART = 17; // [pixels] least distance between two ticks of a vertical axis
const [ABOVE_PLOT, BELOW_PLOT] = [8, 21]; // [pixels] height of the space above the plot, and height of the axis below it
const LEAST_AXIS_WIDTH = 48; // [pixels] least width of a vertical axis, enough for most labels
const READ_STEPS = 100; // number of steps of the arrow keys along the horizontal axis of a chart
/** Lengths [pixels] of a curve of a pin that are drawn and left out in turn. */
export const DASHES_OF_PINS = [4, 4];
const [OWN_WIDTH, PIN_WIDTH] = [2, 1.3]; // [pixels] a curve of a pin is thin and dashed, so that an equal curve is seen below it
const [PALE, PALE_WIDTH] = [0.45, 3]; // opacity and width [pixels] of a curve of a pin below the present curve of the same colour
const LEAST_DRAG = 6; // [pixels] a shorter drag in an enlarged chart is a click
const LABEL_MARGIN = 4; // [pixels] free space to the left of a label of an axis
const DECIMALS_OF_LARGEST = 3; // number of decimals with which values are written if the largest of them lies between 1 and 10
const LEAST_WITH_DECIMALS = 1e-6; // if the largest absolute value is below this, values are written with exponents

/** Return the value of a colour of the style sheet, by its name. */
export function styleColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/**
 * Return the ticks of a vertical axis from `low` to `high`: round numbers (`whole`: only whole ones), few enough for their labels in a
 * chart of a `height` [pixels].
 */
export function ticksUpwards({ height }, low, high, whole) {
  const ticks = ticksBetween(low, high, FEWEST_TICKS, whole);
  const apart = ((height - ABOVE_PLOT - BELOW_PLOT) * (ticks[1] - ticks[0])) / (high - low);
  return apart >= TICKS_APART ? ticks : ticksBetween(low, high, FEWEST_IF_LOW, whole);
}

/** Return the label of a tick of a time axis [s]: all of `ticks` are in seconds or all in milliseconds. */
export function ticksText(tick, ticks) {
  const [factor, unit] = ticks.at(-1) >= 0.5 ? [1, "s"] : [1e3, "ms"];
  return withMinus(`${+(factor * tick).toPrecision(6)} ${unit}`);
}

/** Return the times from `low` to `high` whose distances from the onset are whole multiples of a step, all in [s]. */
export function timeTicks(low, high, step, onset = 0) {
  const first = Math.ceil((low - onset) / step - 1e-6);
  const count = Math.floor((high - onset) / step + 1e-6) - first + 1;
  return Array.from({ length: count }, (_, k) => onset + (first + k) * step);
}

/** Return the labels of times [s]. If an `onset` [s] is given, the labels count from it, and may be in milliseconds. */
export function timeTexts(ticks, onset) {
  if (onset === undefined) return ticksOf(ticks).map((tick) => `${withMinus(tick)} s`);
  const since = ticks.map((tick) => tick - onset);
  return since.map((time) => ticksText(Math.abs(time) < 1e-12 ? 0 : time, since));
}

/** Return the largest absolute value in some arrays, but at least `least`. */
export function largestIn(arrays, least = 0) {
  return arrays.reduce((most, values) => values.reduce((so, value) => Math.max(so, Math.abs(value)), most), least);
}

/**
 * Return a function that writes values so that they can be compared: all with as many decimals as the largest value in the arrays needs, or
 * all with exponents if this value is very small.
 */
export function writerOf(arrays) {
  const largest = largestIn(arrays);
  const isTiny = largest > 0 && largest < LEAST_WITH_DECIMALS;
  if (isTiny) return (value) => withMinus(value === 0 ? "0" : value.toExponential(DECIMALS_OF_LARGEST));
  const decimals = Math.max(DECIMALS_OF_LARGEST - Math.floor(Math.log10(largest || 1)), 0);
  return (value) => withMinus(fixed(value, decimals));
}

/**
 * Return words for a contact: the number of the impact, what touches (a point with a name by its name alone), the wall, and the impulse if
 * no peak force is known.
 */
export function contactTitle(contact) {
  const { number, peak_force, what } = contact;
  const impulse = peak_force === null ? impulseText(contact) : "";
  const place = placeText({ ...contact, what: pointName(what) ?? what });
  return `${number ? `impact\u00a0${number}: ` : ""}${place}${impulse && `, ${impulse}`}`;
}

export function axisOptions(options = {}) {
  return {
    stroke: () => styleColour("muted"),
    grid: { stroke: () => styleColour("line"), width: 1 },
    ticks: { stroke: () => styleColour("line"), width: 1, size: 4 },
    size: BELOW_PLOT,
    font: "11px system-ui, sans-serif",
    ...options,
  };
}

/**
 * Return the width of a vertical axis [pixels] that its widest label needs: the function `size` of uPlot for the axis with an `index`.
 * uPlot calls this function several times in one layout, with a number `cycle` from 0; from 2 on, the result is the axis's present width.
 */
export function labelledWidth(plot, labels, index, cycle) {
  const { _size, font, gap, ticks } = plot.axes[index];
  if (cycle > 1) return _size;
  plot.ctx.font = font[0];
  const widths = (labels ?? []).map((label) => plot.ctx.measureText(label).width / devicePixelRatio);
  return Math.ceil(Math.max(LEAST_AXIS_WIDTH, LABEL_MARGIN + Math.max(...widths) + gap + ticks.size));
}

/** A chart with a vertical line at the present time: the base class of all charts. */
export class Chart {
  compared = []; // the compared recordings, each as {recording, stroke (name of a colour), letter}
  group = [this]; // the charts that show the same part of the horizontal axis
  zoomed = undefined; // the part of the horizontal axis that the reader has chosen, [from, to]; undefined: the usual axis

  /** `pointer.seek` is called to go to a time [s], `pointer.read` to read all charts at a time [s] or, without a time, no longer. */
  constructor(element, height, pointer) {
    Object.assign(this, { element, pointer });
    this.height = element.clientHeight || height;
    new ResizeObserver(() => this.fit()).observe(element);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.plot?.redraw(false));
    this.label = document.createElement("div");
    Object.assign(this.label, { className: "reading", hidden: true });
    this.label.setAttribute("role", "status");
    this.#connect();
  }

  /**
   * Let the mouse, or the arrow keys while the chart has the focus, read values at a place of the horizontal axis; the key Enter goes to
   * the time at this place, and Escape ends the reading. In an enlarged chart, the key + shows half of the axis around this place, and −
   * the whole axis.
   */
  #connect() {
    const { element } = this;
    element.tabIndex = 0;
    element.addEventListener("pointermove", ({ clientX, buttons, pointerType }) => {
      const { left, width } = this.plot.over.getBoundingClientRect();
      const at = clientX - left;
      this.read(pointerType === "mouse" && !buttons && at >= 0 && at <= width ? this.plot.posToVal(at, "x") : undefined);
    });
    ["pointerleave", "pointerdown", "blur"].forEach((end) => element.addEventListener(end, () => this.read(undefined)));
    element.addEventListener("keydown", (event) => {
      const direction = { ArrowLeft: -1, ArrowRight: 1, Escape: 0, Enter: 0 }[event.key];
      const { min, max } = this.plot.scales.x;
      if (element.closest(".enlarged") && "+=-".includes(event.key)) {
        const [middle, half] = [Math.min(Math.max(this.reading ?? this.at ?? min, min), max), (max - min) / 4];
        this.zoom(event.key === "-" ? undefined : [Math.max(middle - half, min), Math.min(middle + half, max)]);
        event.stopPropagation(); // these keys would enlarge the drawing
      }
      if (event.key === "Escape" && this.reading === undefined) return;
      if (direction === undefined || event.shiftKey || !this.readingAt(min)) return;
      event.preventDefault();
      event.stopPropagation(); // the arrow keys would move the motion
      if (event.key === "Enter" && this.reading !== undefined) this.goTo(this.reading);
      const next = (this.reading ?? this.at ?? min) + (direction * (max - min)) / READ_STEPS;
      this.read(direction ? Math.min(Math.max(next, min), max) : undefined);
    });
  }

  /** Show a part of the horizontal axis, [from, to], in all charts of the group; without a part, the usual axis. */
  zoom(part) {
    this.group.forEach((chart) => {
      chart.zoomed = part;
      chart.element.classList.toggle("zoomed", Boolean(part));
      chart.rescale();
    });
  }

  /** Draw the chart again after a change of `zoomed`. */
  rescale() {
    this.plot?.setData(this.plot.data);
  }

  /** Let the card of the chart be large or small; only a large chart shows a part of the horizontal axis. */
  enlarge(isLarge) {
    if (!isLarge) this.zoom();
  }

  /** Go to a time on the horizontal axis. */
  goTo(time) {
    this.pointer.seek(time);
  }

  /** Return the time [s] that a value of the horizontal axis stands for, and the value that a time stands for (`placeOf`). */
  timeOf(x) {
    return x;
  }

  placeOf(time) {
    return time;
  }

  /** Return the time that a place of the plot stands for, `left` and `top` [pixels] from its upper left corner. */
  timeAt(left) {
    return this.plot.posToVal(left, "x");
  }

  /** Read all charts at the value `x` of this chart's horizontal axis; without `x`, no chart any longer. */
  read(x) {
    if (x !== undefined || this.reading !== undefined) this.pointer.read(x === undefined ? undefined : this.timeOf(x));
  }

  /**
   * Show the text of `readingAt` for a time, beside a dashed line; without a time, or at one that the horizontal axis does not show, remove
   * both.
   */
  readAt(time) {
    if (!this.plot) return;
    const x = time === undefined ? undefined : this.placeOf(time);
    const left = x === undefined ? NaN : this.plot.valToPos(x, "x");
    this.reading = x;
    const text = left >= 0 && left <= this.plot.over.clientWidth ? this.readingAt(x) : "";
    this.label.hidden = !text;
    if (!text) return;
    if (this.label.parentElement !== this.plot.over) this.plot.over.append(this.label);
    this.label.textContent = text;
    this.label.classList.toggle("at-left", left > this.plot.over.clientWidth / 2);
    this.label.style.left = `${left}px`;
  }

  /** Make a plot with options and data of uPlot, in place of the chart's present plot. */
  make(options, data) {
    const { element, height } = this;
    this.plot?.destroy();
    this.plot = new uPlot(
      {
        width: Math.max(element.clientWidth, 100),
        height,
        padding: [ABOVE_PLOT, 20, 0, 0],
        pxAlign: 0,
        cursor: { show: false },
        legend: { show: false },
        ...options,
      },
      data,
      element,
    );
    this.line = document.createElement("div");
    this.line.className = "now";
    const { over } = this.plot;
    over.append(this.line);
    this.#connectPointer(over);
  }

  /** Let a click in the plot go to a time, and a drag too; in an enlarged chart, a drag chooses a part of the horizontal axis. */
  #connectPointer(over) {
    const band = document.createElement("div");
    band.className = "band";
    let from; // where a drag in an enlarged chart began
    const at = ({ clientX, clientY }) => {
      const { left, top, width } = over.getBoundingClientRect();
      return [Math.min(Math.max(clientX - left, 0), width), clientY - top];
    };
    const endsOf = (event) => [from, at(event)[0]].sort((one, other) => one - other);
    const go = (event) => this.goTo(this.timeAt(...at(event)));
    over.addEventListener("pointerdown", (event) => {
      over.setPointerCapture(event.pointerId);
      from = over.closest(".enlarged") ? at(event)[0] : undefined;
      if (from === undefined) go(event);
    });
    over.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      if (from === undefined) return go(event);
      const [left, right] = endsOf(event);
      Object.assign(band.style, { left: `${left}px`, width: `${right - left}px` });
      over.append(band);
    });
    const endDrag = () => {
      from = undefined;
      band.remove();
    };
    over.addEventListener("pointerup", (event) => {
      if (from === undefined) return;
      const ends = endsOf(event);
      endDrag();
      if (ends[1] - ends[0] < LEAST_DRAG) go(event);
      else this.zoom(ends.map((end) => this.plot.posToVal(end, "x")));
    });
    over.addEventListener("pointercancel", endDrag);
  }

  fit() {
    if (!this.plot) return;
    const { clientWidth: width, clientHeight } = this.element;
    this.height = clientHeight || this.height;
    const { width: before, height: high } = this.plot;
    if (width > 0 && (width !== before || this.height !== high)) this.plot.setSize({ width, height: this.height });
    this.mark();
  }

  /** Move the vertical line to a value of the horizontal axis; without a value, draw the line again at its last value. */
  mark(x = this.at) {
    this.at = x;
    if (x === undefined) return;
    const left = this.plot.valToPos(x, "x");
    this.line.hidden = !(left >= -1 && left <= this.plot.over.clientWidth + 1);
    this.line.style.transform = `translateX(${left}px)`;
  }
}

/**
 * Draw the curves of compared recordings, each {points: [horizontal values, vertical values], stroke (name of a colour), letter, dash (by
 * default DASHES_OF_PINS)}, and above them their letters in dots, away from the curves `own`, points like those, and from the positions
 * `taken` on the canvas. A curve with a `badge` (name of the colour of its letter) has been drawn already; without a letter, it gets none.
 * Return the positions of the letters on the canvas.
 */
export function drawCompared(plot, curves, own, taken = []) {
  const { ctx, bbox, valToPos } = plot;
  curves.filter(({ badge }) => !badge).forEach(({ points, ...look }) => drawCurve(plot, points, look));
  const named = curves.filter(({ letter }) => letter);
  ctx.save();
  ctx.font = `700 ${1.5 * LETTER_DOT * devicePixelRatio}px system-ui, sans-serif`;
  Object.assign(ctx, { textAlign: "center", textBaseline: "middle" });
  const courseOf = ([along, up]) => Array.from(along, (x, k) => [valToPos(x, "x", true), valToPos(up[k], "y", true)]);
  const halfOf = (text) => (text.length > 1 ? Math.max(0, ctx.measureText(text).width / 2 - 0.5 * LETTER_DOT * devicePixelRatio) : 0);
  const courses = named.map(({ points, letter }) => ({ course: courseOf(points), letter, half: halfOf(letter) }));
  const positions = letterPositions(courses, own.map(courseOf), taken, bbox, devicePixelRatio);
  positions.forEach((at, k) => {
    if (!at) return;
    const [[x, y], { half }, radius] = [at, courses[k], LETTER_DOT * devicePixelRatio];
    ctx.beginPath();
    [-half, half].forEach((side) => ctx.arc(x + side, y, radius, 0, 2 * Math.PI));
    ctx.rect(x - half, y - radius, 2 * half, 2 * radius);
    ctx.fillStyle = styleColour(named[k].badge ?? named[k].stroke);
    ctx.fill();
    ctx.fillStyle = styleColour("panel");
    ctx.fillText(named[k].letter, x, y);
  });
  ctx.restore();
  return positions.filter(Boolean);
}

/**
 * Draw a curve, [horizontal values, vertical values], on a plot of uPlot. `stroke` is the name of its colour. If `fill` is the name of a
 * colour, the curve is solid, and the area that it encloses has this colour. Without `fill`, the curve has the dashes `dash`, and no area
 * is filled. A curve with a `badge` is pale and wide.
 */
export function drawCurve({ ctx, bbox, valToPos }, [along, up], { stroke, fill, badge, dash = DASHES_OF_PINS }) {
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  along.forEach((x, k) => ctx.lineTo(valToPos(x, "x", true), valToPos(up[k], "y", true)));
  ctx.setLineDash(fill ? [] : dash.map((length) => length * devicePixelRatio));
  if (fill) {
    ctx.fillStyle = styleColour(fill);
    ctx.fill();
  }
  ctx.strokeStyle = styleColour(stroke);
  if (badge) ctx.globalAlpha = PALE;
  ctx.lineWidth = (badge ? PALE_WIDTH : fill ? OWN_WIDTH : PIN_WIDTH) * devicePixelRatio;
  ctx.stroke();
  ctx.restore();
}
