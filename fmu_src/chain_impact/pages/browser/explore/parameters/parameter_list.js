// The list of all parameters, which the reader can search.

import { byId, make } from "../../base/dom.js";
import { breakable, readable } from "../../base/format.js";
import { proposed } from "../../base/similar_names.js";
import { capitalized } from "../../scene/words.js";
import { wordsFor } from "./main_parameters.js";
import { explain, presentlyShown, refusal, resetButton, turnsText, valueField, writtenValue } from "./parameter_fields.js";

const CHANGED = "Changed"; // the title of the group of changed parameters, which comes first
// first part of a name → title of the group of such parameters, if it is not this part with a capital letter
const GROUP_TITLES = { initial: "Start", stop: "Stops", tip: "Inputs", base: "Inputs", joint: "Inputs" };

/** Return the names of all keys that a scene file may have, such as contact.friction; `keys`: their data in `scene_tables.py`. */
function keyNames(keys, owner = "") {
  return Object.entries(keys).flatMap(([key, entry]) => {
    const inner = entry.keys ?? entry.each?.keys;
    return inner ? keyNames(inner, `${owner}${key}.`) : [owner + key];
  });
}

/** Return a sentence that names the (at most three) shortest of the keys in which each of the words is found; "" for no key. */
function lacking(keys, words) {
  const found = keyNames(keys).filter((name) => words.every((word) => name.replaceAll("_", " ").includes(word)));
  const [first, ...others] = found.sort((a, b) => a.length - b.length);
  return first ? `The scene has no such parameter; a scene file may have ${[first, ...others.slice(0, 2)].join(", ")}.` : "";
}

const MOST_TOLD = 4; // most changed parameters without a slider that are told above a list that is closed
const FREE_HEIGHT = 220; // [pixels] least free height of the column of parameters with which the list is open from the start

/**
 * Fill the list of all parameters, the element `details`, when it first opens for a scene: when the reader opens it or, beside the motion,
 * at the start, if there is room (FREE_HEIGHT). The parameters are in groups with
 * titles. The field `search` keeps only the parameters for which each word in the field is in the name, in the words for the parameter or
 * in the meaning; if none is left, a sentence names `keys` of scene files with these words, or the most similar parameter. The title of the
 * list tells the number of changed parameters.
 */
export function showParameterList(details, changes, keys) {
  const [search, body] = [details.querySelector("input[type=search]"), details.querySelector(".parameters")];
  const count = details.querySelector("summary span");
  let [rows, first] = []; // first: the names of the changed parameters, as the list is sorted
  const refreshRows = () => {
    const wordsOf = wordsFor(changes);
    rows.forEach((row) => row.refresh(wordsOf(row.name)));
    const changed = changes.scene.parameters.map(({ name }) => name).filter((name) => changes.isChanged(name)).join();
    if (changed === first || body.contains(document.activeElement)) return; // a row with the focus stays in its place
    const groupOf = ({ name }) => (changes.isChanged(name) ? CHANGED : groupTitle(name));
    const titles = [...new Set([CHANGED, ...rows.map(groupOf)])];
    body.replaceChildren(...titles.map((title) =>
      make("div", {}, make("h2", { textContent: title }), ...rows.filter((row) => groupOf(row) === title).map(({ row }) => row))));
    filter();
    first = changed;
  };
  const refresh = () => {
    count.textContent = changes.count ? ` · ${changes.count} changed` : "";
    if (details.open) fill();
    const hidden = Object.keys(changes.values).filter((name) => !byId(`main-${name}`));
    const wordsOf = wordsFor(changes);
    const told = hidden.slice(0, MOST_TOLD).map((name) => `${wordsOf(name)} = ${writtenValue(changes, name, changes.valueOf(name))}`);
    const more = hidden.length > MOST_TOLD ? ", …" : "";
    Object.assign(byId("also-changed"), { hidden: !told.length || details.open, textContent: `Also changed: ${told.join(", ")}${more}` });
  };
  const filter = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    rows.forEach(({ row, texts }) => {
      row.hidden = !words.every((word) => texts.some((text) => text.toLowerCase().includes(word)));
    });
    [...body.children].forEach((group) => {
      group.hidden = !group.querySelector(".parameter:not([hidden])");
    });
    const nothing = details.querySelector(".nothing");
    nothing.hidden = rows.some(({ row }) => !row.hidden);
    if (nothing.hidden) return;
    const near = proposed(search.value.trim(), rows.flatMap(({ texts: [name, shown] }) => [name, shown]));
    const button = make("button", { type: "button", className: "proposed", textContent: near });
    button.addEventListener("click", () => {
      search.value = near;
      filter();
    });
    const sentence = ["No parameter has such a name", ...(near ? ["; the nearest is ", button] : []), "."];
    nothing.replaceChildren(...[lacking(keys, words) || sentence].flat());
  };
  const fill = () => {
    if (rows) return refreshRows();
    rows = changes.scene.parameters.map((parameter) => listRow(changes, parameter));
    first = undefined;
    body.replaceChildren(); // rows of another scene go, also if one has the focus
    refreshRows();
  };
  let isByReader = true; // whether the reader opens the list
  details.firstElementChild.addEventListener("click", fill); // before the list opens: the event "toggle" comes later
  details.addEventListener("toggle", () => {
    refresh();
    if (details.open && isByReader) details.firstElementChild.scrollIntoView(); // the list opens below the visible part of the page
    isByReader = true;
  });
  requestAnimationFrame(() => {
    const free = details.parentElement.getBoundingClientRect().bottom - details.getBoundingClientRect().bottom;
    if (free < FREE_HEIGHT || details.open || !matchMedia("(min-width: 961px)").matches) return;
    isByReader = false;
    details.open = true;
  });
  const showResults = () => details.firstElementChild.scrollIntoView(); // the results have the height of the panel
  search.addEventListener("focus", showResults);
  search.addEventListener("input", () => {
    filter();
    showResults();
  });
  changes.onOpen(() => {
    rows = undefined;
    if (details.open) fill();
  });
  changes.onChange(refresh);
}

/** Return the title of the group of a parameter: "Link 1" for link[1].mass, "Wall ramp", "Signal push", "Contact", "Inputs". */
function groupTitle(name) {
  const [head, second] = name.split(".");
  const [, kind, number] = /^(\w+)(?:\[(\d+)\])?/.exec(head);
  return GROUP_TITLES[kind] ?? capitalized([kind, number ?? (["wall", "signal"].includes(kind) && second)].filter(Boolean).join(" "));
}

/**
 * Return the row of a parameter, its `name`, and `texts` in which the reader can search: the name, the words for the parameter and its
 * meaning. `refresh` shows the present value and the given words, for an unchanged parameter without the title of its group at their end.
 */
function listRow(changes, parameter) {
  const { name, text, allowed } = parameter;
  const { field, refresh } = valueField(changes, parameter);
  const [words, key] = [make("span"), make("span", { className: "key", textContent: breakable(name) })];
  const label = make("span", { className: "parameter-name", title: readable(`${text}; ${allowed}`) }, words, " ", key);
  const ofGroup = new RegExp(` of (the )?${groupTitle(name).replace(/s$/, "s?")}$`, "i");
  const texts = [name, "", text];
  const [unitElement, turns] = [make("small"), make("p", { className: "no-effect" })];
  const row = make("div", { className: "parameter" }, label, resetButton(changes, name, field), field, unitElement, turns, refusal());
  return {
    name,
    row,
    texts,
    refresh: (shown) => {
      refresh();
      texts[1] = shown;
      words.textContent = changes.isChanged(name) ? shown : shown.replace(ofGroup, "");
      field.setAttribute("aria-label", `${shown}, ${name}`);
      unitElement.textContent = breakable(presentlyShown(changes, name).text);
      turns.textContent = turnsText(changes, name);
      explain(row);
      row.classList.toggle("changed", changes.isChanged(name));
    },
  };
}
