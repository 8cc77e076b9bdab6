// The words for inputs and for the numbers of signals, in place of their names.

// the quantities of a base by the first letter of their names: x, vx, ax
const OF_BASE = { x: "position", y: "position", v: "velocity", a: "acceleration" };

/** Return the words for an input: "Force on the tip, x" for tip.force.x, "Target angle of joint 2" for joint[2].target_angle. */
export function inputText(name) {
  const [head, ...rest] = name.split(".");
  const inHead = { base: [OF_BASE[rest[0][0]], rest[0].at(-1)], wall: [rest[1]] }[head];
  const [key, axis] = inHead ?? rest;
  const owner = head === "wall" ? rest[0] : head.includes("[") ? head.replace(/\[(\d+)\]/, " $1") : `the ${head}`;
  const words = `${key.replaceAll("_", " ")} ${key === "force" ? "on" : "of"} ${owner}${axis ? `, ${axis}` : ""}`;
  return words[0].toUpperCase() + words.slice(1);
}

/** Return the words for a number of a signal: "push: value 1" for the key value[1] of the signal push. */
export function signalText(signal, key) {
  return `${signal}: ${key.replaceAll("_", " ").replace(/\[(\d+)\]$/, "\u00a0$1")}`;
}
