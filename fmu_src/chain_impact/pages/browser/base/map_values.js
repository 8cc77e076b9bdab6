// Computes a table with new values for the same keys.

/** Return a table with the same keys, in which each value is replaced by the result of the function `of` for it. */
export function mapValues(table, of) {
  return Object.fromEntries(Object.entries(table).map(([key, value]) => [key, of(value)]));
}
