// Round numbers for the ticks of an axis.

const TICK_STEPS = [5, 2.5, 2, 1]; // the allowed steps between ticks, relative to a power of ten

/**
 * Return round numbers between two numbers: with the largest round step that gives `fewest` or more numbers, and at most 10. With `whole`
 * the numbers are whole numbers, of which there may be fewer.
 */
export function ticksBetween(low, high, fewest = 4, whole = false) {
  if (!(high > low && high - low < Infinity)) return [low];
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
