// Reads the numbers of a recording, which `recorded.py` has packed as integers from 0 to FINEST.

import { bytesIn, numbersIn } from "../base/base64.js";
import { mapValues } from "../base/map_values.js";
import { boxWallText } from "../scene/words.js";

/** Return the real numbers low + (high − low) · k / FINEST for packed integers k, which `values` has as text in base64. */
function numbers({ low, high, values }) {
  const scale = (high - low) / SHARED.packed.FINEST;
  return Float64Array.from(new Uint16Array(bytesIn(values).buffer), (value) => low + scale * value);
}

/**
 * Return a function that unpacks the numbers of some rows, and returns a number for each of `count` rows, 0 for a row without a packed one.
 * `packedRows`: the indices of the rows with packed numbers, as text in base64.
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

/** Return the packed recording as the argument `rows` of `framesOf`. */
export function unpack(packed) {
  const time = numbersIn(packed.time);
  const [x, y] = [packed.x, packed.y].map(numbers);
  const drawn = mapValues(packed.drawn, (entries) => entries.map(({ n, name, rows, columns }) =>
    ({ n, name, columns: mapValues(columns, atAllRows(rows, time.length)) })));
  const impacts = packed.impacts.map((impact) => ({ ...impact, boxWall: boxWallText(impact.wall, (name) => packed.gravity[name]) }));
  return { ...packed, impacts, moved: mapValues(packed.moved, numbers), time, x, y, drawn };
}
