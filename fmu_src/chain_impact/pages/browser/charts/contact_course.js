// The course of a contact as the chart of its force shows it, and the extent and the ticks of the chart's axes.

import { amountText } from "../base/format.js";
import { hasImpulseOnly, lastBefore } from "../recording/recording.js";

export const SHOWN_SHARE = 0.35; // time that the chart shows before and after a contact, relative to the contact's duration
// a contact that is longer than its impact by this factor is shown in parts: its impact, then the time around the present one
const LONG = 3;
// largest extent of both axes, relative to the curves of the contact itself: parts of compared curves beyond it are cut off, but an axis
// of forces is then one of square roots, with the extent MOST_OF_ROOTS
export const [MOST_BESIDE, MOST_OF_ROOTS] = [2.2, 40];
const ROOT_TICKS_APART = 28; // [pixels] about the least distance between two ticks of an axis of square roots
// least energy loss that is told as a number, relative to the work up to the largest penetrations, and least number of rows during a
// contact with which sums over rows have smaller errors
const [LEAST_LOSS, LEAST_ROWS] = [0.002, 40];
const ROOT_DECADES = 1e-4; // least tick of such an axis, relative to its end

/** Return the largest of the numbers in some arrays, but at least a tiny positive number, so that an axis up to it has a length. */
export function highest(...all) {
  return Math.max(1e-12, ...all.map((numbers) => numbers.reduce((most, value) => Math.max(most, value), 0)));
}

/**
 * Return the end of an axis that begins at 0: the largest of the contact's own values or of the values of compared curves, but at most
 * `limit` times the largest of the contact's own values, if one of these is above 0. `own` and `others` are lists of lists of numbers.
 */
export function extentOf(own, others, limit = MOST_BESIDE) {
  const [most, all] = [highest(...own), highest(...own, ...others)];
  return most > highest() ? Math.min(all, limit * most) : all;
}

/** Return the ticks of an axis of square roots from 0 to `high`: 0, and 1, 2 or 5 times powers of ten; `height`: of its chart [pixels]. */
export function rootTicks({ height }, high) {
  const ticks = [];
  const placeOf = (value) => height * Math.sqrt(value / high);
  const isApart = (value) => placeOf(value) > ROOT_TICKS_APART && !(placeOf(ticks.at(-1)) - placeOf(value) < ROOT_TICKS_APART);
  for (let power = 10 ** Math.floor(Math.log10(high)); power > ROOT_DECADES * high; power /= 10) {
    for (const value of [5, 2, 1].map((factor) => Number((factor * power).toPrecision(1)))) {
      if (value <= high && isApart(value)) ticks.push(value);
    }
  }
  return [...ticks, 0].reverse();
}

/**
 * Return the course of a contact: `times` since its onset [s], and the values of `force`, `penetration` and `friction` at these times.
 * The times are those of the recording's rows from a short time before the contact to a short time after it. Before and after the contact,
 * force, penetration and friction are 0. An unknown penetration or friction is undefined; an unknown force is 0.
 */
export function courseAround(recording, contact) {
  const { onset, end } = contact;
  const margin = SHOWN_SHARE * Math.max(end - onset, 1e-6);
  const { rowTime: time } = recording;
  const columns = recording.courseOf(contact);
  const first = lastBefore(time, onset - margin);
  const last = lastBefore(time, end + margin) + 2;
  const times = Array.from(time.slice(first, last), (now) => now - onset);
  const during = (all) => all && times.map((now, index) => (now >= 0 && now <= end - onset ? all[first + index] : 0));
  const [force, penetration, friction] = [columns.force, columns.penetration, columns.friction].map(during);
  return { times, force: force ?? times.map(() => 0), penetration, friction };
}

/**
 * Return words for the energy that a contact loses, the area of the loop of its course: the sum over trapezoids between rows; "" if there
 * are too few rows during the contact, or if the sum is no loss.
 */
export function lossText({ force, penetration }) {
  const works = force.slice(1).map((next, k) => ((next + force[k]) / 2) * (penetration[k + 1] - penetration[k]));
  const sumOf = (numbers) => numbers.reduce((sum, work) => sum + work, 0);
  const [loss, compression] = [sumOf(works), sumOf(works.filter((work) => work > 0))];
  if (force.filter((value) => value > 0).length < LEAST_ROWS || loss < -LEAST_LOSS * compression) return "";
  return loss > LEAST_LOSS * compression ? `loss\u00a0${amountText(loss, "J", 2)}` : `loss below ${100 * LEAST_LOSS}\u202f%`;
}

/**
 * Return the impulses of the impacts of a recording at rigid walls or, if `contact` is at a rigid stop of a joint, at such stops, as
 * points of a curve [times, impulses] that rises from 0 to each impulse and falls to 0 again. A rest, whose impulse grows with time, is
 * left out, except for the `contact` itself.
 */
export function impulsesLike({ impacts }, contact) {
  const alike = impacts.filter((impact) => hasImpulseOnly(impact) && Boolean(impact.atStop) === Boolean(contact.atStop) &&
    (impact === contact || Number.isFinite(impact.separation_speed ?? NaN)));
  return [alike.flatMap(({ onset }) => [onset, onset, onset]), alike.flatMap(({ impulse }) => [0, impulse, 0])];
}

/**
 * Return the part of a contact that the chart shows at the time `now` [s]: {from, to, isAroundNow}, with times [s] since the onset. It is
 * the whole contact or, of a long one (LONG), up to the end of its impact the impact, and then a part around `now`, at most `longest` [s]
 * long. This part moves by half of its length at once, so that the axis rests meanwhile.
 */
export function shownPartOf({ onset, end, impactEnd }, now, longest) {
  const [duration, impact, since] = [end - onset, impactEnd - onset, now - onset];
  if (!(duration > LONG * impact)) return { from: 0, to: duration, isAroundNow: false };
  if (since <= impact && impact > 0) return { from: 0, to: impact, isAroundNow: false };
  const length = Math.min(duration, longest);
  const steps = Math.max(0, Math.floor((2 * since) / length - 0.5));
  const from = Math.min((steps * length) / 2, duration - length);
  return { from, to: from + length, isAroundNow: true };
}
