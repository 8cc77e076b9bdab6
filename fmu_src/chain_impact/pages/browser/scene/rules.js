// The rules of `scene/rules.py`, which Python parses: here their trees are evaluated as there.

const ARITHMETIC = { "+": (a, b) => a + b, "*": (a, b) => a * b };

const COMPARISONS = {
  "==": (a, b) => a === b,
  "!=": (a, b) => a !== b,
  "<": (a, b) => a < b,
  ">": (a, b) => a > b,
  "<=": (a, b) => a <= b,
  ">=": (a, b) => a >= b,
  in: (value, entries) => entries.includes(value),
};

/** Return the value of a part of a rule, of a condition 0 or 1; null if it is missing. */
function valueIn({ name, constant, operator, parts }, valueOf) {
  if (!parts) return name ? numbered(valueOf(name)) : constant;
  if (operator === "any" || operator === "sum") return ofMembers(operator, valueIn(parts[0], valueOf) ?? [], parts[1], valueOf);
  if (operator === "and") return numbered(parts.every((part) => holds(part, valueOf)));
  if (operator === "or") return numbered(parts.some((part) => holds(part, valueOf)));
  if (operator === "not") return numbered(!holds(parts[0], valueOf));
  const [first, second] = parts.map((part) => valueIn(part, valueOf));
  if (operator === "given") return numbered(first !== null);
  if (first === null || second === null) return operator in ARITHMETIC ? null : 0;
  return numbered((ARITHMETIC[operator] ?? COMPARISONS[operator])(first, second));
}

/** Return whether a part of a rule holds for any member, or its sum over all members. */
function ofMembers(operator, members, of, valueOf) {
  const ofMember = (member, order) => (name) => (name === "order" ? order : name in member ? member[name] : valueOf(name));
  if (operator === "any") return numbered(members.some((member, order) => holds(of, ofMember(member, order))));
  const values = members.map((member, order) => valueIn(of, ofMember(member, order)));
  return values.includes(null) ? null : values.reduce((sum, value) => sum + value, 0);
}

/** Return a condition as 0 or 1, a missing value as null, and any other value as it is. */
function numbered(value) {
  return typeof value === "boolean" ? Number(value) : value ?? null;
}

function isSo(value) {
  return Array.isArray(value) ? value.some(isSo) : Boolean(value);
}

/** Return whether a rule holds; `valueOf` returns the value of a name. */
export function holds(rule, valueOf) {
  return isSo(valueIn(rule, valueOf));
}

/** Return the number that a rule stands for; null if a value is missing. */
export function numberIn(rule, valueOf) {
  return valueIn(rule, valueOf);
}
