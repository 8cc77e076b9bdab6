// The sentences and rules with which the page refuses the contents of a scene file: those of Python, in `refusals.py`.

import { inFile, pathText } from "../base/paths.js";

/** Return a value for a message, written as in Python's messages; numbers may be written otherwise (1 for 1.0). */
export function shown(value) {
  const text = written(value);
  return text.length > SHARED.file.SHOWN ? `${text.slice(0, SHARED.file.SHOWN)}...` : text;
}

function written(value) {
  if (typeof value === "string") return value.includes("'") && !value.includes('"') ? `"${value}"` : `'${value.replaceAll("'", "\\'")}'`;
  if (Array.isArray(value)) return `[${value.map(written).join(", ")}]`;
  if (typeof value !== "object" || value === null) return String(value);
  return `{${Object.entries(value).map(([key, inner]) => `${written(key)}: ${written(inner)}`).join(", ")}}`;
}

/** Refuse the value at a path of the file with the sentence of a fault, in which `words` replace the names in braces. */
export function refuse(path, fault, words = {}) {
  const sentence = SHARED.refusals[fault].replace(/\{(\w+)\}/g, (_, word) => {
    if (words[word] === undefined) throw new Error(`${fault}: no word for ${word}`);
    return words[word];
  });
  throw new RangeError(`${path || "scene"} ${sentence}`);
}

const OPERATORS = {
  "==": (a, b) => a === b,
  "!=": (a, b) => a !== b,
  "<": (a, b) => a < b,
  ">": (a, b) => a > b,
  "<=": (a, b) => a <= b,
  ">=": (a, b) => a >= b,
};

/** Return the value of a sum of products of whole numbers, keys and facts; undefined if a value is missing. */
export function sumIn(text, valueOf) {
  const factor = (word) => (/^\d+$/.test(word) ? Number(word) : valueOf(word));
  const terms = text.split(" + ").map((term) => term.split("*").map(factor));
  if (terms.flat().includes(undefined)) return undefined;
  return terms.reduce((sum, factors) => sum + factors.reduce((product, value) => product * value, 1), 0);
}

/** Return whether one part of a rule's condition holds: a comparison, or a value, alone or after `not`. */
function isSo([first, comparison, ...others], valueOf) {
  if (!others.length) {
    const value = valueOf(comparison ?? first);
    return (Array.isArray(value) ? value.some(Boolean) : Boolean(value)) !== (first === "not");
  }
  const other = others.join(" ");
  const operand = other.startsWith("'") ? other.slice(1, -1) : sumIn(other, valueOf);
  return valueOf(first) !== undefined && operand !== undefined && OPERATORS[comparison](valueOf(first), operand);
}

/**
 * Refuse the first value that a rule refuses; `valueOf` returns the value of a key or fact, `nameOf` the text for a key, and
 * `words` are further words of the sentences.
 */
export function keepRules(rules, valueOf, nameOf, words = {}) {
  const rule = rules.find(([, , condition]) => condition.split(" and ").every((part) => isSo(part.split(" "), valueOf)));
  if (!rule) return;
  const [fault, key, , bound] = rule;
  const least = bound && Number(sumIn(bound, valueOf).toPrecision(15));
  refuse(nameOf(key), fault, { ...words, value: shown(valueOf(key)), least, bound });
}

/**
 * Refuse the first value of a file that does not go together with others; `valueAt` and `textAt` return the value at a path of the
 * file, and its text.
 */
export function keepFileRules(file, valueAt = (path) => inFile(file, path), textAt = pathText) {
  const walls = Object.keys(file.contact.wall).map((name) => ["contact", "wall", name]);
  const tables = { "": [[]], link: file.chain.links.map((_, k) => ["chain", "links", k]), material: [["contact"], ...walls] };
  for (const rule of SHARED.rules.FILE) {
    const of = rule.at(-1);
    for (const table of tables[of]) {
      const pathOf = (key) => [...table, ...key.split(".")];
      const ownOf = (key) => valueAt(pathOf(key));
      // a wall with its own sliding friction has no static friction by default
      const inContact = (key) => (ownOf("friction") === undefined ? valueAt(["contact", key]) : 0);
      keepRules([rule], of === "material" ? (key) => ownOf(key) ?? inContact(key) : ownOf, (key) => textAt(pathOf(key)));
    }
  }
}

/** Refuse a name at a path of the file that is not the name of a wall; `value`: the start of the sentence. */
export function refuseWall(path, walls, value = "") {
  if (!walls.length) refuse(path, "no_walls");
  refuse(path, "no_wall", { value, walls: walls.join(", ") });
}
