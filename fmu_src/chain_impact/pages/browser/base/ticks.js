// Round numbers for the ticks of an axis.

const TICK_STEPS = [5, 2.5, 2, 1]; // allowed distances between ticks, as multiples of a power of ten
// numbers whose difference is at most this, relative to the larger one, differ by round-off and count as equal
const EQUALITY_TOLERANCE = 1e-9;

/** Return whether two numbers, of which the first is not larger, are equal up to round-off. */
export function areSame(low, high) {
  return high - low <= EQUALITY_TOLERANCE * Math.max(Math.abs(low), Math.abs(high));
}

/**
 * Return the ticks of an axis from `low` to `high`: the multiples of the largest round step that gives at least `fewest` ticks, at most 10.
 * With `whole`, all ticks are whole numbers, even if there are fewer. An axis whose length is 0 or infinite has one tick, `low`.
 */
export function ticksBetween(low, high, fewest = 4, whole = false) {
  if (areSame(low, high) || !(high - low < Infinity)) return [low];
  const power = 10 ** Math.floor(Math.log10(high - low));
  const endsOf = (step) => [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)];
  const steps = [power, power / 10].flatMap((unit) => TICK_STEPS.map((factor) => factor * unit));
  const step = steps.filter((candidate) => !whole || Number.isInteger(candidate)).find((candidate) => {
    const [first, last] = endsOf(candidate);
    return last - first + 1 >= fewest;
  }) ?? 1;
  const [first, last] = endsOf(step);
  return Array.from({ length: last - first + 1 }, (_, k) => Number(((first + k) * step).toPrecision(9)));
}
