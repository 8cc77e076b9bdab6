// The page as one file with its present state: the address, which has changes, pins and time, and the fields of the map.

import { byId, make } from "../base/dom.js";
import { save } from "./export.js";

const ID = "saved"; // the element of a saved page that has its state
const SOURCE = document.documentElement.cloneNode(true); // the page before its program changes it
SOURCE.querySelectorAll(":scope > iframe").forEach((frame) => frame.remove()); // of begin.js

/** Return the state with which the page was saved: `hash`, the end of its address, and `map`, the result of `stateOf`. */
export function savedState() {
  return JSON.parse(byId(ID)?.textContent ?? "{}");
}

/** Save the page as one file with a `name`; `hash`: the end of its present address, from the "#" on; `map`: the map, once it is made. */
export function savePage(hash, name, map) {
  const textContent = JSON.stringify({ hash, map: map ? stateOf(map) : savedState().map }).replaceAll("<", "\\u003c");
  SOURCE.querySelector(`#${ID}`)?.remove();
  SOURCE.querySelector("body").append(make("script", { id: ID, type: "application/json", textContent }));
  save(new Blob([`<!doctype html>\n${SOURCE.outerHTML}`], { type: "text/html" }), name);
}

const partOf = ({ type }) => (type === "checkbox" ? "checked" : "value");

/** Return the file of the map's scene, the fields of the map, pairs [id, value], and the runs of a map that is no preview. */
function stateOf(map) {
  const fields = [...byId("map").querySelectorAll(":is(select, input)[id]")].map((field) => [field.id, field[partOf(field)]]);
  return { file: map.changes.scene.file, fields, shown: map.saved };
}

/** Fill the fields of the map as they were when the page was saved, and show the saved runs or, without them, a preview. */
export function fillMap(map) {
  const saved = savedState().map;
  if (!saved || JSON.stringify(saved.file) !== JSON.stringify(map.changes.scene.file)) return; // the reader has opened another scene
  const write = () => saved.fields.forEach(([id, value]) => byId(id) && Object.assign(byId(id), { [partOf(byId(id))]: value }));
  write();
  if (saved.shown) return map.restore(saved.shown);
  ["map-x-name", "map-y-name"].forEach((id) => byId(id).dispatchEvent(new Event("change"))); // which chooses other ranges
  write();
}
