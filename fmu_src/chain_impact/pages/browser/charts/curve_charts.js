// Charts of curves over time, one chart for each unit: curves of driven inputs, and of the outputs that the reader chooses.

import { make } from "../base/dom.js";
import { placeIn, valueAtPlace } from "../recording/recording.js";
import { shownUpTo } from "../scene/angles.js";
import { contactTitle, largestIn, MOMENT, writerOf } from "./chart.js";
import { TimeChart } from "./time_chart.js";

const INPUT_COLOURS = 6; // number of colours for curves that the style sheet has
// The dashes of curves: lengths [pixels] that are drawn and left out in turn. Each of the first INPUT_COLOURS curves has its own colour
// and its own dash, because two colours may look alike; each time the colours begin again, the dashes begin one entry of DASHES later.
const DASHES = [undefined, [7, 3], [2, 3], [10, 3, 2, 3], [16, 4], [7, 3, 2, 3, 2, 3]];
/** MOST_CURVES: largest number of chosen outputs with the same unit; MOST_UNITS: largest number of different units of chosen outputs. */
export const [MOST_CURVES, MOST_UNITS] = [3 * INPUT_COLOURS, 8];
const LONGEST_MARK = 10; // [characters] longer words of a curve do not stand beside the letter of a pin
const ROUND_OFF = 1e-12; // a value below this times the largest value of its unit is round-off, and is shown as 0

/** Return the curves with 0 in place of values that are round-off beside the larger of `largest` and the curves' largest absolute value. */
function withoutRoundOff(curves, largest) {
  const scale = largestIn(curves.map(({ values }) => values), largest);
  return curves.map((curve) => ({ ...curve, values: curve.values.map((value) => (Math.abs(value) < ROUND_OFF * scale ? 0 : value)) }));
}

/**
 * Return the group of an output as a pattern that the names of all its members match. In a group of names with numbers in brackets, names
 * differ only in these numbers (point[*].y); in any other group, they have the same part before the first dot (energy.*).
 */
export function groupOf(name) {
  const group = name.replaceAll(/\[\d+\]/g, "[*]");
  return group === name ? name.replace(/\..*/, ".*") : group;
}

const isCount = ({ values, isStepped }) => isStepped && values.every(Number.isInteger);

/** Return for each curve a function that writes its values. The curves of a group share a function; counts are written as whole numbers. */
export function writersOf(curves) {
  const measured = curves.filter((curve) => !isCount(curve));
  const valuesIn = (group) => measured.filter(({ name }) => groupOf(name) === group).map(({ values }) => values);
  const writers = new Map([...new Set(measured.map(({ name }) => groupOf(name)))].map((group) => [group, writerOf(valuesIn(group))]));
  return curves.map((curve) => (isCount(curve) ? String : writers.get(groupOf(curve.name))));
}

/**
 * Return for each curve of a chart a short text that tells it from the others: its number, its axis, both, or its words; "" if the words
 * are long.
 */
export function marksOf(curves) {
  const parts = curves.map(({ name }) => [/\[(\d+)\]/.exec(name)?.[1] ?? "", /\.[va]?([xy])$/.exec(name)?.[1] ?? ""]);
  const short = curves.map(({ words }) => (words.length > LONGEST_MARK ? "" : words));
  const choices = [parts.map(([number]) => number), parts.map(([, axis]) => axis), parts.map((both) => both.join("\u200a"))];
  return choices.find((texts) => new Set(texts).size === texts.length) ?? short;
}

/** A chart of all curves with one unit, or of one curve. */
class UnitChart extends TimeChart {
  /** The curve of a pin has the look of its pin or, beside those of other outputs, the colour and the dashes of its output. */
  get arePale() {
    return this.names.length > 1;
  }

  get comparedCurves() {
    const [{ arePale, span: [from, to] }, marks] = [this, marksOf(this.curves)];
    return this.shownMotions.flatMap(({ recording, letter, stroke, ...line }) => {
      const { time, curves } = this.curvesOf(recording) ?? { curves: [] };
      return curves.filter(({ name }) => this.names.includes(name) && !this.hidden.has(name)).map(({ name, values }) => {
        const points = [time, values.map((value) => this.factor * value)];
        if (!arePale) return { points, letter, stroke, ...line };
        const [k, isZero] = [this.names.indexOf(name), values.every((value, row) => value === 0 || time[row] < from || time[row] > to)];
        const { stroke: own, dash = [] } = this.curves[k];
        return { points, letter: isZero ? "" : `${letter}\u200a${marks[k]}`.trim(), stroke: own, dash, badge: stroke };
      });
    });
  }

  show(recording, curves) {
    const [{ time }, [{ unit }]] = [this.curvesOf(recording), curves];
    const { factor, text } = shownUpTo({ unit }, largestIn(curves.map(({ values }) => values)));
    this.factor = factor;
    this.unitText = text;
    this.unit.textContent = [SHARED.quantities[unit], text].filter(Boolean).join(", ");
    const scaled = curves.map((curve) => ({ ...curve, values: curve.values.map((value) => this.factor * value) }));
    Object.assign(this, { recording, time, curves: withoutRoundOff(scaled, unit === "N" ? this.factor * recording.peakForce : 0) });
    Object.assign(this, { writers: writersOf(this.curves), isOfCounts: this.curves.every(isCount) });
    this.areZero = this.curves.map(({ values }) => values.every((value) => value === 0));
    const data = [time, ...this.curves.map(({ values }) => values)];
    const words = curves.map((curve) => `${curve.name}: ${curve.words}`).join();
    if (words !== this.shownWords) this.makeCurves(curves, data);
    this.setData(data);
    this.shownWords = words;
  }

  /**
   * Draw the curves with the line at the time `present` [s]: over the whole run or, in a close view, over `close`, [from, to], where the
   * axis counts from `onset`.
   */
  draw(present, close, onset) {
    this.drawn = [present, close, onset];
    if (close?.join() !== this.close?.join() || onset !== this.onset) {
      Object.assign(this, { close, onset });
      this.setData(this.plot.data);
    }
    this.mark(present);
    this.writeValues(present, this.unitText, (k, now) => {
      const own = this.areZero[k] ? "always 0" : this.writers[k](valueAt(this.time, this.curves[k], now));
      const others = this.compared.map(({ recording }) => {
        const { time, curves } = this.curvesOf(recording) ?? { curves: [] };
        const curve = curves.find(({ name }) => name === this.names[k]);
        return curve ? this.writers[k](this.factor * valueAt(time, curve, now)) : "–";
      });
      return [[own, others.length ? "" : this.unitText].filter(Boolean).join("\u202f"), ...others];
    });
  }
}

/** Return a curve's value at the time `now` [s], interpolated between rows at the times `time` [s]; a stepped curve has a row's value. */
function valueAt(time, { values, isStepped }, now) {
  const [row, share] = placeIn(time, now);
  return isStepped ? values[row + Math.floor(share)] : valueAtPlace(values, [row, share]);
}

export class CurveCharts {
  #compared = [];

  /**
   * `curvesOf` returns { time, curves } for a recording, or undefined if no curve is known. Elements that may be missing: `zoomButton`
   * switches to the view of one impact and back, `title` names this impact, `apartBox` asks for a chart of each curve, and `note` names the
   * compared motions that lack some of the curves, followed by the text `whyWithout`.
   */
  constructor(element, pointer, { curvesOf, label, zoomButton, title, note, whyWithout, apartBox }) {
    Object.assign(this, { element, pointer, curvesOf, label, zoomButton, title, note, whyWithout, apartBox, charts: new Map() });
    apartBox?.addEventListener("change", () => {
      if (!this.charts.size) return;
      this.show(this.recording);
      this.draw(this.frame, this.contact);
    });
    zoomButton?.addEventListener("click", () => {
      zoomButton.ariaPressed = zoomButton.ariaPressed !== "true";
      this.draw(this.frame, this.contact);
    });
  }

  show(recording) {
    this.recording = recording;
    const { curves } = this.curvesOf(recording);
    const keyOf = ({ unit, name }) => (this.apartBox?.checked ? name : unit);
    const keys = [...new Set(curves.map(keyOf))];
    if (JSON.stringify(keys) !== JSON.stringify([...this.charts.keys()])) { // as JSON, [""] (the unit of counts) differs from []
      this.charts = new Map(keys.map((key) => [key, this.#chartOf()]));
      const parts = [...this.charts.values()].flatMap(({ unit, element, entries }) => [unit, element, entries]);
      this.element.replaceChildren(...parts);
      this.charts.forEach((chart) => Object.assign(chart, { group: [...this.charts.values()] }));
      this.compare(this.#compared);
    }
    if (this.zoomButton) this.zoomButton.hidden = recording.impacts.length === 0;
    const styled = curves.map((curve) => {
      const k = curves.filter(({ unit }) => unit === curve.unit).indexOf(curve);
      const dash = DASHES[(k + Math.floor(k / INPUT_COLOURS)) % DASHES.length];
      return { ...curve, stroke: `input-${(k % INPUT_COLOURS) + 1}`, dash };
    });
    this.charts.forEach((chart, key) => chart.show(recording, styled.filter((curve) => keyOf(curve) === key)));
    this.#nameWithout();
  }

  #chartOf() {
    const [element, entries] = [make("div", { className: "chart curve-chart" }), make("dl", { className: "entries" })];
    element.setAttribute("role", "img");
    element.setAttribute("aria-label", `${this.label} over time; click, or arrow keys and Enter, to go to a time`);
    const unit = make("small", { className: "curve-unit" });
    return Object.assign(new UnitChart(element, 104, entries, undefined, this.pointer), { unit, curvesOf: this.curvesOf });
  }

  zoom(part) {
    this.charts.values().next().value?.zoom(part);
  }

  enlarge(isLarge) {
    if (!isLarge) this.zoom();
  }

  readAt(time) {
    this.charts.forEach((chart) => chart.readAt(time));
  }

  compare(recordings) {
    this.#compared = recordings;
    this.charts.forEach((chart) => chart.compare(recordings));
    this.#nameWithout();
  }

  /** Tell, below the charts, how they show compared motions; name each one that lacks at least one of the shown curves. */
  #nameWithout() {
    if (!this.note || !this.recording) return;
    const namesOf = (recording) => this.curvesOf(recording)?.curves.map(({ name }) => name) ?? [];
    const shown = namesOf(this.recording);
    const without = this.#compared.filter(({ recording }) => !shown.every((name) => namesOf(recording).includes(name)));
    const letters = without.map(({ letter }) => letter).join(", ");
    const arePale = this.#compared.length && [...this.charts.values()].some((chart) => chart.arePale);
    const lines = [arePale && "Pale curves are those of pins.", letters && `Not all curves of ${letters}: ${this.whyWithout}.`];
    this.note.textContent = lines.filter(Boolean).join(" ");
  }

  draw(frame, contact) {
    Object.assign(this, { frame, contact });
    const isClose = contact && this.zoomButton?.ariaPressed === "true";
    const margin = isClose && (SHARED.curves.CLOSE_BEFORE * (contact.impactEnd - contact.onset) || MOMENT);
    const { start, end } = this.recording;
    const close = isClose ? [Math.max(contact.onset - margin, start), Math.min(contact.impactEnd + margin, end)] : undefined;
    if (this.title) this.title.textContent = isClose ? contactTitle(contact) : "";
    this.charts.forEach((chart) => chart.draw(this.recording.timeAt(frame), close, isClose ? contact.onset : undefined));
  }
}
