// The reader of numbers that `recorded.py` has packed.

import { bytesIn, numbersIn } from "../base/base64.js";

/** Return the numbers low + (high − low) · integer / FINEST. */
function numbers({ low, high, values }) {
  const scale = (high - low) / SHARED.packed.FINEST;
  return Float64Array.from(new Uint16Array(bytesIn(values).buffer), (value) => low + scale * value);
}

/** Return numbers at every row, from numbers that are packed for some rows; the others are zero. */
function atAllRows(packed, rows, count) {
  const values = new Float64Array(count);
  numbers(packed).forEach((value, k) => {
    values[rows[k]] = value;
  });
  return values;
}

/** Return the rows of a recording, in the form for `framesOf`. */
export function unpack(packed) {
  const time = numbersIn(packed.time);
  const [x, y] = [packed.x, packed.y].map(numbers);
  const energies = Object.entries(packed.energies).map(([name, values]) => [name, numbers(values)]);
  const touches = packed.touches.map(({ point, wall, rows, ...columns }) => {
    const rowNumbers = new Uint32Array(bytesIn(rows).buffer);
    const known = Object.entries(columns).map(([name, values]) => [name, atAllRows(values, rowNumbers, time.length)]);
    return { point, wall, ...Object.fromEntries(known) };
  });
  const loads = packed.loads.map(({ joint, ...force }) => ({ joint, x: numbers(force.x), y: numbers(force.y) }));
  const moved = Object.fromEntries(Object.entries(packed.moved).map(([name, values]) => [name, numbers(values)]));
  return { ...packed, moved, time, x, y, energies: Object.fromEntries(energies), touches, loads };
}
