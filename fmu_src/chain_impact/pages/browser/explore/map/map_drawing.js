// The drawing of the map: the colours of the runs, the axes, the scale of the colours, and marks of the present and the chosen run.

import { digits, numberText, ticksOf, withMinus } from "../../base/format.js";
import { ticksBetween } from "../../base/ticks.js";
import { BEYOND, classColour, colourAt, colourOf, FAILED, VIRIDIS, WITHOUT } from "./map_colours.js";
import { contourOf } from "./map_contour.js";
import { markRuns } from "./map_marks.js";
import { axisScale, decadesBetween, quantityOf, scaledTo, titleOf } from "./map_scales.js";

const DIGIT = 7.6; // [pixels] width of a digit of the numbers at the scale of the colours
const GAP = 8; // [pixels] least distance between two numbers at the scale of the colours
const LINE = 13; // [pixels] distance of two lines of the title of the colours
const PENDING_OPACITY = 150; // opacity (0 to 255) of runs that are not simulated yet, whose outputs are those of near runs
// [pixels] free space around the canvas for axes and scale; the rule of #map-canvas in the style sheet must have the same lengths
const EDGE = { left: 64, right: 16, top: 8, bottom: 114 };
const SWATCH = 11; // [pixels] side of the square with the colour of a class

export class MapDrawing {
  constructor(canvas, scales, frame) {
    Object.assign(this, { canvas, scales: SVG(scales), frame });
  }

  clear() {
    this.canvas.getContext("2d").clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.scales.clear();
  }

  /**
   * Draw the runs of a map with the `scale` of its colours. `filled`: for each run, the output that its colour shows. A run that is not
   * simulated yet (without an entry in `results`) shows the output of a near run in a paler colour, or nothing if `filled` has no output.
   * The colours of the outer runs end at the ends of the axes: such a run takes one pixel of the canvas, any other run two.
   */
  drawRuns({ results, points, scale, output, faults }, filled) {
    const context = this.canvas.getContext("2d");
    const size = 2 * (points - 1);
    const image = context.createImageData(size, size);
    const coloursOf = (value, index) => {
      if (!Number.isFinite(value)) return faults.has(index) ? FAILED : WITHOUT;
      const opacity = results[index] === undefined ? PENDING_OPACITY : 255;
      return [...colourOf({ output, scale }, value), opacity];
    };
    const colours = filled.map((value, index) => value !== undefined && coloursOf(value, index));
    for (let pixel = 0; pixel < size * size; pixel += 1) {
      const [column, row] = [pixel % size, size - 1 - Math.floor(pixel / size)].map((at) => Math.floor((at + 1) / 2));
      const colour = colours[row * points + column]; // false for a run that is not simulated, as no run near it is: nothing is drawn
      if (colour) image.data.set(colour, 4 * pixel);
    }
    context.putImageData(image, 0, 0);
  }

  /**
   * Draw the axes, the scale of the colours, and marks of runs; return whether a mark of the present run is drawn in the map.
   *
   * @param map the words for both axes and their values, the number of values of an axis, the output and the scale of its colours.
   * @param units the units of both axes, from `shownIn`, and whether each axis is logarithmic.
   * @param marks `present`: `at`, the present values of both parameters, and the output `value` of the run with them, if it is known;
   * `present` is null if other parameters differ from those of the map. `chosen`: the index of the run that the reader has marked, if any.
   * `limit`: the output of the contour, if the reader has given a limit.
   */
  drawScales({ names, axes, output, scale, points, results, faults }, units, { present, chosen, limit }) {
    const { scales, frame: { clientWidth, clientHeight } } = this;
    const [width, height] = [clientWidth - EDGE.left - EDGE.right, clientHeight - EDGE.top - EDGE.bottom];
    if (!(width > 0 && height > 0)) return false;
    scales.clear().size(clientWidth, clientHeight).viewbox(0, 0, clientWidth, clientHeight);
    const bottom = EDGE.top + height;
    const at = (k, value) => {
      const share = axisScale(axes[k][0], axes[k].at(-1), units[k].isLogarithmic).shareOf(value);
      return k ? bottom - share * height : EDGE.left + share * width;
    };
    names.forEach((name, k) => {
      const { factor, text, isLogarithmic } = units[k];
      const [low, high] = [axes[k][0] * factor, axes[k].at(-1) * factor].sort((a, b) => a - b);
      (isLogarithmic ? decadesBetween : ticksBetween)(low, high).forEach((tick) => {
        const pixel = at(k, tick / factor);
        scales.line(k ? [[EDGE.left - 5, pixel], [EDGE.left, pixel]] : [[pixel, bottom], [pixel, bottom + 5]]).addClass("map-tick");
        if (k) this.#write(numberText(tick), EDGE.left - 10, pixel + 4, "end");
        else this.#write(numberText(tick), pixel, bottom + 18, "middle");
      });
      const title = titleOf(name, text);
      if (k) {
        const label = this.#write(title, 0, 0, "middle");
        const middle = Math.max(EDGE.top + height / 2, label.length() / 2 + 2); // a long title goes on beside the scale of colours
        label.attr({ transform: `translate(13 ${middle}) rotate(-90)` });
      } else this.#write(title, EDGE.left + width / 2, bottom + 34, "middle");
    });
    scales.rect(width, height).move(EDGE.left, EDGE.top).addClass("map-tick");
    this.#drawColours(EDGE.left, bottom + 52, width, output, scale, results);
    const isWithout = (value, index) => value === null && !faults.has(index);
    const none = output.rigid ? "only impulses" : "no such impact";
    const last = this.#drawClasses(EDGE.left, bottom + 52 + (output.places ? 0 : 56), width, [
      ...(output.places ?? []).map((place, k) => [classColour(k), place]),
      ...(results.some(isWithout) ? [[WITHOUT, none]] : []),
      ...(faults.size ? [[FAILED, "run fails"]] : []),
    ]);
    if (output.places) this.#writeTitle(quantityOf(output.name), "", EDGE.left + width / 2, last + 20);
    if (!scale) return false;
    if (Number.isFinite(limit)) {
      const screen = ([column, row]) => `${EDGE.left + (column / (points - 1)) * width} ${bottom - (row / (points - 1)) * height}`;
      const path = contourOf(results, points, limit).map(([from, to]) => `M${screen(from)}L${screen(to)}`).join("");
      ["map-contour-edge", "map-contour"].forEach((kind) => path && scales.path(path).addClass(kind));
      const share = scale.shareOf(limit);
      if (!scale.bins && share >= 0 && share <= 1) {
        const x = EDGE.left + width * share;
        scales.line([[x, bottom + 41], [x, bottom + 56]]).addClass("map-contour-edge");
        scales.line([[x, bottom + 41], [x, bottom + 56]]).addClass("map-contour");
      }
    }
    const [x, y] = present?.at.map((value, k) => at(k, value)) ?? [];
    const isSeen = x >= EDGE.left && x <= EDGE.left + width && y >= EDGE.top && y <= bottom;
    const marked = { present: isSeen ? { at: [x, y], value: present.value } : null, chosen };
    markRuns(scales, { results, points, output, scale }, { left: EDGE.left, top: EDGE.top, width, height }, marked);
    if (output.places) return isSeen;
    const values = [[present?.value, "map-present-edge"], [present?.value, "map-present"], [results[chosen], "map-at"]];
    values.filter(([value]) => Number.isFinite(value ?? NaN)).forEach(([value, kind]) => {
      const share = Math.min(Math.max(scale.shareOf(value), 0), 1);
      const bins = scale.bins?.length - 1;
      const shown = bins ? (share * (bins - 1) + 0.5) / bins : share; // the middle of a count's colour
      scales.circle(8).center(EDGE.left + width * shown, bottom + 48.5).addClass(kind);
    });
    return isSeen;
  }

  #write(text, x, y, anchor) {
    return this.scales.plain(withMinus(text)).attr({ x, y, "text-anchor": anchor }).addClass("map-number");
  }

  /** Write the title of the scale of colours; its `note` stands in the same line or, if this line does not fit in the drawing, below it. */
  #writeTitle(title, note, middle, y) {
    const room = 2 * Math.min(middle, this.frame.clientWidth - middle);
    const whole = this.#write(title + note, middle, y, "middle");
    if (!note || whole.node.getComputedTextLength() <= room) return;
    whole.plain(title);
    this.#write(note.replace(/^,? /, ""), middle, y + LINE, "middle");
  }

  /** Draw squares with the colours of classes and their names, `classes`, in lines from `left`, `top` on; return y of the last line. */
  #drawClasses(left, top, width, classes) {
    let [x, y] = [left, top];
    classes.forEach(([[red, green, blue, opacity = 255], name]) => {
      const text = this.#write(name, 0, 0, "start");
      const wide = SWATCH + 5 + text.node.getComputedTextLength() + 16;
      if (x > left && x + wide > left + width) [x, y] = [left, y + LINE + 2];
      this.scales.rect(SWATCH, SWATCH).move(x, y - SWATCH + 1).addClass("map-swatch")
        .fill({ color: `rgb(${red},${green},${blue})`, opacity: opacity / 255 });
      text.attr({ x: x + SWATCH + 5, y });
      x += wide;
    });
    return y;
  }

  /**
   * Draw the scale of colours, with numbers and title; the title also has the extremes that `beyondEnds` tells, and how the scale goes.
   * Classes have squares instead (`#drawClasses`).
   */
  #drawColours(left, top, width, output, scale, results) {
    if (output.places) return;
    const { factor, text } = scaledTo(output, scale);
    const colours = this.scales.gradient("linear", (add) => gradientStops(scale).forEach((stop) => add.stop(...stop)));
    this.scales.rect(width, 9).move(left, top - 8).fill(colours);
    const labels = scale ? labelsOf(scale, factor, output) : [];
    const widest = Math.max(...labels.map(([label]) => label.length)) * DIGIT + GAP;
    const every = Math.ceil((labels.length * widest) / width) || 1;
    labels.filter((_, k) => k % every === 0).forEach(([label, share]) => {
      const at = left + width * share;
      if (!scale.bins) this.scales.line([[at, top + 1], [at, top + 5]]).addClass("map-tick");
      this.#write(label, Math.min(at, this.frame.clientWidth - (label.length * DIGIT) / 2), top + 17, "middle");
    });
    scale?.ends.forEach((end, k) => {
      if (scale.bins || end === scale.extremes[k]) return; // an arrow stands for outputs beyond this end
      const [at, tip] = k ? [left + width + 2, 10] : [left - 2, -10];
      this.scales.polygon([[at, top - 8], [at + tip, top - 3.5], [at, top + 1]]).fill(`rgb(${BEYOND[k]})`);
    });
    const beyond = scale ? beyondEnds(scale, factor, results) : "";
    const kind = scale?.knots ? " (an equal number of runs for each colour)" : scale?.isLogarithmic ? " (logarithmic scale)" : "";
    this.#writeTitle(titleOf(quantityOf(output.name), text), beyond + kind, left + width / 2, top + 32);
  }
}

/**
 * Return the colours along a scale as pairs [fraction of the scale, 0 to 1; colour]; each interval of a scale with `bins` has one colour.
 */
function gradientStops(scale) {
  const count = scale?.bins ? scale.bins.length - 1 : VIRIDIS.length - 1;
  if (!scale?.bins) return VIRIDIS.map((colour, k) => [k / count, `rgb(${colour})`]);
  return Array.from({ length: count }, (_, k) => [k, k + 1].map((edge) => [edge / count, `rgb(${colourAt(k / (count - 1))})`])).flat();
}

/** Return the labels of the scale of colours as pairs [text, fraction of the scale at which it stands]. */
function labelsOf({ ends, bins, knots, isLogarithmic, shareOf }, factor, { integer: areCounts }) {
  if (knots) return knots.filter((_, k) => k % 2 === 0).map((knot) => [digits(factor * knot), shareOf(knot)]);
  if (bins) {
    return bins.slice(1).map((above, k) => {
      const [first, last] = [bins[k] + 0.5, above - 0.5];
      return [first < last ? `${first}–${last}` : `${first}`, (k + 0.5) / (bins.length - 1)];
    });
  }
  const [low, high] = ends.map((value) => factor * value);
  const ticks = isLogarithmic ? decadesBetween(low, high) : ticksBetween(low, high, 3, areCounts);
  const texts = isLogarithmic ? ticks.map(numberText) : ticksOf(ticks);
  return ticks.map((tick, k) => [texts[k], shareOf(tick / factor)]);
}

/**
 * Return words for the title of a scale: how many `results` lie beyond each end of its colours, and the extreme one times `factor`; "" if
 * none does.
 */
function beyondEnds({ extremes: [least, most], ends: [low, high], bins }, factor, results) {
  const all = bins ? [] : results.filter(Number.isFinite);
  const ends = [["down to", least, (value) => value < low], ["up to", most, (value) => value > high]];
  return ends.map(([word, value, isBeyond]) => [all.filter(isBeyond).length, `${word} ${withMinus(digits(factor * value))}`])
    .map(([count, words]) => (count ? `, ${count} run${count > 1 ? "s" : ""} ${words}` : "")).join("");
}
