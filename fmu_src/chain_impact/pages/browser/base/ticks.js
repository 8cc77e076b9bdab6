// The ticks of an axis.

const TICK_STEPS = [5, 2.5, 2, 1]; // steps between ticks, relative to a power of ten

/** Return round numbers between two numbers: with the largest round step at which they are `fewest` or more, at most 10. */
export function ticksBetween(low, high, fewest = 4) {
  if (!(high > low)) return [low];
  const power = 10 ** Math.floor(Math.log10(high - low));
  const endsOf = (step) => [Math.ceil(low / step - 1e-9), Math.floor(high / step + 1e-9)];
  const step = [power, power / 10].flatMap((unit) => TICK_STEPS.map((factor) => factor * unit)).find((candidate) => {
    const [first, last] = endsOf(candidate);
    return last - first + 1 >= fewest;
  });
  const [first, last] = endsOf(step);
  return Array.from({ length: last - first + 1 }, (_, k) => Number(((first + k) * step).toPrecision(9)));
}
