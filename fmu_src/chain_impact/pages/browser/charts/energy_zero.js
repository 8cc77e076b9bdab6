// The zero of the potential energy in a chart.
// The twin in Python is `pictures/over_time/energies.py`.

import { digits } from "../base/format.js";
import { endsOf } from "../base/range.js";

// the zero of the potential energy is moved if this makes the range of all energies and 0 less than RANGE_SHARE times as large
const RANGE_SHARE = 0.8;
const MOVED_ENERGIES = ["potential", "total"];

/**
 * Return the number [J] that a chart adds to the potential and the total energy, so that the least potential energy is about 0. The number
 * is rounded up to two significant digits; it is 0 if it would not make the range much smaller (RANGE_SHARE). `energies`: name → values.
 */
export function energyOffset(energies) {
  const least = endsOf(energies.potential ?? [0])[0];
  if (least === 0 || !Number.isFinite(least)) return 0;
  const step = 10 ** (Math.floor(Math.log10(Math.abs(least))) - 1);
  const offset = Math.ceil(Number((-least / step).toFixed(6))) * step;
  return energyRange(movedBy(energies, offset)) < RANGE_SHARE * energyRange(energies) ? offset : 0;
}

/** Return what an offset [J] adds to the energy with a name. */
export function shiftOf(name, offset) {
  return MOVED_ENERGIES.includes(name) ? offset : 0;
}

/** Return energies, name → values, with an offset [J] added to the potential and the total energy. */
export function movedBy(energies, offset) {
  return Object.fromEntries(Object.entries(energies).map(([name, values]) =>
    [name, shiftOf(name, offset) ? values.map((value) => value + offset) : values]));
}

/** Return the end of the chart's title, after the unit: the offset [J] with the names of the moved energies (MOVED_ENERGIES); "" for 0. */
export function offsetText(offset) {
  return offset ? `shown: ${MOVED_ENERGIES.join(" and ")} ${offset > 0 ? "+" : "−"} ${digits(Math.abs(offset), 2)}\u202fJ` : "";
}

/** Return the size [J] of the range that contains 0 and all values of all energies. */
function energyRange(energies) {
  const ends = [0, ...Object.values(energies).flatMap(endsOf)];
  return Math.max(...ends) - Math.min(...ends);
}
