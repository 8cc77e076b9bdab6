// A function that computes new values for a table.

/** Return a table with each value of another table replaced by the value of a function. */
export function mapped(table, of) {
  return Object.fromEntries(Object.entries(table).map(([key, value]) => [key, of(value)]));
}
