// What `recorded.py` packed, as numbers.

const FINEST = 65535; // of 16 bits

/** The bytes of a text in base64. */
function bytes(text) {
  return Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0)).buffer;
}

/** The numbers low + (high − low) · integer / 65535. */
function numbers({ low, high, values }) {
  const scale = (high - low) / FINEST;
  return Float64Array.from(new Uint16Array(bytes(values)), (value) => low + scale * value);
}

/** Numbers at every row, of some that are packed for some rows, and else zero. */
function whole(packed, places, count) {
  const values = new Float64Array(count);
  numbers(packed).forEach((value, k) => {
    values[places[k]] = value;
  });
  return values;
}

/** The rows of a recording, as `framesOf` takes them. */
export function unpack(packed) {
  const time = new Float64Array(bytes(packed.time));
  const [x, y] = [packed.x, packed.y].map(numbers);
  const energies = Object.entries(packed.energies).map(([name, values]) => [name, numbers(values)]);
  const touches = packed.touches.map(({ point, wall, rows, ...columns }) => {
    const places = new Uint32Array(bytes(rows));
    const known = Object.entries(columns).map(([name, values]) => [name, whole(values, places, time.length)]);
    return { point, wall, ...Object.fromEntries(known) };
  });
  const loads = packed.loads.map(({ joint, ...force }) => ({ joint, x: numbers(force.x), y: numbers(force.y) }));
  const moved = Object.fromEntries(Object.entries(packed.moved).map(([name, values]) => [name, numbers(values)]));
  return { ...packed, moved, time, x, y, energies: Object.fromEntries(energies), touches, loads };
}
