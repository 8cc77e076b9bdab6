// Functions that make or examine lists of numbers.

/** Return the numbers from 0 to length − 1. */
export const range = (length) => Array.from({ length }, (_, k) => k);

/** Return [the least, the largest] of some numbers; [∞, −∞] without numbers. */
export function endsOf(numbers) {
  let [low, high] = [Infinity, -Infinity];
  for (const number of numbers) {
    low = Math.min(low, number);
    high = Math.max(high, number);
  }
  return [low, high];
}
