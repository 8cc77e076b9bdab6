// Whole numbers.

/** Return the numbers from 0 to length − 1. */
export const range = (length) => Array.from({ length }, (_, k) => k);
