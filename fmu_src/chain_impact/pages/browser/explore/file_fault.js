// Why a scene file cannot be opened, with the line of the fault and the key that the reader most likely meant.

import { nearestText } from "../base/similar_names.js";

/** Return the dotted names of all keys of scene files, without indices: "chain.links.mass". */
function namesOfKeys(keys, before = "") {
  return Object.entries(keys).flatMap(([key, { keys: inner = {} }]) => [before + key, ...namesOfKeys(inner, `${before}${key}.`)]);
}

/** Return a path of a key → the first line, from 1, that names it in the text of a scene file: "chain.links[2].mass" → 12. */
function linesOf(text) {
  const [lines, counts] = [new Map(), new Map()];
  const whole = (name) => name.split(".").reduce((before, part) => {
    const path = before ? `${before}.${part}` : part;
    return counts.has(path) ? `${path}[${counts.get(path)}]` : path;
  }, "");
  let table = "";
  text.split("\n").forEach((line, k) => {
    const [, list, head, key] = /^\s*(?:\[\[([\w.-]+)\]\]|\[([\w.-]+)\]|([\w.-]+)\s*=)/.exec(line) ?? [];
    if (list) {
      const [, before, last] = /^(?:(.*)\.)?([\w-]+)$/.exec(list);
      const path = [before && whole(before), last].filter(Boolean).join(".");
      counts.set(path, (counts.get(path) ?? 0) + 1);
      if (!lines.has(path)) lines.set(path, k + 1);
      table = `${path}[${counts.get(path)}]`;
    } else if (head) {
      table = whole(head);
    }
    const path = key ? [table, key].filter(Boolean).join(".") : table;
    if ((list || head || key) && !lines.has(path)) lines.set(path, k + 1);
  });
  return lines;
}

/**
 * Return words for the error on a scene file with the `text`: the line of the key, or of the part of the file that has it, if the text
 * names it; and for an unknown key the most similar one in place of all keys. `keys`: the rules of the keys of scene files.
 */
export function fileFault({ message }, text, keys) {
  const [, path] = /^([\w.[\]]+) /.exec(message) ?? [];
  const near = path && message.includes(" is unknown; ") ? nearestText(path.replaceAll(/\[\d+\]/g, ""), namesOfKeys(keys)) : "";
  const told = (near ? message.replace(/; the keys here are .*/s, near) : message).replace(/\.$/, "");
  const lines = linesOf(text);
  const parts = (path ?? "").split(/\.|(?=\[)/);
  const known = parts.map((_, k) => parts.slice(0, parts.length - k).join(".").replaceAll(".[", "[")).find((part) => lines.has(part));
  return `${told}${known === undefined ? "" : ` (line ${lines.get(known)})`}.`;
}
