// Evaluates the rules of `scene/rules/rule_language.py`, which Python has parsed to trees.
// The twin in Python is `scene/rules/rule_language.py`.

import { range } from "../base/range.js";

const ARITHMETIC = { "+": (a, b) => a + b, "*": (a, b) => a * b };

const COMPARISONS = {
  "==": (a, b) => a === b,
  "!=": (a, b) => a !== b,
  "<": (a, b) => a < b,
  ">": (a, b) => a > b,
  "<=": (a, b) => a <= b,
  ">=": (a, b) => a >= b,
};

/** Return the value of a part of a rule: 0 or 1 for a condition. Arithmetic with a missing value (null) gives null, a comparison 0. */
function valueIn({ name, constant, operator, parts }, valueOf) {
  if (!parts) return name ? toNumber(valueOf(name)) : constant;
  if (operator === "any" || operator === "sum") return ofMembers(operator, valuesOfMembers(parts[0], valueOf), parts[1]);
  if (operator === "and") return toNumber(parts.every((part) => isRuleTrue(part, valueOf)));
  if (operator === "or") return toNumber(parts.some((part) => isRuleTrue(part, valueOf)));
  if (operator === "not") return toNumber(!isRuleTrue(parts[0], valueOf));
  const [first, second] = parts.map((part) => valueIn(part, valueOf));
  if (operator === "has_value") return toNumber(first !== null);
  if (first === null || second === null) return operator in ARITHMETIC ? null : 0;
  if (operator === "in") return toNumber(second.includes(first));
  return toNumber((ARITHMETIC[operator] ?? COMPARISONS[operator])(toCount(first), toCount(second)));
}

/**
 * Return the value of any(…) or sum(…) for the `members` from `valuesOfMembers`: whether the rule `of` is true for any member, or the sum
 * of the numbers that the rule gives for all members, null if a number is missing.
 */
function ofMembers(operator, members, of) {
  if (operator === "any") return toNumber(members.some((valueOf) => isRuleTrue(of, valueOf)));
  const values = members.map((valueOf) => valueIn(of, valueOf));
  return values.includes(null) ? null : values.reduce((sum, value) => sum + value, 0);
}

/** Return 0 or 1 for a condition, null for a missing value, and any other value as it is. */
function toNumber(value) {
  return typeof value === "boolean" ? Number(value) : value ?? null;
}

function toList(value) {
  return Array.isArray(value) ? value : Object.values(value ?? {});
}

function toCount(value) {
  return Array.isArray(value) ? value.length : value;
}

function isTruthy(value) {
  if (Array.isArray(value)) return value.some(isTruthy);
  return typeof value === "object" && value !== null ? Object.keys(value).length > 0 : Boolean(value);
}

/** Return whether a rule is true; `valueOf` is a function from a name in the rule to its value. */
export function isRuleTrue(rule, valueOf) {
  return isTruthy(valueIn(rule, valueOf));
}

/** Return the number or text that a rule gives, for a list the number of entries; null if the rule gives no value. */
export function numberIn(rule, valueOf) {
  return toCount(valueIn(rule, valueOf));
}

/** Return the members of the list that a rule names; if the rule gives a number, so many members without values. */
export function membersIn(rule, valueOf) {
  const value = valueIn(rule, valueOf);
  return typeof value === "number" ? range(value).map(() => ({})) : toList(value);
}

/**
 * Return, for each member of the list that a rule names, a function from a name to its value: `order`, the index of the member (from
 * 0); a value of the member; or else the result of `valueOf`. If the member is a table of the file, each name without a dot is a key of
 * this table; the value of a key that the file leaves out is undefined, not the default.
 */
export function valuesOfMembers(rule, valueOf) {
  const isInFile = rule.name?.includes(".");
  return membersIn(rule, valueOf).map((member, order) => (name) => {
    if (name === "order") return order;
    return name in member || (isInFile && !name.includes(".")) ? member[name] : valueOf(name);
  });
}
