// The dialog in which the reader chooses outputs for the charts over time.

import { byId, make } from "../base/dom.js";
import { readable, unitText } from "../base/format.js";
import { nearestText } from "../base/similar_names.js";
import { groupOf, MOST_CURVES, MOST_UNITS } from "../charts/curve_charts.js";
import { shownIn } from "../scene/angles.js";
import { outputWords, proposedOutputs } from "../scene/output_words.js";
import { inputText } from "../scene/words.js";

/** Return the names of the outputs (`columns`) that match a text, in which `*` stands for any text. */
function like(text, columns) {
  const parts = text.split("*").map((part) => part.replaceAll(/[.+?^${}()|[\]\\]/g, "\\$&"));
  const pattern = new RegExp(`^${parts.join(".*")}$`);
  return columns.map(({ name }) => name).filter((name) => pattern.test(name));
}

/** Return whether all outputs are forces at walls: such short pulses begin with the view of one impact. */
const arePulses = (names) => names.length > 0 && names.every((name) => /^contact.*force$/.test(name));

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
    this.dialog = byId("curves");
    [this.field, this.search, this.list] = ["curves-names", "curves-search", "curves-list"].map(byId);
    this.none = byId("curves-clear");
    this.none.addEventListener("click", () => {
      this.#choose("");
      this.search.focus();
    });
    [byId("curves-open"), byId("curves-more")].forEach((button) => button.addEventListener("click", () => this.open()));
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

  /** Open the dialog with the outputs that `search` finds. */
  open(search = "") {
    const { scene: { links }, valueOf } = this.changes;
    this.rows = this.#columns.map(({ name, unit, text = inputText(name, valueOf) }) => {
      const box = make("input", { type: "checkbox" });
      box.addEventListener("change", () =>
        this.#choose([...this.names.filter((other) => other !== name), ...(box.checked ? [name] : [])].join()));
      const words = outputWords(name, valueOf);
      box.setAttribute("aria-label", [words.heading, words.line, words.item, name].filter(Boolean).join(", "));
      const row = make("label", { className: "pick", title: `${name}: ${text}` }, box, make("span", { textContent: words.item }));
      return { name, text: [text, ...Object.values(words)].join(" "), unit: shownIn({ unit }).text, ...words, box, row };
    });
    this.sets = proposedOutputs(this.#columns, links, MOST_CURVES, valueOf).map(([textContent, names]) =>
      this.#toggle({ textContent, title: names.join(", ") }, () => names));
    this.groups = [...new Set(this.rows.map(({ heading }) => heading))].map((heading) =>
      this.#quantity(heading, this.rows.filter((row) => row.heading === heading)));
    byId("curves-proposals").replaceChildren(...this.sets.map(({ button }) => button));
    this.list.replaceChildren(...this.groups.map(({ part }) => part));
    this.search.value = search;
    this.#refresh();
    this.#filter();
    this.dialog.showModal();
  }

  /** Return a button that chooses all outputs `names` or, if all are chosen, none of them, with a function that shows this state. */
  #toggle(properties, namesOf) {
    const button = make("button", { type: "button", ...properties });
    const areChosen = () => namesOf().every((name) => this.names.includes(name));
    button.addEventListener("click", () => {
      const others = this.names.filter((name) => !namesOf().includes(name));
      this.#choose([...others, ...(areChosen() ? [] : namesOf())].join());
    });
    return { button, showState: () => button.setAttribute("aria-pressed", areChosen()) };
  }

  /**
   * Return the element for a quantity, with its lines and members: a heading and, for each axis or wall, a line of outputs; a line of
   * several outputs has a button that chooses all that are shown.
   */
  #quantity(heading, members) {
    const units = [...new Set(members.map(({ unit }) => unit))];
    const lines = [...new Set(members.map(({ line }) => line))].map((line) => {
      const own = members.filter((member) => member.line === line);
      const words = line ? [make("span", { className: "line-name", textContent: line })] : [];
      const part = make("div", { className: "curve-members" }, ...words, ...own.map(({ row }) => row));
      if (own.length === 1) return { part, members: own };
      const shown = () => own.filter(({ row }) => !row.hidden).map(({ name }) => name);
      const { button, showState } = this.#toggle({ textContent: "All" }, shown);
      button.setAttribute("aria-label", `All of ${groupOf(own[0].name)}`);
      part.append(button);
      return { part, members: own, showState };
    });
    const unit = make("small", { textContent: units.length === 1 ? units[0] : "" });
    const patterns = [...new Set(members.map(({ name }) => groupOf(name)))];
    const pattern = make("small", { className: "pattern", textContent: patterns.join(", ") });
    const title = make("h3", {}, heading, " ", unit, " ", pattern);
    return { part: make("div", { className: "curve-group" }, title, ...lines.map(({ part }) => part)), lines, members };
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
    const charts = byId("outputs-over-time").closest("section");
    if (!this.isNew || this.dialog.open || charts.hidden) return;
    this.isNew = false;
    charts.scrollIntoView({ block: "nearest" });
  }

  /**
   * Choose the outputs that a text names, and tell the fault of other names; an empty text chooses none. A text with only names that no
   * output has, or with too many outputs, leaves the choice as it is.
   */
  #choose(text) {
    try {
      const { names, fault } = namesIn(text, this.#columns);
      if (fault && !names.length) throw new RangeError(fault);
      if (arePulses(names) !== arePulses(this.names)) byId("zoom-impact").ariaPressed = arePulses(names);
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
    this.#showStates();
    this.none.hidden = !this.names.length;
    this.#tell(fault);
  }

  /** Tell a fault of the text in the field; while the reader types, the text may be incomplete. */
  #tell(fault, isTyping = false) {
    Object.assign(byId("curves-text"), { textContent: readable(fault), className: isTyping ? "typing" : "" });
  }

  #showStates() {
    [...this.sets, ...this.groups.flatMap(({ lines }) => lines)].forEach(({ showState }) => showState?.());
  }

  #filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    this.rows.forEach(({ name, text, row }) => {
      row.hidden = !words.every((word) => `${name} ${text}`.toLowerCase().includes(word));
    });
    const isEmpty = (members) => members.every(({ row }) => row.hidden);
    this.groups.forEach(({ part, lines, members }) => {
      part.hidden = isEmpty(members);
      lines.forEach((line) => {
        line.part.hidden = isEmpty(line.members);
      });
    });
    this.#showStates();
    byId("curves-none").hidden = this.rows.some(({ row }) => !row.hidden);
  }
}
