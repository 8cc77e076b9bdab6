// Charts of quantities over the time of a recording or over a part of it, among them the chart of the energies.

import { byId, make } from "../base/dom.js";
import { fixed, ticksOf, withMinus } from "../base/format.js";
import { lastBefore } from "../recording/recording.js";
import {
  axisOptions, Chart, DASHES_OF_PINS, drawCompared, drawCurve, labelledWidth, largestIn, styleColour, ticksUpwards, timeTexts, timeTicks,
  writerOf,
} from "./chart.js";
import { energyOffset, movedBy, offsetText, shiftOf } from "./energy_zero.js";

const WIDTHS = { total: 2.4 };
const DENSE_TURNS = 0.4; // a curve with more turns than this for each pixel of the chart's width fills an area
const FAINT_OPACITY = 0.5; // opacity of a curve that fills an area, so that other curves are seen behind it
const MOST_BESIDE_NAMES = 3; // with more compared motions, a legend with long names has the values below them
const ENVELOPE_STEP = 2; // [pixels] width of the strips in whose extremes the envelope of such a curve has its corners
const ENVELOPE_TURNS = 5; // turns of the curve, more than two periods, over which the envelope takes its extremes
const ENVELOPE_FILL = 35; // [%] opacity of the envelope's area relative to its lines
const PARTING_MARK = 4; // [pixels] half of the width of the mark at a time at which motions part
const CURVE_APART = 0.3; // [pixels of the screen] least distance between two points of a drawn curve

/** A chart of quantities over time, with a list of their names and their values at the present time. */
export class TimeChart extends Chart {
  names = [];
  hidden = new Set(); // the names of the curves that the reader has hidden
  soft = false; // true: the vertical axis begins or ends at 0 if 0 is near the values
  isOfCounts = false; // true: the values are counts, so the ticks are whole numbers
  #isZero = false; // whether all values in view are 0, so that the axis has the tick 0 alone
  onset = undefined; // [s] the time from which the axis counts: an onset, or undefined to count from 0

  /** `entries`: element of the legend; `timeText`: element that tells the time of the legend's values. */
  constructor(element, height, entries, timeText, pointer) {
    super(element, height, pointer);
    Object.assign(this, { entries, timeText });
  }

  /** Return the time on the axis as text. */
  readingAt(time) {
    return `${withMinus(fixed(time, 4))} s`;
  }

  /** Read the chart at a time: the legend shows the values at this time or, without a time, at the present time. */
  readAt(time) {
    const { reading } = this;
    super.readAt(time);
    if (this.drawn && time !== reading) this.draw(...this.drawn);
  }

  fit() {
    const width = this.plot?.width;
    super.fit();
    if (this.plot && this.plot.width !== width) this.setData(this.plot.data); // the width decides which curves fill an area
  }

  rescale() {
    if (this.plot) this.setData(this.plot.data);
    if (this.drawn) this.draw(...this.drawn);
  }

  /** Return the first and the last time on the axis [s]: of the part that the reader or a derived class has chosen, or of the recording. */
  get span() {
    const { start, end } = this.recording;
    return this.zoomed?.[0] < end ? this.zoomed : this.close ?? [start, end];
  }

  /** Show rows of values for the curves; of a curve that turns so often in view that it fills an area, the pale envelope is shown. */
  setData(data) {
    const { clientWidth: width, clientHeight: height } = this.element;
    const pixel = largestIn(data.slice(1)) / height; // turns of less than this, such as those of round-off, are not seen
    const [first, last] = this.span.map((time) => lastBefore(data[0], time));
    data.slice(1).forEach((values, k) => {
      const turns = turnsOf(values.slice(first, last + 2), pixel);
      const alpha = turns > DENSE_TURNS * width ? FAINT_OPACITY : 1;
      Object.assign(this.plot.series[k + 1], { alpha, turns });
      this.rows[k].term.style.setProperty("--opacity", alpha);
    });
    this.plot.setData(data);
  }

  /** Return whether the curves of pins have the colours of the present curves, and are pale. */
  get arePale() {
    return false;
  }

  /** Return the curves of the compared recordings, as `drawCompared` takes them; none in this base class. */
  get comparedCurves() {
    return [];
  }

  /**
   * Make the plot of curves. A curve has a `name` and a `stroke` (a colour of the style sheet); it may have `words`, which the list shows
   * in place of the name, a `dash`, and `isStepped`: each value holds until the next row.
   */
  makeCurves(curves, data) {
    this.names = curves.map(({ name }) => name);
    const series = curves.map(({ name, stroke, dash, isStepped }) => ({
      show: !this.hidden.has(name),
      stroke: () => styleColour(stroke),
      fill: (plot, k) => (plot.series[k].alpha < 1 ? `color-mix(in srgb, ${styleColour(stroke)} ${ENVELOPE_FILL}%, transparent)` : null),
      width: WIDTHS[name] ?? 1.6,
      dash,
      points: { show: false },
      paths: isStepped ? uPlot.paths.stepped({ align: 1 }) : pathOf,
    }));
    this.make(
      {
        series: [{}, ...series],
        scales: { x: { time: false, range: () => this.span }, y: { range: (_, least, most) => this.#range(least, most) } },
        axes: [
          axisOptions({
            space: 64,
            splits: (_, axis, low, high, step) => timeTicks(low, high, step, this.onset),
            values: (_, ticks) => timeTexts(ticks, this.onset),
          }),
          axisOptions({
            size: labelledWidth,
            splits: (plot, axis, low, high) => (this.#isZero ? [0] : ticksUpwards(plot, low, high, this.isOfCounts)),
            values: (_, ticks) => ticksOf(ticks).map(withMinus),
          }),
        ],
        hooks: {
          drawAxes: [(plot) => {
            drawOnsets(plot, this.recording.impacts);
            drawPartings(plot, this.compared);
            this.comparedCurves.filter(({ badge }) => badge).forEach(({ points, ...look }) => drawCurve(plot, points, look));
          }],
          draw: [(plot) => {
            const shown = plot.data.slice(1).filter((_, k) => plot.series[k + 1].show);
            drawCompared(plot, this.comparedCurves, shown.map((values) => [plot.data[0], values]));
            if (plot === this.plot) this.mark(); // the horizontal axis may have changed, so the line at the present time is drawn again
          }],
        },
      },
      data,
    );
    this.rows = curves.map((curve) => ({ name: curve.name, term: this.#termOf("dt", curve), cells: [] }));
    this.#fillLegend();
  }

  /** Show the curves of other recordings, too, as `compared` describes them. */
  compare(recordings) {
    this.compared = recordings;
    if (!this.rows) return;
    this.#fillLegend();
    this.rescale();
  }

  /** Fill the legend: a row for each curve and, if motions are compared, a column for each motion below its dashes and its letter. */
  #fillLegend() {
    const { compared, entries, rows } = this;
    const rowOf = (term, cells) => make("div", {}, term, ...cells);
    rows.forEach((row) => {
      row.cells = Array.from({ length: 1 + compared.length }, () => make("dd"));
    });
    this.unitCell = make("dt", { className: "unit" });
    const dash = this.arePale ? undefined : DASHES_OF_PINS;
    const letters = compared.map(({ letter, stroke }) => this.#termOf("dd", { name: letter, stroke, dash }));
    const heads = compared.length ? [make("dd", { textContent: "present" }), ...letters] : [];
    entries.classList.toggle("with-motions", compared.length > 0);
    entries.classList.toggle("many-motions", compared.length > MOST_BESIDE_NAMES);
    entries.style.setProperty("--motions", 1 + compared.length);
    const head = compared.length || !this.timeText ? [rowOf(this.unitCell, heads)] : [];
    entries.replaceChildren(...head, ...rows.map(({ term, cells }) => rowOf(term, cells)));
  }

  /**
   * Return the cell of the legend for a curve, or for all curves of a compared motion: words, which are a button that hides the curves, and
   * a line that looks like them.
   */
  #termOf(tag, { name, words = name, stroke, dash }) {
    const button = make("button", { type: "button", textContent: words, ariaPressed: !this.hidden.has(name) });
    const term = make(tag, { className: "of-curve", title: words === name ? "" : name }, button);
    term.style.setProperty("--pattern", patternOf(stroke, dash));
    term.addEventListener("click", () => {
      const isShown = this.hidden.delete(name);
      if (!isShown) this.hidden.add(name);
      button.ariaPressed = isShown;
      const index = this.names.indexOf(name);
      if (index >= 0) this.plot.setSeries(index + 1, { show: isShown });
      this.rescale();
    });
    return term;
  }

  /** Return the compared motions whose curves are not hidden. */
  get shownMotions() {
    return this.compared.filter(({ letter }) => !this.hidden.has(letter));
  }

  /**
   * Write the values at the time of the pointer or, without one, at the time `present` [s]: the texts that `textsAt(k, time)` returns for
   * the curve with the index `k`, first of the present motion, then of each compared one. `unit`: their unit.
   */
  writeValues(present, unit, textsAt) {
    const { compared, timeText, unitCell, reading: time = present } = this;
    const [head, at] = [compared.length ? unit : "", `at ${withMinus(time.toFixed(5))}\u202fs`];
    if (timeText) timeText.textContent = `${unit} ${at}`;
    unitCell.textContent = timeText ? head : `${head} ${at}`;
    this.rows.forEach(({ cells }, k) => textsAt(k, time).forEach((text, n) => {
      cells[n].textContent = text;
    }));
  }

  /**
   * Return the ends of the vertical axis, between which all curves in view fit, including those of compared recordings; `least` and `most`:
   * the least and the largest value of the recording's own curves.
   */
  #range(least, most) {
    const [from, to] = this.span;
    let [low, high] = [least ?? 0, most ?? 0]; // null if all curves are hidden
    for (const { points: [times, values] } of this.comparedCurves) {
      values.forEach((value, k) => {
        if (times[k] < from || times[k] > to) return;
        low = Math.min(low, value);
        high = Math.max(high, value);
      });
    }
    this.#isZero = low === 0 && high === 0;
    return this.#isZero ? [-1, 1] : uPlot.rangeNum(low, high, 0.1, this.soft);
  }
}

/** The chart of all energies over time; the zero of the potential energy is moved to close a large gap between curves. */
export class EnergyChart extends TimeChart {
  soft = true;
  energies = {}; // name of an energy → its values as they are drawn, with the offset
  offset = 0; // [J] the number that the chart adds to the potential and the total energy (energy_zero.js)

  constructor(element, energies, pointer) {
    super(element, 180, energies, byId("energy-time"), pointer);
  }

  compare(recordings) {
    super.compare(recordings);
    this.#tellShown();
  }

  /** Tell the offset of the chart, and which curves of pins it has. */
  #tellShown() {
    const ofPins = [this.compared.length > 0 && "dashes: total of pins", this.#hasParting && "▾ motions differ from here"];
    const texts = [offsetText(this.offset), ...ofPins];
    byId("energy-offset").textContent = texts.filter(Boolean).join("; ");
  }

  get #hasParting() {
    return this.compared.some(({ parting }) => parting !== undefined);
  }

  get comparedCurves() {
    return this.shownMotions.map(({ recording: { rowTime: time, energies }, ...line }) =>
      ({ points: [time, movedBy(energies, this.offset).total ?? []], ...line }));
  }

  show(recording) {
    const names = Object.keys(recording.energies);
    const { offset: before } = this;
    this.offset = energyOffset(recording.energies);
    this.energies = movedBy(recording.energies, this.offset);
    const data = [recording.rowTime, ...Object.values(this.energies)];
    this.recording = recording;
    const isSame = names.join() === this.names.join() && this.offset === before;
    // the supplied energy has dots: where the motion repeats, its curve lies on that of the dissipated energy
    const curveOf = (name) =>
      ({ name, words: name, stroke: name, dash: name === "supplied" ? [2, 3] : undefined });
    this.#tellShown();
    if (!isSame) this.makeCurves(names.map(curveOf), data);
    this.setData(data);
    this.written = writerOf(data.slice(1));
  }

  draw(frame) {
    this.drawn = [frame];
    const { recording, compared, offset, reading } = this;
    const present = recording.timeAt(frame);
    this.mark(present);
    const valueOf = (one, name, time) => {
      const at = one === recording && reading === undefined ? frame : one.frameAt(time);
      return one.energies[name] ? this.written(one.betweenRows(one.energies[name], at) + shiftOf(name, offset)) : "–";
    };
    this.writeValues(present, "J", (k, time) =>
      [recording, ...compared.map((line) => line.recording)].map((one) => valueOf(one, this.names[k], time)));
  }
}

/** Return how often values turn from rising to falling or back; a value within `least` of the last value not skipped is skipped. */
function turnsOf(values, least) {
  let [turns, rises, from] = [0, undefined, values[0]];
  for (const value of values) {
    if (Math.abs(value - from) <= least) continue;
    const now = value > from;
    if (rises !== undefined && now !== rises) turns += 1;
    [rises, from] = [now, value];
  }
  return turns;
}

/**
 * Return the path of a curve, for the option `paths` of uPlot: straight lines between its rows. Any row except the last one is left out if
 * it is nearer than CURVE_APART, along both axes, to the latest row on the path. uPlot's own paths would be rounded to pixels if rows are
 * much denser than pixels.
 */
function pathOf(plot, series, first, last) {
  const [times, values] = [plot.data[0], plot.data[series]];
  if (plot.series[series].alpha < 1) return envelopeOf(plot, [times, values], plot.series[series].turns, [first, last + 1]);
  const stroke = new Path2D();
  let [x, y] = [-Infinity, -Infinity];
  for (let row = first; row <= last; row += 1) {
    const [left, top] = [plot.valToPos(times[row], "x", true), plot.valToPos(values[row], "y", true)];
    if (row < last && Math.abs(left - x) < CURVE_APART && Math.abs(top - y) < CURVE_APART) continue;
    stroke[x === -Infinity ? "moveTo" : "lineTo"](left, top);
    [x, y] = [left, top];
  }
  return { stroke };
}

/**
 * Return the path of a curve's envelope between two rows, the second excluded; the curve has a number of `turns` there. One line goes
 * through the largest values around narrow strips, one through the least, with an area between them. The extremes are taken over more than
 * two periods, so that the envelope of a constant amplitude is straight.
 */
function envelopeOf(plot, [times, values], turns, rows) {
  const strips = new Map(); // number of a strip → [position of its middle, least and largest vertical position in it]
  times.slice(...rows).forEach((time, k) => {
    const [strip, row] = [Math.floor(plot.valToPos(time, "x", true) / ENVELOPE_STEP), rows[0] + k];
    const y = plot.valToPos(values[row], "y", true);
    const [, high, low] = strips.get(strip) ?? [0, y, y];
    strips.set(strip, [(strip + 0.5) * ENVELOPE_STEP, Math.min(high, y), Math.max(low, y)]);
  });
  const narrow = [...strips.values()];
  const reach = Math.ceil((0.5 * ENVELOPE_TURNS * narrow.length) / Math.max(1, turns)); // [strips] at both sides
  const around = (k) => narrow.slice(Math.max(0, k - reach), k + reach + 1);
  const high = narrow.map(([x], k) => [x, Math.min(...around(k).map(([, y]) => y))]);
  const low = narrow.map(([x], k) => [x, Math.max(...around(k).map(([, , y]) => y))]);
  const [stroke, fill] = [new Path2D(), new Path2D()];
  [high, low.reverse()].forEach((line) => line.forEach((at, k) => {
    stroke[k ? "lineTo" : "moveTo"](...at);
    fill.lineTo(...at);
  }));
  return { stroke, fill };
}

/**
 * Return a background for the style sheet that looks like the line of a curve; `stroke`: name of its colour, `dash`: lengths [pixels] that
 * are drawn and left out in turn.
 */
function patternOf(stroke, dash = [1]) {
  const ends = dash.map((_, k) => dash.slice(0, k + 1).reduce((sum, length) => sum + length));
  const parts = ends.map((end, k) => `${k % 2 ? "transparent" : `var(--${stroke})`} ${end - dash[k]}px ${end}px`);
  return `repeating-linear-gradient(to right, ${parts.join(", ")})`;
}

/** Draw a mark in the colour of a pin, with a dotted line below it, on a plot of uPlot for each time at which two motions part. */
function drawPartings({ ctx, bbox: { left, top, width, height }, valToPos }, compared) {
  compared.filter(({ parting }) => parting !== undefined).forEach(({ parting, stroke }) => {
    const [x, half] = [valToPos(parting, "x", true), PARTING_MARK * devicePixelRatio];
    if (x < left || x > left + width) return;
    ctx.save();
    Object.assign(ctx, { fillStyle: styleColour(stroke), strokeStyle: styleColour(stroke), lineWidth: devicePixelRatio });
    ctx.beginPath();
    [[x - half, top], [x + half, top], [x, top + 1.6 * half]].forEach((at) => ctx.lineTo(...at));
    ctx.fill();
    ctx.setLineDash([devicePixelRatio, 3 * devicePixelRatio]);
    ctx.beginPath();
    ctx.moveTo(x, top);
    ctx.lineTo(x, top + height);
    ctx.stroke();
    ctx.restore();
  });
}

/** Draw faint vertical lines at the onsets of the impacts on a plot of uPlot. */
function drawOnsets({ ctx, bbox, valToPos }, impacts) {
  ctx.save();
  ctx.strokeStyle = styleColour("onset");
  ctx.beginPath();
  for (const { onset } of impacts) {
    const x = Math.round(valToPos(onset, "x", true)) + 0.5;
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
  }
  ctx.stroke();
  ctx.restore();
}

