// The recording: a simulation at frames, with interpolation between frames.

import { mapValues } from "../base/map_values.js";

/** Return whether a frame, without its fraction, is in any of some spans, each with a first and a last frame, both included. */
function isWithin(spans, frame) {
  return spans.some(([first, last]) => frame >= first && frame < last + 1);
}

/** Return the index of the last of increasing numbers that is at most the wanted number; 0 if there is none. */
export function lastBefore(numbers, wanted) {
  let low = 0;
  let high = numbers.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (numbers[middle] <= wanted) low = middle;
    else high = middle - 1;
  }
  return low;
}

/**
 * Return [row, share] for a time: the last row of increasing `times` that is not after `time`, but at least the first row and at most the
 * last but one; and the fraction of the way to the next row, limited to 0 … 1.
 */
export function placeIn(times, time) {
  const row = Math.min(lastBefore(times, time), times.length - 2);
  return [row, Math.min(Math.max((time - times[row]) / (times[row + 1] - times[row]), 0), 1)];
}

/** Return a value at a place from `placeIn`, linearly interpolated between the values at the rows. */
export function valueAtPlace(values, [row, share]) {
  return values[row] + share * (values[row + 1] - values[row]);
}

/** Return whether an impact has an impulse in place of a force: its wall or stop is rigid. */
export function hasImpulseOnly({ peak_force, impulse }) {
  return peak_force === null && Number.isFinite(impulse ?? NaN);
}

/**
 * A simulation at frames, which have equal distances in time on the screen, and so are close in simulated time where the motion is slow on
 * the screen. The number of a frame may have a fraction: values are then interpolated between frames.
 */
export class Recording {
  /** Keep the fields of `parts`, the result of `framesOf`; number the impacts from 1, and find the time of each one's largest force. */
  constructor(parts) {
    Object.assign(this, parts);
    this.start = this.time[0];
    this.end = this.time[this.time.length - 1];
    this.forces = this.forces.map((force) => ({ ...force, holds: this.#holds(force) }));
    this.impacts.forEach((impact, index) => {
      Object.assign(impact, { number: index + 1, peakTime: this.#peakTimeOf(impact) });
    });
    // The time from which on each contact is the present contact: the middle between the end of the contact before it and its own onset,
    // or its onset if the contact before it still lasts then.
    this.turns = this.impacts.map(({ onset }, index) =>
      index ? onset - Math.max(0, (onset - this.impacts[index - 1].end) / 2) : -Infinity);
  }

  /** Return whether the chain is a ball without a radius: its centre of mass alone touches walls, and its link is not seen. */
  get isPoint() {
    return this.ball !== null && !(this.radius > 0);
  }

  /** Return the number of the frame at a simulated time [s], with a fraction between two frames. */
  frameAt(time) {
    const [index, fraction] = placeIn(this.time, time);
    return index + fraction;
  }

  /** Return the simulated time of a frame [s]. */
  timeAt(frame) {
    return this.between(this.time, frame);
  }

  /** Return the rate, simulated seconds per second on the screen, at a frame, in slow motion and with the speed 1. */
  rateAt(frame) {
    const index = Math.min(Math.floor(frame), this.time.length - 2);
    return (this.time[index + 1] - this.time[index]) * this.frameRate;
  }

  /**
   * Return a value at a frame, interpolated if the frame has a fraction. `values` has `width` values for each frame, of which `column` is
   * wanted.
   */
  between(values, frame, column = 0, width = 1) {
    const index = Math.min(Math.floor(frame), this.time.length - 2);
    const first = values[index * width + column];
    return first + (frame - index) * (values[(index + 1) * width + column] - first);
  }

  /** Return a value at a frame, interpolated between rows, from values at all rows, which may be closer to each other than frames. */
  betweenRows(values, frame) {
    return valueAtPlace(values, placeIn(this.rowTime, this.timeAt(frame)));
  }

  /**
   * Return `force` [N], `penetration` [m] and dry `friction` [N] of a contact's point at its wall, each with a value for each row; unknown
   * ones are left out, and so are all if the force is always 0. At a stop of a joint the `force` is a moment [N·m].
   */
  courseOf({ point, wall }) {
    return this.forces.find((force) => force.point === point && force.wall === wall) ?? {};
  }

  /** Return whether a wall or stop is rigid at a point: an impulse comes first, and the force only holds the point after the impulse. */
  #holds({ point, wall }) {
    return this.impacts.some((impact) => impact.point === point && impact.wall === wall && hasImpulseOnly(impact));
  }

  /** Return the time [s] of the row with a contact's largest force; the onset if the force is unknown or 0, or the wall rigid. */
  #peakTimeOf(contact) {
    const { rowTime: time } = this;
    const { force } = this.courseOf(contact);
    let [peakTime, most] = [contact.onset, 0];
    if (!force || contact.peak_force === null) return peakTime;
    for (let row = lastBefore(time, contact.onset); time[row] <= contact.end; row += 1) {
      if (time[row] >= contact.onset && force[row] > most) [peakTime, most] = [time[row], force[row]];
    }
    return peakTime;
  }

  /** Return the position [x, y] of a point [m] at a frame, whose number may have a fraction. */
  pointAt(frame, point) {
    return [this.x, this.y].map((all) => this.between(all, frame, point, this.pointCount));
  }

  /**
   * Return the corners [m] of all bodies at a frame: outlines of links with points, and the carriage of a slider, as large as in the
   * recording `shown`, so that compared motions have carriages of one size.
   */
  bodiesAt(frame, shown = this) {
    const links = this.bodies.map(([link, corners]) => {
      const [[x0, y0], [x1, y1]] = [link - 1, link].map((point) => this.pointAt(frame, point));
      const length = Math.hypot(x1 - x0, y1 - y0) || 1;
      const [c, s] = [(x1 - x0) / length, (y1 - y0) / length];
      return corners.map(([along, left]) => [x0 + c * along - s * left, y0 + s * along + c * left]);
    });
    const [x, y] = this.pointAt(frame, 0);
    if (!this.rail) return links;
    const sizeOf = ({ rail: { carriage: [corner] } }) => Math.hypot(...corner);
    const scale = shown.rail ? sizeOf(shown) / sizeOf(this) : 1;
    return [...links, this.rail.carriage.map(([dx, dy]) => [x + scale * dx, y + scale * dy])];
  }

  /** Return name → normal and offset [m] of each wall in its position at a frame. */
  wallsAt(frame) {
    const moved = this.moved.map(([name, values]) => {
      const { normal, offset } = this.walls[name];
      return [name, { normal, offset: offset + this.between(values, frame) }];
    });
    return { ...this.walls, ...Object.fromEntries(moved) };
  }

  /** Return name → free side of each wall and of each stop of a slider at a frame. */
  sidesAt(frame) {
    return { ...this.wallsAt(frame), ...this.rail?.stops };
  }

  /**
   * Return the contacts with a force at a frame, each with point, wall, normal force [N] (at a stop of a joint: moment [N·m]), dry friction
   * along the wall [N], whether the contact sticks, and whether the force only holds the point after an impulse. Unknown friction is 0.
   */
  contactsAt(frame) {
    return this.forces
      .map(({ point, wall, force, friction, spans, holds }) => ({
        point,
        wall,
        force: this.betweenRows(force, frame),
        friction: friction ? this.betweenRows(friction, frame) : 0,
        sticks: isWithin(spans, frame),
        holds,
      }))
      .filter(({ force }) => force > 0);
  }

  /** Return the entries of a group of `drawn_outputs.py` at a frame: number `n` and `name` of the owner, and quantity → value. */
  drawnAt(group, frame) {
    return this.drawn[group].map(({ n, name, columns }) =>
      ({ n, name, ...mapValues(columns, (values) => this.betweenRows(values, frame)) }));
  }

  /** Return the numbers of the joints that stick at a frame; 0 stands for a slider. */
  stuckJointsAt(frame) {
    return this.stuckJoints.filter(({ spans }) => isWithin(spans, frame)).map(({ joint }) => joint);
  }

  /**
   * Return the present contact at a time [s], which list, chart and caption describe: the latest contact that is in force at this time.
   * If none is, it is the latest contact or, if the time is nearer to the next onset than to the end of the latest contact, the next one.
   * Before all impacts it is the first one; undefined without impacts.
   */
  contactAt(time) {
    return this.impacts.findLast(({ onset, end }) => onset <= time && time <= end) ?? this.impacts[lastBefore(this.turns, time)];
  }
}
