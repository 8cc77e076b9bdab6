// The dialog in which the reader chooses outputs for the charts over time.

import { find, make } from "../base/dom.js";
import { breakable, readable, unitText } from "../base/format.js";
import { nearestText } from "../base/similar_names.js";
import { groupOf, MOST_CURVES, MOST_UNITS } from "../charts/curve_charts.js";
import { shownIn } from "../scene/angles.js";
import { inputText } from "../scene/words.js";

/** Return the names of the outputs (`columns`) that match a text, in which `*` stands for any text. */
function like(text, columns) {
  const parts = text.split("*").map((part) => part.replaceAll(/[.+?^${}()|[\]\\]/g, "\\$&"));
  const pattern = new RegExp(`^${parts.join(".*")}$`);
  return columns.map(({ name }) => name).filter((name) => pattern.test(name));
}

/** Return words for a fault: a name, or a pattern with `*`, that no output has; the words propose the most similar one, if there is any. */
function noOutput(part, columns) {
  const names = columns.map(({ name }) => name);
  if (!part.includes("*")) return `${part} is not an output${nearestText(part, names)}`;
  const patterns = names.filter((name) => name.includes("[")).map((name) => name.replaceAll(/\[\d+\]/g, "[*]"));
  return `no output is like ${part}${nearestText(part, [...new Set(patterns)])}`;
}

/**
 * Return { names, fault } for a text: the names of the outputs that it names between commas, in which `*` stands for any text, as for
 * `simulate --curves`; and words for the names that no output has, "" without one. Refuse more than MOST_CURVES outputs with the same unit,
 * and more than MOST_UNITS units.
 */
function namesIn(text, columns) {
  const parts = text.split(",").map((part) => part.trim()).filter(Boolean);
  const names = [...new Set(parts.flatMap((part) => like(part, columns)))];
  const fault = parts.filter((part) => !like(part, columns).length).map((part) => noOutput(part, columns)).join(". ");
  const units = columns.filter(({ name }) => names.includes(name)).map(({ unit }) => unit);
  const kinds = [...new Set(units)];
  kinds.forEach((unit) => {
    const count = units.filter((other) => other === unit).length;
    if (count > MOST_CURVES) throw new RangeError(`${count} outputs in ${unitText(unit) || "no unit"}; must be at most ${MOST_CURVES}`);
  });
  if (kinds.length > MOST_UNITS) throw new RangeError(`outputs in ${kinds.length} units; must be at most ${MOST_UNITS}`);
  return { names, fault };
}

/** Return a sentence on the names of a text that no output has, or on too many outputs; "" without a fault. */
function faultIn(text, columns) {
  try {
    const { fault } = namesIn(text, columns);
    return fault && `${fault}.`;
  } catch ({ message }) {
    return `${message}.`;
  }
}

export class CurveChoice {
  names = [];

  isNew = false; // whether the reader has chosen outputs whose charts have not been scrolled into view yet

  #listener = () => {};

  constructor(changes) {
    this.changes = changes;
    this.dialog = find("curves");
    [this.field, this.search, this.list] = ["curves-names", "curves-search", "curves-list"].map(find);
    [find("curves-open"), find("curves-more")].forEach((button) => button.addEventListener("click", () => this.open()));
    this.field.addEventListener("change", () => this.#choose(this.field.value));
    this.field.addEventListener("input", () => this.#tell(faultIn(this.field.value, this.#columns), true));
    this.field.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault(); // without this call the key would close the dialog
      this.#choose(this.field.value);
    });
    this.search.addEventListener("input", () => this.#filter());
    this.search.addEventListener("keydown", (event) => event.key === "Enter" && event.preventDefault());
    this.dialog.addEventListener("close", () => this.bringIntoView());
    changes.onOpen(() => {
      this.names = this.names.filter((name) => this.#columns.some((column) => column.name === name));
    });
  }

  /** Set the function that is called when the reader chooses other outputs. */
  onChange(listener) {
    this.#listener = listener;
  }

  get #columns() {
    return this.changes.scene.columns;
  }

  open() {
    this.rows = this.#columns.map(({ name, unit, text = inputText(name, this.changes.valueOf) }) => {
      const box = make("input", { type: "checkbox" });
      box.setAttribute("aria-label", name);
      box.addEventListener("change", () =>
        this.#choose([...this.names.filter((other) => other !== name), ...(box.checked ? [name] : [])].join()));
      const words = [make("span", { textContent: breakable(name) }), make("small", { textContent: shownIn({ unit }).text })];
      return { name, text, box, row: make("label", { title: text }, box, ...words) };
    });
    const groups = [...new Set(this.rows.map(({ name }) => groupOf(name)))];
    this.groups = groups.map((group) => this.#group(group, this.rows.filter(({ name }) => groupOf(name) === group)));
    this.list.replaceChildren(...this.groups.map(({ part }) => part));
    this.#refresh();
    this.#filter();
    this.dialog.showModal();
  }

  /**
   * Return the element for a group of outputs: a list that opens, and a button that chooses all members of the group that are listed now
   * or, if all these members are chosen, none of them. A group of one output is its row alone.
   */
  #group(group, members) {
    const rows = make("div", { className: "curve-members" }, ...members.map(({ row }) => row));
    if (members.length === 1) return { part: rows, members };
    const texts = [...new Set(members.map(({ text }) => text))];
    const meaning = texts.length === 1 ? make("small", { textContent: texts[0].replace(/[,:;].*/, "") }) : "";
    const list = make("details", {}, make("summary", { title: texts.join("; ") }, `${breakable(group)} `, meaning), rows);
    const all = make("button", { type: "button", textContent: "All" });
    const shown = () => members.filter(({ row }) => !row.hidden).map(({ name }) => name);
    const areChosen = () => shown().every((name) => this.names.includes(name));
    all.setAttribute("aria-label", `All of ${group}`);
    all.addEventListener("click", () => {
      const others = this.names.filter((name) => !shown().includes(name));
      list.open = true;
      this.#choose([...others, ...(areChosen() ? [] : shown())].join());
    });
    const showState = () => all.setAttribute("aria-pressed", areChosen());
    return { part: make("div", { className: "curve-group" }, list, all), list, members, showState };
  }

  /** Choose the outputs that a text names, without calling the listener; an error tells which choice is not possible. */
  take(text) {
    const { names, fault } = namesIn(text, this.#columns);
    if (fault) throw new RangeError(fault);
    this.names = names;
  }

  /**
   * Scroll to the charts over time if newly chosen outputs have not been scrolled to yet.
   *
   * While the dialog is open or the charts are hidden, do nothing.
   */
  bringIntoView() {
    const charts = find("outputs-over-time").closest("section");
    if (!this.isNew || this.dialog.open || charts.hidden) return;
    this.isNew = false;
    charts.scrollIntoView({ block: "nearest" });
  }

  /** Choose the outputs that a text names, and tell the fault of other names; without any output, the choice stays. */
  #choose(text) {
    try {
      const { names, fault } = namesIn(text, this.#columns);
      if (fault && !names.length) throw new RangeError(fault);
      this.names = names;
      this.isNew = names.length > 0;
      this.#listener();
      this.#refresh(fault && `${fault}.`);
    } catch (error) {
      this.#refresh(`${error.message}.`);
    }
  }

  /** Show the chosen outputs: in the boxes of all outputs and, without a fault, in the field; show the words for a fault. */
  #refresh(fault = "") {
    if (!fault) this.field.value = this.names.join(", ");
    this.rows.forEach(({ name, box }) => {
      box.checked = this.names.includes(name);
    });
    this.groups.forEach(({ showState }) => showState?.());
    this.#tell(fault);
  }

  /** Tell a fault of the text in the field; while the reader types, the text may be incomplete. */
  #tell(fault, isTyping = false) {
    Object.assign(find("curves-text"), { textContent: readable(fault), className: isTyping ? "typing" : "" });
  }

  #filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    this.rows.forEach(({ name, text, row }) => {
      row.hidden = !words.every((word) => `${name} ${text}`.toLowerCase().includes(word));
    });
    this.groups.forEach(({ part, list, members, showState }) => {
      part.hidden = members.every(({ row }) => row.hidden);
      if (list) list.open = words.length > 0 || members.some(({ box }) => box.checked);
      showState?.();
    });
    find("curves-none").hidden = this.rows.some(({ row }) => !row.hidden);
  }
}
