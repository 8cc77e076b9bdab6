// The page as one file with its present state: the address, which has changes, pins and time, and the fields of the map.

import { find, make } from "../base/dom.js";
import { save } from "./export.js";

const ID = "saved"; // the element of a saved page that has its state
const SOURCE = document.documentElement.cloneNode(true); // the page before its program changes it
SOURCE.querySelectorAll(":scope > iframe").forEach((frame) => frame.remove()); // of begin.js

/** Return the state with which the page was saved: `hash`, the end of its address, and `map`, the result of `mapFields`. */
export function savedState() {
  return JSON.parse(find(ID)?.textContent ?? "{}");
}

/** Save the page as one file with a `name`; `hash`: the end of its present address, from the "#" on. */
export function savePage(hash, name) {
  const textContent = JSON.stringify({ hash, map: mapFields() }).replaceAll("<", "\\u003c");
  SOURCE.querySelector(`#${ID}`)?.remove();
  SOURCE.querySelector("body").append(make("script", { id: ID, type: "application/json", textContent }));
  save(new Blob([`<!doctype html>\n${SOURCE.outerHTML}`], { type: "text/html" }), name);
}

const partOf = ({ type }) => (type === "checkbox" ? "checked" : "value");

/** Return the fields of the map, pairs [id, value], and whether it has all its runs; undefined before the reader has opened the map. */
function mapFields() {
  if (!find("map-x-name").options.length) return undefined;
  const fields = [...find("map").querySelectorAll(":is(select, input)[id]")].map((field) => [field.id, field[partOf(field)]]);
  return { fields, isComplete: !find("map-files").hidden };
}

/** Fill the fields of the map as they were when the page was saved, and simulate its runs again. */
export function fillMap() {
  const { map } = savedState();
  if (!map) return;
  const write = () => map.fields.forEach(([id, value]) => find(id) && Object.assign(find(id), { [partOf(find(id))]: value }));
  write();
  ["map-x-name", "map-y-name"].forEach((id) => find(id).dispatchEvent(new Event("change"))); // which chooses other ranges
  write();
  if (map.isComplete) find("map-run").click();
  else find("map-x-from").dispatchEvent(new Event("change"));
}
