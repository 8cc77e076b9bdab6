// Why the text of a scene file cannot be opened, with the line of the fault.

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
 * Return words for the error on a scene file with the `text`: with the line of the key or, if the text does not name it, of the part of the
 * file that has it. `path`: the path of the key; an error in TOML has none, and names its line itself.
 */
export function fileFault({ message, path = "" }, text) {
  const lines = linesOf(text);
  const parts = path.split(/\.|(?=\[)/);
  const known = parts.map((_, k) => parts.slice(0, parts.length - k).join(".").replaceAll(".[", "[")).find((part) => lines.has(part));
  return `${message.replace(/\.$/, "")}${known === undefined ? "" : ` (line ${lines.get(known)})`}.`;
}
