// The chart of the force of one contact, over time or over penetration.

import { byId, make } from "../base/dom.js";
import { durationText, fixed, forceText, forceTicks, impulseText, unitsOf, withMinus } from "../base/format.js";
import { LabelSpace, positionsAround } from "../drawing/label_positions.js";
import { partnerOf } from "../recording/partners.js";
import { hasImpulseOnly, placeIn, valueAtPlace } from "../recording/recording.js";
import {
  axisOptions, Chart, contactTitle, drawCompared, drawCurve, labelledWidth, MOMENT, styleColour, ticksText, ticksUpwards, timeTexts,
  timeTicks,
} from "./chart.js";
import {
  courseAround, extentOf, highest, impulsesLike, lossText, MOST_BESIDE, MOST_OF_ROOTS, rootTicks, SHOWN_SHARE, shownPartOf,
} from "./contact_course.js";
import { LETTER_DOT } from "./letters.js";

const PART_SHARE = 0.25; // length of a part around the present time, relative to the duration of the recording
const PART_MARGIN = 0.03; // time that the chart shows before and after such a part, relative to its length
const MARGIN = 1.08; // ends of the axis of forces, relative to the extremes of the curves; above a contact's curves, PEAK_ROOM replaces it
// [pixels] height above all curves for the text of the peak force, radius of the dot at the peak, and size of the letters of the text
const [PEAK_ROOM, PEAK_DOT, PEAK_TEXT] = [22, 2.5, 11];
// distance of the middle of this text from the peak [pixels], and its multiples that are tried in this order
const [PEAK_AWAY, PEAK_MULTIPLES] = [12, [1, 1.6, 2.4, 3.4, 4.6]];
const NEAR_LINE = 70; // [pixels] the text may give way to the line at the present time if the line is nearer to the peak
const [ONLY_IMPULSE, NO_COURSE] = ["an impulse only", "no known force over time"]; // why a contact has no curve
const DOUBTFUL_PAIR = "perhaps another impact"; // the note on a curve of a doubtful partner
const LEAST_IN = { m: 1, mm: 1e-4, µm: 0 }; // [m] least value of the last tick with which an axis of penetrations is in a unit
const NO_FORCE = 1e-9; // [N], or [N·m] at a stop of a joint: if no force is larger, the axis goes up to about 1

/** Return words for the largest force of a compared curve if it is above `high`; else "". */
function noteAbove(forces, high, unit) {
  const peak = highest(forces);
  return peak > high ? `up to ${forceText(peak, 3, unit)}` : "";
}

/** Return the label of a tick of an axis of penetrations [m]: all of `ticks` are in metres, in millimetres or in micrometres. */
function depthText(tick, ticks) {
  const [factor, unit] = [[1, "m"], [1e3, "mm"], [1e6, "µm"]].find(([, name]) => ticks.at(-1) >= LEAST_IN[name]);
  return `${+(factor * tick).toPrecision(6)} ${unit}`;
}

/** The chart of the force of the present contact, over the time of the contact or over its penetration. */
export class ForceChart extends Chart {
  /** `pointer.seek` is called to go to a time [s], with this time and the contact or, if the chart shows impulses, with the time alone. */
  constructor(element, quantity, title, loopButton, pointer) {
    super(element, 120, pointer);
    Object.assign(this, { quantity, title, loopButton });
    this.unit = { ...unitsOf({}) }; // the units of the quantities of the contact that the chart shows
    this.make(
      {
        series: [
          {},
          {
            stroke: () => styleColour("force"), width: 2, fill: () => styleColour("force-fill"), points: { show: false },
            paths: uPlot.paths.spline(), // this spline has no maximum between two rows that none of the rows has
          },
          { stroke: () => styleColour("friction"), width: 1.6, dash: [2, 3], points: { show: false } },
        ],
        scales: { x: { time: false }, y: this.#forceScale },
        hooks: {
          draw: [(plot) => {
            const own = this.loop ?? this.impulses;
            if (own) drawCurve(plot, own, { stroke: "force", fill: "force-fill" });
            this.#drawPeak(plot);
          }],
        },
        axes: [
          axisOptions({
            splits: (_, axis, low, high, step) => timeTicks(low, high, step, this.isAroundNow ? -this.shown.onset : 0),
            values: (_, ticks) => this.#alongTexts(ticks),
          }),
          axisOptions({
            size: labelledWidth,
            filter: (_, ticks) => ticks, // else uPlot leaves out ticks, because the scale is not linear
            splits: (plot, axis, low, high) => (this.isOfRoots ? rootTicks(plot, high) : ticksUpwards(plot, low, high)),
            values: (_, ticks) => forceTicks(ticks, this.unit.peak_force).map(withMinus),
          }),
        ],
      },
      [[0, 1], [0, 0], [null, null]],
    );
    this.dot = document.createElement("div");
    Object.assign(this.dot, { className: "loop-now", hidden: true });
    this.peakText = make("div", { className: "peak" });
    this.plot.over.append(this.dot, this.peakText);
    loopButton.addEventListener("click", () => {
      loopButton.ariaPressed = loopButton.ariaPressed !== "true";
      this.zoom();
    });
  }

  /** Return the scale of forces: linear or, with `isOfRoots`, of square roots. */
  get #forceScale() {
    return {
      range: (_, least, most) => [MARGIN * Math.min(least, 0), MARGIN * Math.max(most, 1e-9)],
      distr: 100,
      fwd: (force) => (this.isOfRoots ? Math.sign(force) * Math.sqrt(Math.abs(force)) : force),
      bwd: (place) => (this.isOfRoots ? place * Math.abs(place) : place),
    };
  }

  /** Return the labels of the horizontal axis: penetrations; times of the run (impulses, a part around now); else times since the onset. */
  #alongTexts(ticks) {
    if (this.isAroundNow) return timeTexts(ticks.map((tick) => tick + this.shown.onset));
    return ticks.map((tick) => (this.loop ? depthText : ticksText)(tick, ticks));
  }

  fit() {
    const { height } = this;
    super.fit();
    if (this.shown && this.height !== height) this.rescale(); // the room for the number of the peak has a fixed height
  }

  rescale() {
    const { frame, shown } = this;
    this.part = null;
    this.draw(frame, shown);
  }

  /**
   * Draw the curves of compared motions, and a dot at the largest force of the shown contact; write the peak force beside the dot. In a
   * part around the present time, the dot at this time has the force (`mark`).
   */
  #drawPeak({ ctx, bbox, valToPos, data }) {
    const { shown, impulses, isAroundNow } = this;
    const [along, up] = this.loop ?? impulses ?? data;
    const toCanvas = ([x, y]) => [valToPos(x, "x", true), valToPos(y, "y", true)];
    const toPlot = ([x, y]) => [(x - bbox.left) / devicePixelRatio, (y - bbox.top) / devicePixelRatio];
    const top = impulses ? along.indexOf(shown.onset) + 1 : isAroundNow ? -1 : this.top;
    const peak = top < 0 ? [] : [toCanvas([along[top], up[top]])];
    this.letters = drawCompared(this.plot, this.curves ?? [], [[along, up]], [...peak]).map(toPlot);
    this.peakAt = peak.map(toPlot)[0];
    this.peakText.hidden = !peak.length;
    const curves = [[along, up], ...(this.curves ?? []).map(({ points }) => points)];
    this.courses = curves.map(([xs, ys]) => Array.from(xs, (x, k) => toPlot(toCanvas([x, ys[k]]))));
    if (isAroundNow) this.mark();
    if (!peak.length) return;
    ctx.save();
    ctx.beginPath();
    ctx.arc(...peak[0], PEAK_DOT * devicePixelRatio, 0, 2 * Math.PI);
    ctx.fillStyle = styleColour("force");
    ctx.fill();
    ctx.restore();
    this.peakText.textContent = impulses ? impulseText(shown) : forceText(this.peak, 3, this.unit.peak_force);
    this.#placePeak();
  }

  /**
   * Place the text where it covers no curve, no letter, and not the line at the present time. Without such a place, a force stands at the
   * first candidate all the same, while an impulse is hidden.
   */
  #placePeak() {
    const { clientWidth: width, clientHeight: height } = this.plot.over;
    const space = new LabelSpace(width, height, 0);
    const isNear = ([x]) => x > -width && x < 2 * width;
    this.courses.forEach((course) => space.reserveLine(course.filter(isNear)));
    space.reserveAround(this.peakAt, PEAK_DOT + 1);
    this.letters.forEach((at) => space.reserveAround(at, LETTER_DOT + 1));
    const line = this.line.hidden || this.at === undefined ? NaN : this.plot.valToPos(this.at, "x");
    if (!this.line.hidden) space.reserveLine([[line, 0], [line, height]]);
    // far from its line, an impulse would seem to belong to another one; the title has the impulse, too
    const multiples = this.impulses ? PEAK_MULTIPLES.slice(0, 2) : PEAK_MULTIPLES;
    const candidates = positionsAround(this.peakAt, [0, -1], PEAK_AWAY, multiples);
    const place = space.findPosition(this.peakText.textContent, PEAK_TEXT, candidates);
    this.peakText.style.visibility = this.impulses && !place ? "hidden" : "inherit";
    const { at: [x, y], anchor } = place ?? candidates[0];
    const across = { start: 0, middle: -50, end: -100 }[anchor];
    Object.assign(this.peakText.style, { left: `${x}px`, top: `${y}px`, translate: `${across}% -50%` });
    this.isNearLine = Math.abs(line - this.peakAt[0]) < NEAR_LINE;
  }

  /** Move the line at the present time; in a part around this time, a dot on the curve, with the force beside it, moves with the line. */
  mark(x = this.at) {
    super.mark(x);
    if (!this.courses || x === undefined) return;
    if (this.isAroundNow) {
      // without a force now, the largest force in the part has the number
      const isNow = this.forceNow > NO_FORCE || this.top < 0;
      const [along, up] = isNow ? [x, this.forceNow] : [this.plot.data[0][this.top], this.peak];
      this.peakAt = [this.plot.valToPos(along, "x"), this.plot.valToPos(up, "y")];
      this.dot.style.transform = `translate(${this.peakAt[0]}px, ${this.peakAt[1]}px)`;
      this.peakText.textContent = forceText(up, 3, this.unit.peak_force);
      this.dot.hidden = !isNow || this.line.hidden;
      this.peakText.hidden = isNow && this.line.hidden;
    }
    if (this.peakText.hidden) return;
    const isNear = Math.abs(this.plot.valToPos(x, "x") - this.peakAt[0]) < NEAR_LINE;
    if (isNear || this.isNearLine || this.isAroundNow) this.#placePeak();
  }

  /**
   * Return a text with a time and the force then. The time is that since the onset or, in a part around now, that of the run; for impulses
   * it stands alone. The text is "" for a loop, where a penetration can have two forces. `time` [s]: place on the horizontal axis.
   */
  readingAt(time) {
    if (this.loop) return "";
    if (this.impulses) return `${withMinus(fixed(time, 4))} s`;
    const [times, force] = this.plot.data;
    const text = this.isAroundNow ? `${fixed(time + this.shown.onset, 4)} s` : withMinus(durationText(time));
    return `${text}: ${forceText(valueAtPlace(force, placeIn(times, time)), 3, this.unit.peak_force)}`;
  }

  goTo(time) {
    this.pointer.seek(this.timeOf(time), this.impulses ? undefined : this.shown);
  }

  timeOf(x) {
    return this.impulses ? x : this.shown.onset + x;
  }

  placeOf(time) {
    return this.impulses ? time : this.shown && time - this.shown.onset;
  }

  timeAt(left, top) {
    if (!this.loop) return super.timeAt(left);
    const [penetration, force, times] = this.loop;
    const { onset, end } = this.shown;
    const awayFrom = (k) => Math.hypot(this.plot.valToPos(penetration[k], "x") - left, this.plot.valToPos(force[k], "y") - top);
    const rows = [...times.keys()].filter((k) => times[k] >= 0 && times[k] <= end - onset);
    return times[rows.reduce((best, k) => (awayFrom(k) < awayFrom(best) ? k : best))];
  }

  show(recording) {
    this.recording = recording;
    this.shown = null;
  }

  compare(recordings) {
    this.compared = recordings;
    this.shown = null;
  }

  draw(frame, contact) {
    if (!contact) return;
    this.frame = frame;
    if (this.shown && contact !== this.shown && this.zoomed) this.zoom(); // another contact has its own times
    const { recording } = this;
    const now = recording.timeAt(frame);
    const course = recording.courseOf(contact);
    const [penetration, force] = [course.penetration, course.force].map((values) => values && recording.betweenRows(values, frame));
    this.forceNow = force;
    const part = shownPartOf(contact, now, PART_SHARE * (recording.end - recording.start));
    if (contact !== this.shown || part.from !== this.part?.from || part.to !== this.part.to) this.#show(contact, part);
    this.line.hidden = this.dot.hidden = true;
    if (!this.loop) {
      this.mark(this.placeOf(now));
      return;
    }
    this.at = undefined;
    this.dot.hidden = !(penetration > 0);
    const [left, top] = [this.plot.valToPos(penetration, "x"), this.plot.valToPos(force, "y")];
    this.dot.style.transform = `translate(${left}px, ${top}px)`;
  }

  #show(contact, part) {
    const { recording } = this;
    if (contact !== this.shown) this.read(undefined);
    Object.assign(this, { shown: contact, part });
    Object.assign(this.unit, unitsOf(contact));
    const own = courseAround(recording, contact);
    const hasCurve = own.force.some((force) => force > 0);
    this.loopButton.hidden = !own.penetration;
    this.loop = own.penetration && this.loopButton.ariaPressed === "true" ? [own.penetration, own.force, own.times] : null;
    const lines = this.compared.map((line) => ({ ...line, ...this.#courseIn(line.recording, contact) }));
    this.curves = lines.filter(({ points }) => points);
    this.impulses = !hasCurve && !this.curves.length && hasImpulseOnly(contact) ? impulsesLike(recording, contact) : null;
    if (this.impulses) {
      Object.assign(this, { loop: null }).loopButton.hidden = true;
      this.curves = this.compared.map((line) => ({ ...line, points: impulsesLike(line.recording, contact) }))
        .filter(({ points: [onsets] }) => onsets.length);
      this.unit.peak_force = this.unit.impulse;
    }
    this.isAroundNow = part.isAroundNow && !this.loop && !this.impulses;
    const rubs = own.friction?.some((force) => force !== 0);
    const high = this.#setAxes(own, rubs ? own.friction : own.times.map(() => null));
    // A contact between two rows of the recording has no curve, and neither has an impulse of a rigid wall: the chart then shows the curves
    // of compared motions or else the impulses; without them, it is hidden.
    const isKnown = hasCurve || this.impulses || this.curves.length > 0;
    this.element.hidden = !isKnown;
    this.loopButton.hidden ||= !isKnown;
    this.loss = this.#lossOf(contact, own);
    this.#tell(lines, hasCurve, high, rubs);
  }

  /** Return the ends of the horizontal axis: of penetrations, of the run if the chart has impulses, or of times since the onset. */
  #alongRange(penetration) {
    const { recording, zoomed, curves, part: { from, to, isAroundNow } } = this;
    if (zoomed) return zoomed;
    if (this.impulses) return [recording.start, recording.end];
    const extent = (own, axis) => extentOf([own], curves.map(({ points }) => points[axis]));
    if (this.loop) return [0, 1.05 * extent(penetration, 0)];
    if (!(to > from)) {
      const longest = Math.max(0, ...curves.map(({ end }) => end)); // of compared contacts beside an impulse
      return longest ? [-SHOWN_SHARE * longest, (1 + SHOWN_SHARE) * longest] : [-MOMENT, MOMENT];
    }
    const margin = (isAroundNow ? PART_MARGIN : SHOWN_SHARE) * (to - from);
    // with the ends of compared contacts that last somewhat longer
    const ends = isAroundNow ? [] : curves.map(({ end }) => end).filter((end) => end < MOST_BESIDE * to);
    return [from - margin, Math.max(to, ...ends) + margin];
  }

  /** Set the data and the axes of the plot; return the end of a linear axis of forces. `friction` may have null values. */
  #setAxes({ times, force, penetration }, friction) {
    const { shown, impulses, loop, curves } = this;
    const [low, high] = this.#alongRange(penetration);
    const isIn = (x) => loop !== null || (x >= low && x <= high);
    const inRange = ([along, up]) => up.filter((_, k) => isIn(along[k]));
    const highestIn = () => force.reduce((best, value, k) => (isIn(times[k]) && value > (force[best] ?? 0) ? k : best), -1);
    this.top = shown.peak_force || this.isAroundNow ? highestIn() : -1;
    const hasPeak = shown.peak_force && isIn(shown.peakTime - shown.onset);
    this.peak = hasPeak ? shown.peak_force : force[this.top]; // the peak may lie between two rows
    const ownForces = impulses ? impulses[1] : hasPeak ? [shown.peak_force] : inRange([times, force]);
    const forces = [[ownForces, inRange([times, friction])], curves.map(({ points }) => inRange(points))];
    const linear = extentOf(...forces);
    const most = extentOf(...forces, MOST_OF_ROOTS);
    this.isOfRoots = most > linear;
    this.plot.scales.y.min = null; // else uPlot keeps the places of equal ends
    this.plot.setData(loop || impulses ? [[0, high], [null, null], [null, null]] : [times, force, friction], false);
    this.plot.batch(() => {
      this.plot.setScale("x", { min: low, max: high });
      const room = PEAK_ROOM / this.plot.over.clientHeight;
      // the limits contain the margin, because uPlot applies the function `range` of an axis only to limits that it finds itself
      const max = (most > NO_FORCE ? most : 1) / (1 - room) ** (this.isOfRoots ? 2 : 1);
      this.plot.setScale("y", { min: MARGIN * Math.min(0, ...friction), max });
    });
    return linear;
  }

  /** Write the quantity and the title. `lines`: the compared motions, `high`: the end of a linear axis of forces. */
  #tell(lines, hasCurve, high, rubs) {
    const { shown: contact, part: { from, to, isAroundNow } } = this;
    const { onset, end } = contact;
    const isRigid = hasImpulseOnly(contact);
    const isHeld = isRigid && hasCurve;
    const kinds = this.loop ? ["Force", "Moment"] : ["Contact force", "Moment of the stop"];
    const [force, moment] = isHeld ? ["Holding force", "Holding moment"] : kinds;
    const letters = hasCurve || this.impulses ? "" : this.curves.map(({ letter }) => letter).join(", ");
    const quantity = (unitsOf(contact).peak_force === "N" ? force : moment) + (isHeld ? " after the impulse" : letters && ` of ${letters}`);
    const impulses = contact.atStop ? "Angular impulses" : "Impulses";
    const axis = this.isOfRoots ? " (square roots)" : "";
    this.quantity.textContent = this.impulses ? impulses : (this.loop ? `${quantity} over penetration` : quantity) + axis;
    const without = this.impulses ? "rigid" : letters ? `present: ${isRigid ? ONLY_IMPULSE : NO_COURSE}` : "no force over time is known";
    const isPart = !this.loop && !isHeld && to - from < end - onset;
    const shownPart = isPart ? `, ${isAroundNow ? "around now" : "its beginning"}` : "";
    const own = hasCurve ? this.loss || durationText(end - onset, 2) + shownPart : without;
    const whyOf = ({ points, why = "" }) => (this.impulses ? "" : (points && noteAbove(points[1], high, this.unit.peak_force)) || why);
    const lettersWith = (why) => lines.filter((line) => whyOf(line) === why).map(({ letter }) => letter).join(", ");
    const notes = [...new Set(lines.map(whyOf))].filter(Boolean).map((why) => `; ${lettersWith(why)}: ${why}`).join("");
    byId("contact-legend").hidden = !rubs || this.loop !== null;
    const text = `${contactTitle(contact)}, ${own}${notes}`;
    Object.assign(this.title, { textContent: text, title: text }); // the title may be cut, so its whole text is also the tooltip
  }

  /**
   * Return the `points` of the curve of a compared recording at the partner of a contact, with `end`, the duration of the partner, and
   * words `why`: on the loss or, if it is doubtful that the two contacts belong together, on this; without a curve, only `why`.
   */
  #courseIn(other, contact) {
    const { partner, isDoubtful } = partnerOf(contact, this.recording, other);
    if (!partner) return { why: "no such impact near" };
    const course = courseAround(other, partner);
    const { times, penetration, force } = course;
    if (this.loop && !penetration) return { why: "no known penetration" };
    if (!force.some((value) => value > 0)) return { why: hasImpulseOnly(partner) ? ONLY_IMPULSE : NO_COURSE };
    const points = [this.loop ? penetration : times, force];
    return { points, end: partner.end - partner.onset, why: isDoubtful ? DOUBTFUL_PAIR : this.#lossOf(partner, course) };
  }

  /** Return words for the energy that a contact loses; "" over time, or if the contact lasts until the end of the run: its loop is open. */
  #lossOf({ separation_speed }, course) {
    return this.loop && Number.isFinite(separation_speed ?? NaN) ? lossText(course) : "";
  }
}
