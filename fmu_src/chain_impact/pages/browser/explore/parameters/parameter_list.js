// The list of all parameters, which the reader can search.

import { make } from "../../base/dom.js";
import { breakable, readable } from "../../base/format.js";
import { nearestText } from "../../base/similar_names.js";
import { explain, presentUnit, refusal, resetButton, valueField } from "./parameter_fields.js";

/**
 * Fill the list of all parameters, the element `details`, when the reader first opens it for a scene. Its field `search` keeps only the
 * parameters for which each word in the field is in the name or in the meaning. Its title tells the number of changed parameters, which
 * come first.
 */
export function showParameterList(details, changes) {
  const [search, body] = [details.querySelector("input[type=search]"), details.querySelector(".parameters")];
  const count = details.querySelector("summary span");
  let [rows, first] = []; // first: the names of the changed parameters, as the list is sorted
  const refreshRows = () => {
    rows.forEach((row) => row.refresh());
    const changed = changes.scene.parameters.map(({ name }) => name).filter((name) => changes.isChanged(name)).join();
    if (changed === first || body.contains(document.activeElement)) return; // a row with the focus stays in its place
    body.append(...rows.toSorted((a, b) => changes.isChanged(b.name) - changes.isChanged(a.name)).map(({ row }) => row));
    first = changed;
  };
  const refresh = () => {
    count.textContent = changes.count ? ` · ${changes.count} changed` : "";
    if (details.open) fill();
  };
  const filter = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    rows.forEach(({ row, text }) => {
      row.hidden = !words.every((word) => text.includes(word));
    });
    const nothing = details.querySelector(".nothing");
    nothing.hidden = rows.some(({ row }) => !row.hidden);
    const near = nothing.hidden ? "" : nearestText(search.value.trim(), rows.map(({ name }) => name));
    nothing.textContent = `No parameter has such a name${near}.`;
  };
  const fill = () => {
    if (rows) return refreshRows();
    rows = changes.scene.parameters.map((parameter) => listRow(changes, parameter));
    body.replaceChildren();
    first = undefined;
    refreshRows();
    filter();
  };
  details.firstElementChild.addEventListener("click", fill); // before the list opens: the event "toggle" comes later
  details.addEventListener("toggle", () => {
    refresh();
    if (details.open) details.firstElementChild.scrollIntoView(); // the list opens below the visible part of the page
  });
  search.addEventListener("input", filter);
  changes.onOpen(() => {
    rows = undefined;
    if (details.open) fill();
  });
  changes.onChange(refresh);
}

function listRow(changes, parameter) {
  const { name, text, allowed } = parameter;
  const { field, refresh } = valueField(changes, parameter);
  const words = make("span", { className: "parameter-name", title: readable(`${text}; ${allowed}`) }, breakable(name));
  const unitElement = make("small");
  const row = make("div", { className: "parameter" }, words, resetButton(changes, name, field), field, unitElement, refusal());
  return {
    name,
    row,
    text: `${name} ${text}`.toLowerCase(),
    refresh: () => {
      refresh();
      // a text such as "90 deg" contains its unit, so no unit is shown beside it
      unitElement.textContent = /deg/.test(field.value) ? "" : breakable(presentUnit(changes, name));
      explain(row);
      row.classList.toggle("changed", changes.isChanged(name));
    },
  };
}
