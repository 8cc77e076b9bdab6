// The charts, drawn by uPlot: the energies over the whole time, and the force of one contact.

import { durationText, fixed, forceText, ticksOf, unitsOf } from "./format.js";
import { lastBefore } from "./recording.js";

const WIDTHS = { total: 2.4 };
const AROUND = 0.35; // shown time before and after a contact, over the duration of the contact
/** The time [s] that is shown before and after an impact without a duration. */
export const MOMENT = 1e-3;
const NO_FORCE = 1e-9; // [N] force below which a contact counts as having no force
const NARROWEST = 48; // [pixels] the least width of a vertical axis; most labels need no more
const LABEL_MARGIN = 4; // [pixels] the margin on the left of a label

/** Return a colour of the style sheet. */
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function axis(options = {}) {
  return {
    stroke: () => colour("muted"),
    grid: { stroke: () => colour("line"), width: 1 },
    ticks: { stroke: () => colour("line"), width: 1, size: 4 },
    font: "11px system-ui, sans-serif",
    ...options,
  };
}

/**
 * Return the width of a vertical axis, for its longest label. uPlot asks several times in one layout; the first answer
 * counts.
 */
function labelledWidth(plot, labels, index, cycle) {
  const { _size, font, gap, ticks } = plot.axes[index];
  if (cycle > 1) return _size;
  plot.ctx.font = font[0];
  const widths = (labels ?? []).map((label) => plot.ctx.measureText(label).width / devicePixelRatio);
  return Math.ceil(Math.max(NARROWEST, LABEL_MARGIN + Math.max(...widths) + gap + ticks.size));
}

/** Return the largest of the numbers in some arrays, but at least a tiny number above zero. */
function highest(...all) {
  return Math.max(1e-12, ...all.map((numbers) => numbers.reduce((most, value) => Math.max(most, value), 0)));
}

/**
 * Return the rows around a contact: times since its onset [s] and, during the contact, force, penetration and dry friction.
 */
function around(recording, contact) {
  const { onset, end } = contact;
  const margin = AROUND * Math.max(end - onset, 1e-6);
  const { time, ...course } = recording.courseOf(contact);
  const first = lastBefore(time, onset - margin);
  const last = lastBefore(time, end + margin) + 2;
  const times = Array.from(time.slice(first, last), (now) => now - onset);
  const during = (all) => all && times.map((now, index) => (now >= 0 && now <= end - onset ? all[first + index] : 0));
  const [force, depth, friction] = [course.force, course.depth, course.friction].map(during);
  return { times, margin, force: force ?? times.map(() => 0), depth, friction };
}

/** A chart with a vertical line at the present time: the base class of all charts. */
class Chart {
  others = []; // recordings for comparison: {recording, colour}

  constructor(element, height) {
    this.element = element;
    this.height = element.clientHeight || height;
    new ResizeObserver(() => this.fit()).observe(element);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.plot?.redraw(false));
  }

  /** Make the plot, which replaces the plot before. */
  make(options, data) {
    const { element, height } = this;
    this.plot?.destroy();
    this.plot = new uPlot(
      {
        width: Math.max(element.clientWidth, 100),
        height,
        padding: [8, 20, 0, 0],
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
    this.plot.over.append(this.line);
  }

  fit() {
    if (!this.plot) return;
    const { clientWidth: width, clientHeight } = this.element;
    this.height = clientHeight || this.height;
    const { width: before, height: high } = this.plot;
    if (width > 0 && (width !== before || this.height !== high)) this.plot.setSize({ width, height: this.height });
    this.mark();
  }

  /** Put the line at a place of the x-axis; without a place, at its present place. */
  mark(x = this.at) {
    this.at = x;
    if (x === undefined) return;
    const left = this.plot.valToPos(x, "x");
    this.line.hidden = !(left >= -1 && left <= this.plot.over.clientWidth + 1);
    this.line.style.transform = `translateX(${left}px)`;
  }
}

/** A chart of quantities over the whole time, with their names and their values at the present time. */
export class TimeChart extends Chart {
  names = [];
  soft = false; // whether the axis begins at zero if zero is near

  constructor(element, height, entries, seek) {
    super(element, height);
    Object.assign(this, { entries, seek });
  }

  /** Return the first and the last time of the view [s]. */
  get span() {
    return [this.recording.start, this.recording.end];
  }

  /** Return curves of the recordings for comparison: `places`, times and values, and `stroke`. */
  get behind() {
    return [];
  }

  /**
   * Make the plot of curves. A curve has a name, a colour of the style sheet, and optionally dashes and `isStepped`; `space`
   * is the least distance of ticks.
   */
  makeCurves(curves, data, space = 30) {
    this.names = curves.map(({ name }) => name);
    const series = curves.map(({ name, stroke, dash, isStepped }) => ({
      stroke: () => colour(stroke),
      width: WIDTHS[name] ?? 1.6,
      dash,
      points: { show: false },
      ...(isStepped && { paths: uPlot.paths.stepped({ align: 1 }) }),
    }));
    this.make(
      {
        series: [{}, ...series],
        scales: { x: { time: false, range: () => this.span }, y: { range: (_, least, most) => this.#range(least, most) } },
        axes: [axis({ size: 26, space: 64, values: (_, ticks) => ticksOf(ticks).map((tick) => `${tick} s`) }), axis({ size: labelledWidth, space, values: (_, ticks) => ticksOf(ticks) })],
        hooks: {
          drawAxes: [(plot) => drawOnsets(plot, this.recording.impacts)],
          draw: [(plot) => {
            this.behind.forEach(({ places, stroke }) => drawCurve(plot, places, stroke));
            if (plot === this.plot) this.mark(); // the scale of the time may be new
          }],
        },
      },
      data,
    );
    this.entries.replaceChildren();
    this.values = curves.map(({ name, stroke, dash }) => [name, entryOf(this.entries, name, stroke, dash)]);
    const go = (event) => {
      const { left } = this.plot.over.getBoundingClientRect();
      this.seek(this.plot.posToVal(event.clientX - left, "x"));
    };
    this.plot.over.addEventListener("pointerdown", (event) => {
      this.plot.over.setPointerCapture(event.pointerId);
      go(event);
    });
    this.plot.over.addEventListener("pointermove", (event) => event.buttons && go(event));
  }

  /** Return the ends of the axis, between which all curves of the view fit, including those for comparison. */
  #range(least, most) {
    const [from, to] = this.span;
    let [low, high] = [least, most];
    for (const { places: [times, values] } of this.behind) {
      values.forEach((value, k) => {
        if (times[k] < from || times[k] > to) return;
        low = Math.min(low, value);
        high = Math.max(high, value);
      });
    }
    return uPlot.rangeNum(low, high, 0.1, this.soft);
  }
}

/** The chart of all energies over the whole time. */
export class EnergyChart extends TimeChart {
  soft = true;

  constructor(element, energies, seek) {
    super(element, 180, energies, seek);
  }

  get behind() {
    return this.others.map(({ recording: { time, energies }, colour: stroke }) => ({ places: [time, energies.total ?? []], stroke }));
  }

  show(recording) {
    const names = Object.keys(recording.energies);
    const data = [recording.time, ...Object.values(recording.energies)];
    this.recording = recording;
    if (names.join() !== this.names.join()) this.makeCurves(names.map((name) => ({ name, stroke: name })), data);
    else this.plot.setData(data);
    const largest = data.slice(1).reduce((most, values) => values.reduce((so, value) => Math.max(so, Math.abs(value)), most), 0);
    this.decimals = Math.min(Math.max(3 - Math.floor(Math.log10(largest || 1)), 0), 9);
  }

  compare(others) {
    this.others = others;
    if (this.recording) this.show(this.recording);
  }

  draw(frame) {
    this.mark(this.recording.timeAt(frame));
    this.values.forEach(([name, value]) => {
      value.textContent = fixed(this.recording.between(this.recording.energies[name], frame), this.decimals);
    });
  }
}

/** Add an entry to a list: a name with a line in its colour; return the element for its present value. */
function entryOf(list, name, stroke, dash) {
  const [entry, term, value] = ["div", "dt", "dd"].map((tag) => document.createElement(tag));
  term.textContent = name;
  term.style.setProperty("--line-style", dash ? (dash[0] > dash[1] ? "dashed" : "dotted") : "solid");
  term.style.setProperty("--colour", `var(--${stroke})`);
  entry.append(term, value);
  list.append(entry);
  return value;
}

/** Return the ticks of a time axis as texts in seconds or milliseconds, all in the same unit. */
function ticksText(tick, ticks) {
  const [factor, unit] = ticks.at(-1) >= 0.5 ? [1, "s"] : [1e3, "ms"];
  return `${+(factor * tick).toPrecision(6)} ${unit}`;
}

/** Return the ticks of a penetration axis as texts in millimetres or micrometres. */
function depthText(tick, ticks) {
  const [factor, unit] = ticks.at(-1) >= 1e-4 ? [1e3, "mm"] : [1e6, "µm"];
  return `${+(factor * tick).toPrecision(6)} ${unit}`;
}

/** Draw a curve through places of a chart, filled or dashed. */
function drawCurve({ ctx, bbox, valToPos }, [along, up], stroke, fill) {
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  along.forEach((x, k) => ctx.lineTo(valToPos(x, "x", true), valToPos(up[k], "y", true)));
  if (fill) {
    ctx.fillStyle = colour(fill);
    ctx.fill();
  } else {
    ctx.setLineDash([6, 3].map((length) => length * devicePixelRatio));
  }
  ctx.strokeStyle = colour(stroke);
  ctx.lineWidth = 1.6 * devicePixelRatio;
  ctx.stroke();
  ctx.restore();
}

/** Draw faint lines at the impacts. */
function drawOnsets({ ctx, bbox, valToPos }, impacts) {
  ctx.save();
  ctx.strokeStyle = colour("onset");
  ctx.beginPath();
  for (const { onset } of impacts) {
    const x = Math.round(valToPos(onset, "x", true)) + 0.5;
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
  }
  ctx.stroke();
  ctx.restore();
}

/** The chart of the force of the present contact, over the time of the contact or over its penetration. */
export class ForceChart extends Chart {
  constructor(element, what, over) {
    super(element, 120);
    Object.assign(this, { what, over });
    this.unit = { ...unitsOf({}) }; // the units of the shown contact
    this.make(
      {
        series: [
          {},
          { stroke: () => colour("force"), width: 2, fill: () => colour("force-fill"), points: { show: false } },
          { stroke: () => colour("friction"), width: 1.6, points: { show: false } },
        ],
        scales: { x: { time: false }, y: { range: (_, least, most) => [1.08 * Math.min(least, 0), 1.08 * Math.max(most, 1e-9)] } },
        hooks: {
          draw: [(plot) => {
            if (this.loop) drawCurve(plot, this.loop, "force", "force-fill");
            this.curves?.forEach(({ places, stroke }) => drawCurve(plot, places, stroke));
          }],
        },
        axes: [
          axis({ size: 26, values: (_, ticks) => ticks.map((tick) => (this.loop ? depthText : ticksText)(tick, ticks)) }),
          axis({ size: labelledWidth, values: (_, ticks) => ticks.map((tick) => (tick ? forceText(tick, 0, this.unit.force) : "0")) }),
        ],
      },
      [[0, 1], [0, 0], [null, null]],
    );
    this.dot = document.createElement("div");
    Object.assign(this.dot, { className: "loop-now", hidden: true });
    this.plot.over.append(this.dot);
    over.addEventListener("click", () => {
      over.setAttribute("aria-pressed", over.getAttribute("aria-pressed") !== "true");
      const { frame, shown } = this;
      this.shown = null;
      this.draw(frame, shown);
    });
  }

  show(recording) {
    this.recording = recording;
    this.shown = null;
  }

  compare(others) {
    this.others = others;
    this.shown = null;
  }

  draw(frame, contact) {
    if (!contact) return;
    this.frame = frame;
    if (contact !== this.shown) this.#show(contact);
    this.line.hidden = this.dot.hidden = true;
    if (!this.loop) {
      this.mark(this.recording.timeAt(frame) - contact.onset);
      return;
    }
    const [depth, force] = [this.recording.depthOf(contact), this.recording.forceOf(contact)].map((values) => this.recording.between(values, frame));
    this.at = undefined;
    this.dot.hidden = !(depth > 0);
    const [left, top] = [this.plot.valToPos(depth, "x"), this.plot.valToPos(force, "y")];
    this.dot.style.transform = `translate(${left}px, ${top}px)`;
  }

  #show(contact) {
    const { recording } = this;
    const { wall, onset, end, number } = contact;
    this.shown = contact;
    Object.assign(this.unit, unitsOf(contact));
    const { times, margin, force: inside, friction: along, depth } = around(recording, contact);
    const rubs = along?.some((force) => force !== 0);
    const friction = rubs ? along : times.map(() => null);
    this.over.hidden = !depth;
    this.loop = depth && this.over.getAttribute("aria-pressed") === "true" ? [depth, inside] : null;
    this.curves = this.others.flatMap(({ recording: other, colour: stroke }) => {
      const same = other.impacts[number - 1];
      const found = same && same.atStop === contact.atStop && around(other, same);
      const x = found && (this.loop ? found.depth : found.times);
      return x ? [{ places: [x, found.force], stroke }] : [];
    });
    const most = highest(this.loop?.[0] ?? [], ...this.curves.map(({ places: [x] }) => x));
    this.plot.setData(this.loop ? [[0, most], [null, null], [null, null]] : [times, inside, friction], false);
    this.plot.batch(() => {
      if (this.loop) this.plot.setScale("x", { min: 0, max: 1.05 * most });
      else if (end > onset) this.plot.setScale("x", { min: -margin, max: end - onset + margin });
      else this.plot.setScale("x", { min: -MOMENT, max: MOMENT });
      const high = highest([contact.peak ?? 0, ...friction], ...this.curves.map(({ places: [, y] }) => y));
      this.plot.setScale("y", { min: Math.min(0, ...friction), max: high > NO_FORCE ? high : 1 });
    });
    // an impact between two rows of the recording, or at a rigid wall, has no curve
    const length = inside.some((force) => force > 0) ? durationText(end - onset, 2) : "no force over time is known";
    const legend = rubs ? "; brown: friction" : "";
    this.what.textContent = `${number ? `impact ${number}: ` : ""}${contact.what} at ${wall}, ${length}${legend}`;
  }
}
