// The sentences with which the page refuses the contents of a scene file: those of Python, in `refusals.py`.

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

/** Refuse a name at a path of the file that is not the name of a wall; `value`: the start of the sentence. */
export function refuseWall(path, walls, value = "") {
  if (!walls.length) refuse(path, "no_walls");
  refuse(path, "no_wall", { value, walls: walls.join(", ") });
}
