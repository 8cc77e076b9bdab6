// The scene file with the changes that the reader has made on the page: its contents, and its text as TOML.

import { numberText } from "../base/format.js";
import { asWritten } from "./scene_file.js";

/** Return the contents of the scene file with the reader's changes, except those of inputs, and with `signals`, name → signal. */
export function contentsOf(changes, signals = {}) {
  const file = structuredClone(changes.scene.file);
  for (const [name, value] of Object.entries(changes.values)) {
    const { filePath, items } = changes.parameters.get(name);
    if (filePath) put(file, filePath, items.length ? items[value - 1][0] : value);
  }
  Object.assign(file.signals, signals);
  return asWritten(file);
}

/** Return the contents of a scene file as TOML, without values that equal the defaults of their keys; `keys`: the rules of all keys. */
export function tomlText(file, keys) {
  return blocksOf(file, { keys }, "").join("\n");
}

/**
 * Return the text for a table as a list of blocks: first the `headline` and the values that are not defaults, if there are any,
 * then the blocks of the tables inside it. `{ kind, keys }`: the rule of the table, `name`: its dotted name.
 */
function blocksOf(table, { kind, keys }, name, headline = "") {
  const ruleOf = (key) => (kind === "named" ? { kind: "table", keys } : keys[key]);
  const isValue = ([key]) => !["table", "tables", "named"].includes(ruleOf(key).kind);
  const given = Object.entries(table).filter(([key, value]) => JSON.stringify(value) !== JSON.stringify(ruleOf(key).default));
  const lines = given.filter(isValue).map(([key, value]) => `${key} = ${tomlOf(value)}\n`);
  const inner = given.filter((pair) => !isValue(pair)).flatMap(([key, value]) => {
    const path = name ? `${name}.${key}` : key;
    const title = Array.isArray(value) ? `[[${path}]]\n` : `[${path}]\n`;
    return [value].flat().flatMap((inside) => blocksOf(inside, ruleOf(key), path, title));
  });
  return [...(lines.length ? [headline + lines.join("")] : []), ...inner];
}

/** Put a value at its path in a scene file, and create tables on the path that are missing. */
function put(table, [key, ...rest], value) {
  if (rest.length) put((table[key] ??= {}), rest, value);
  else table[key] = value;
}

/** Return a value as text in TOML. */
function tomlOf(value) {
  if (Array.isArray(value)) return `[${value.map(tomlOf).join(", ")}]`;
  if (typeof value === "number") return numberText(value);
  return JSON.stringify(value);
}
