// The sentences and rules with which the page refuses the contents of a scene file: those of Python, in `refusals.py`.

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

/** Refuse the value at a path of the file with the sentence of a fault, in which words stand for the texts in braces. */
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
  ">=": (a, b) => a >= b,
};

/** Return whether a part of a condition of a rule holds. */
function isSo([first, comparison, other], valueOf) {
  if (other === undefined) {
    const value = valueOf(comparison ?? first);
    return (Array.isArray(value) ? value.some(Boolean) : Boolean(value)) !== (first === "not");
  }
  const operand = other.startsWith("'") ? other.slice(1, -1) : /^\d+$/.test(other) ? Number(other) : valueOf(other);
  return valueOf(first) !== undefined && operand !== undefined && OPERATORS[comparison](valueOf(first), operand);
}

/**
 * Refuse the first value that a rule refuses; `valueOf` returns the value of a key or fact, `path` is that of the table, and
 * `words` are further words of the sentences.
 */
export function keepRules(rules, valueOf, path = "", words = {}) {
  const rule = rules.find(([, , condition]) => condition.split(" and ").every((part) => isSo(part.split(" "), valueOf)));
  if (!rule) return;
  const [fault, key, , least] = rule;
  refuse(path + key, fault, { ...words, value: shown(valueOf(key)), least: least && valueOf(least) });
}

/** Refuse a name at a path of the file that is not the name of a wall; `value`: the start of the sentence. */
export function refuseWall(path, walls, value = "") {
  if (!walls.length) refuse(path, "no_walls");
  refuse(path, "no_wall", { value, walls: walls.join(", ") });
}
