// The words for a run that has a fault: why, and what to change.

// advice that depends on the tolerance: the limit of the tolerance, the advice above it, and the advice up to it
const BY_TOLERANCE = /^if solver\.tolerance is above (\S+), (lower) it([^;]*); else (raise) it(.*)$/;

/**
 * Return [reason, advice, part] for the fault of a run: the advice names only what the scene has (`fittingAdvice`); the part is that of the
 * scene that causes the fault. Advice and part are "" if the fault has none.
 */
export function faultWords({ status, part }, changes) {
  const [reason, ...advice] = SHARED.kernel.STATUS_TEXT[status].split(": ");
  return [reason, fittingAdvice(advice.join(": "), changes), changes.scene.partsInWords[part - 1] ?? ""];
}

/**
 * Return advice without its parts on what the scene does not have: parameters that it lacks, joints without a stiffness, and walls that
 * move. Advice that depends on the tolerance has only the part for the present tolerance.
 */
function fittingAdvice(advice, { scene, parameters, valueOf }) {
  const isThere = (name) => (name.includes(".") ? parameters.has(name)
    : [...parameters.keys()].some((other) => other.endsWith(`.${name}`) && valueOf(other) !== 0));
  const fits = (part) => (part.match(/\b[a-z]\w*\.\w+|\b[a-z]+_\w+/g) ?? []).every(isThere)
    && (scene.moved.length > 0 || !part.startsWith("for walls that move"));
  const [, limit, ...ways] = BY_TOLERANCE.exec(advice) ?? [];
  if (limit) return `${ways.slice(...(valueOf("solver.tolerance") > Number(limit) ? [0, 2] : [2])).join(" solver.tolerance")}`;
  const parts = advice.split("; ").map((part) => withoutLacking(part, isThere)).filter((part) => !part.startsWith("for ") || fits(part));
  return parts.length === 1 ? parts[0].replace(/^for [^,]*, /, "") : parts.join("; ");
}

/** Return a part of advice in which "or" is between two names, without the names for which the function `isThere` is false. */
function withoutLacking(part, isThere) {
  return part.replace(/\b([a-z]\w*\.\w+) or ([a-z]\w*\.\w+|the (\w+) of \w+)\b/g, (both, ...[first, second, key]) =>
    [first, second].filter((name) => isThere(name === second && key ? key : name)).join(" or ") || both);
}
