// Paths in a scene file: lists of keys and of indices from 0.

/** Return the value at a path of a file; undefined if a table on the way is missing. */
export const inFile = (file, path) => path.reduce((table, step) => table?.[step], file);

/** Return a path in a file as text, with numbers from 1. */
export function pathText(path) {
  return path.map((step) => (typeof step === "number" ? `[${step + 1}]` : `.${step}`)).join("").replace(/^\./, "");
}
