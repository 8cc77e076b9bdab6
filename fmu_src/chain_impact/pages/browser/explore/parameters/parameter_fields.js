// The fields for values of parameters. Each shows why a value is refused, and has a button that restores the scene's value.

import { byId, make } from "../../base/dom.js";
import { numberText, raised, readable, textWithUnit, unitOfPower, unitText } from "../../base/format.js";
import { ALL_DIGITS, DEGREE_DIGITS, inShownUnit, notUnderstood, shortText, shownIn, typed, valueText } from "../../scene/angles.js";
import { lawText } from "../../scene/words.js";
import { withControls } from "./main_parameters.js";

const EXAMPLES = "; sums, products and other units are taken, too: 2*0.6, 120 cm, pi/2 rad";

const MOST_TURNS = 10; // an angle of more turns may have been typed in another unit

/** Return a sentence on an angle of more than MOST_TURNS turns; "" for any other value. */
export function turnsText(changes, name) {
  const turns = Math.abs(changes.valueOf(name)) / (2 * Math.PI);
  const isLarge = changes.parameters.get(name).unit === "rad" && turns > MOST_TURNS && Number.isFinite(turns);
  return isLarge ? `These are ${numberText(Number(turns.toPrecision(3)))} turns.` : "";
}

/** Remove the marks of a refused and of a failing value from a field. */
function release(field) {
  field.setCustomValidity("");
  ["fails", "kept"].forEach((mark) => delete field.dataset[mark]);
}

/**
 * Call the function `change`; if it throws an error, because it refuses the field's value, mark the field, and show the reason in the
 * field's row; in the reason, words replace the names of parameters (`withControls`). `changes`: the object `Changes` of
 * the page.
 */
export function attempt(changes, field, change) {
  try {
    release(field);
    change();
  } catch (error) {
    const { parameter } = field.dataset;
    const advice = parameter && field.type === "text" ? notUnderstood(field.value, typedUnit(changes, parameter)) : "";
    const told = inShownUnit(withControls(error.message, changes));
    field.setCustomValidity(advice ? told.replace(" must be ", `: ${advice}. It must be `) : told);
    if (parameter) field.dataset.kept = ` The motion has ${writtenValue(changes, parameter, changes.valueOf(parameter))}.`;
  }
  const row = field.closest(".main-parameter, .parameter");
  explain(row);
  if (!field.validity.valid) row.querySelector(".refusal").scrollIntoView({ block: "nearest" }); // bars of a phone may hide the reason
}

/** Return an empty element for a row, in which `explain` shows why the row's value is refused. */
export function refusal() {
  const message = make("p", { className: "refusal" });
  message.setAttribute("role", "alert");
  return message;
}

/** Mark the fields of a parameter with whose value a run fails, until a parameter changes; `reason`: why it fails. */
export function markFailing(name, reason) {
  document.querySelectorAll(`#parameters [data-parameter="${name}"]`).forEach((field) => {
    field.setCustomValidity(reason);
    field.dataset.fails = "true"; // the page has taken the value, unlike a refused one
    explain(field.closest(".main-parameter, .parameter"));
  });
}

/** Scroll the row with the focus so far that it ends above the status, which covers the foot of a phone's page. */
export function keepAboveStatus() {
  const status = byId("status");
  const row = document.activeElement.closest(".main-parameter, .parameter");
  if (row && getComputedStyle(status).position === "sticky") {
    scrollBy(0, Math.max(row.getBoundingClientRect().bottom + 8 - status.getBoundingClientRect().top, 0));
  }
}

/** Show in the row of a parameter why the value is refused, or why a run with the value fails; else show no reason. */
export function explain(row) {
  const refused = [...row.querySelectorAll("input, select")].find((field) => !field.checkValidity());
  const reason = refused?.validationMessage ?? "";
  const told = reason && readable(`${refused.dataset.fails ? "Cannot start" : "Not taken"}: ${reason}.${refused.dataset.kept ?? ""}`);
  // in the sentence, a stiffness has the unit that is shown beside the field, with the present exponent
  row.querySelector(".refusal").textContent = told.replace(/(?<=\[)[^\]]*\^exponent(?=\])/, row.querySelector("small")?.textContent);
}

/**
 * Return the unit of a parameter as text if the parameters have the changed `values`: the unit of a stiffness depends on the law's
 * exponent.
 */
export function presentUnit(changes, name, values = changes.values) {
  const { unit } = changes.parameters.get(name);
  return unit.includes("^") ? raised(unitOfPower(unit, changes.valueOf(name.replace(/stiffness$/, "exponent"), values))) : unitText(unit);
}

/** Return the unit of a parameter for `typed`: that of a stiffness has the present exponent. */
function typedUnit(changes, name) {
  const { unit } = changes.parameters.get(name);
  return unit.includes("^") ? presentUnit(changes, name) : unit;
}

/** Return the factor and the unit with which a parameter is shown: an angle in degrees, any other value in its `presentUnit`. */
export function presentlyShown(changes, name, values) {
  const shown = shownIn(changes.parameters.get(name));
  return shown.factor === 1 ? { ...shown, text: presentUnit(changes, name, values) } : shown;
}

/** Return a value of a parameter as text, with the unit that the parameter has with the changes. */
export function writtenValue(changes, name, value) {
  const { items } = changes.parameters.get(name);
  const shown = presentlyShown(changes, name, changes.values);
  return items.length ? lawText(items[value - 1][0]) : textWithUnit(value, shown, shown.factor === 1 ? ALL_DIGITS : DEGREE_DIGITS);
}

/** Return the elements of a list of choices; contact laws have words, and stand in groups of similar laws, except a user's law. */
function choicesOf(items) {
  const groups = new Map();
  return items.flatMap(([id], k) => {
    const option = new Option(lawText(id), String(k + 1));
    const label = SHARED.laws[id]?.group;
    if (!label) return [option];
    const isFirst = !groups.has(label);
    if (isFirst) groups.set(label, make("optgroup", { label }));
    groups.get(label).append(option);
    return isFirst ? [groups.get(label)] : [];
  });
}

/**
 * Return {field, write, refresh} for a parameter. The `field` is an input for a number, or a list of choices. `write` shows a given value
 * in the field, and `refresh` shows the parameter's present value. The field shows all digits of a number only while it has the focus. A
 * refused text stays in the field until the reader presses Escape or changes something else; then the field shows the present value again.
 */
export function valueField(changes, parameter) {
  const { name, items, text, allowed, derived, unit } = parameter;
  const field = items.length
    ? make("select", {}, ...choicesOf(items))
    : make("input", { type: "text", autocomplete: "off", spellcheck: false });
  field.title = readable(inShownUnit(`${name}: ${text}; ${allowed}${derived?.text ?? ""}${items.length ? "" : EXAMPLES}`));
  field.setAttribute("aria-label", name);
  field.dataset.parameter = name;
  field.addEventListener("change", () => attempt(changes, field, () =>
    changes.set({ [name]: items.length ? field.value : typed(field.value, typedUnit(changes, name)) })));
  const isActive = () => document.activeElement === field;
  let written;
  const write = (value = written) => {
    written = value;
    field.value = items.length ? String(value) : (isActive() ? valueText : shortText)(value, unit);
  };
  const rewrite = () => field.checkValidity() && write();
  field.addEventListener("blur", rewrite);
  field.addEventListener("focus", () => {
    field.closest(".main-parameter, .parameter").scrollIntoView({ block: "nearest" }); // above the fade of the panel
    rewrite();
    if (!items.length) field.select(); // so that a typed value replaces the present one
  });
  if (!items.length) {
    field.addEventListener("mousedown", (event) => {
      if (isActive()) return;
      event.preventDefault(); // the browser would put the cursor at the pointer, which ends the selection
      field.focus();
    });
    field.addEventListener("dblclick", () => field.select()); // the browser would select a word, without a sign
  }
  field.addEventListener("keydown", ({ key }) => key === "Escape" && attempt(changes, field, () => write()));
  const refresh = () => {
    if (!isActive() || items.length || field.dataset.fails) release(field);
    if (field.checkValidity()) write(changes.valueOf(name));
  };
  return { field, write, refresh };
}

export function resetButton(changes, name, field) {
  const button = make("button", { type: "button", className: "reset", textContent: "↺", title: `As in the scene: ${name}` });
  button.setAttribute("aria-label", `Reset ${name}`);
  button.addEventListener("click", () => attempt(changes, field, () => changes.reset(name)));
  return button;
}
