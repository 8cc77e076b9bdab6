// Paths in a scene file: lists of keys and of indices from 0.

/** Return the value at a path of a scene file; undefined if the file lacks a key or entry of the path. */
export const valueInFile = (file, path) => path.reduce((table, step) => table?.[step], file);

/** Return a path of a scene file as text, in which indices count from 1. */
export function pathText(path) {
  return path.map((step) => (typeof step === "number" ? `[${step + 1}]` : `.${step}`)).join("").replace(/^\./, "");
}
