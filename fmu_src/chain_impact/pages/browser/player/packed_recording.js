// The reader of the numbers that `recorded.py` has packed.

import { bytesIn, numbersIn } from "../base/base64.js";
import { mapped } from "../base/mapped.js";

/** Return the numbers low + (high − low) · integer / FINEST. */
function numbers({ low, high, values }) {
  const scale = (high - low) / SHARED.packed.FINEST;
  return Float64Array.from(new Uint16Array(bytesIn(values).buffer), (value) => low + scale * value);
}

/**
 * Return a function that returns numbers at every row, from numbers that are packed for some rows; in all other rows the numbers are zero.
 */
function atAllRows(packedRows, count) {
  const rows = new Uint32Array(bytesIn(packedRows).buffer);
  return (packed) => {
    const values = new Float64Array(count);
    numbers(packed).forEach((value, k) => {
      values[rows[k]] = value;
    });
    return values;
  };
}

/** Return the rows of a recording, in the form for `framesOf`. */
export function unpack(packed) {
  const time = numbersIn(packed.time);
  const [x, y] = [packed.x, packed.y].map(numbers);
  const drawn = mapped(packed.drawn, (entries) => entries.map(({ n, name, rows, columns }) =>
    ({ n, name, columns: mapped(columns, atAllRows(rows, time.length)) })));
  return { ...packed, moved: mapped(packed.moved, numbers), time, x, y, drawn };
}
