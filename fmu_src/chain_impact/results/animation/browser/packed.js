// What `page.py` packed, as numbers.

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

/** A force at every frame, of one that is packed without its zeros. */
function wholeForce({ point, wall, frames, friction, spans = [], ...rest }, count) {
  const places = new Uint32Array(bytes(frames));
  const whole = (packed) => {
    const values = new Float32Array(count);
    const sparse = numbers(packed);
    places.forEach((frame, index) => {
      values[frame] = sparse[index];
    });
    return values;
  };
  return { point, wall, values: whole(rest), friction: friction && whole(friction), spans };
}

/** What a `Recording` is made of. */
export function unpack(packed) {
  const time = new Float64Array(bytes(packed.time));
  const [x, y] = packed.points.map(numbers);
  const energies = Object.entries(packed.energies).map(([name, values]) => [name, numbers(values)]);
  const forces = packed.forces.map((force) => wholeForce(force, time.length));
  return { ...packed, time, x, y, energies: Object.fromEntries(energies), forces };
}
