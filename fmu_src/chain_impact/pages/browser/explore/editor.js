// The dialog in which the reader adds and removes links, points, walls and stops, and opens scene files.

import { byId, make } from "../base/dom.js";
import { numberText, readable, unitText } from "../base/format.js";
import { inShownUnit, shownIn, typed, valueText } from "../scene/angles.js";
import { connectTabs } from "../base/tabs.js";
import { contentsOf } from "../scene/changed_file.js";
import {
  addLink, addPoint, addWall, moveToLink, ownPoint, removeLink, removePoint, removeWall, setBase, setBox, setOfLink, setOrRemove,
} from "../scene/edits.js";
import { STOPS } from "../scene/geometry.js";
import { boxWallText, capitalized } from "../scene/words.js";
import { contentsIn, sitesOf } from "../scene/scene_file.js";
import { fieldAfter, partsOf } from "./edited_scene.js";
import { fileFault } from "./file_fault.js";
import { SceneText } from "./scene_text.js";

export class Editor {
  #edits = new Map(); // name of a field or button → the function that applies its edit to a scene file
  #refused = new Map(); // name of a field → its refused `text`, which stays until it is mended or given up, and `told`, why it is refused
  #taken = {}; // `name` of the field whose text was taken last, and `scene` with it
  #failing = ""; // name of the field with whose text the runs began to fail; "" while they have a motion

  /** Connect the dialog with its buttons and with dropped files; `keys`: the rules of the keys of scene files, with units and labels. */
  constructor(changes, openScene, keys) {
    const { links: { keys: link }, slider: { keys: slider } } = keys.chain.keys;
    const tables = { link, slider, point: link.points.keys, box: keys.box.keys, wall: keys.walls.keys };
    Object.assign(this, { changes, openScene, keys, tables });
    this.dialog = byId("edit");
    this.text = new SceneText(changes, openScene, keys);
    connectTabs(byId("edit-tabs"), () => this.#draw());
    byId("edit-open").addEventListener("click", () => {
      this.#draw();
      this.#say("");
      this.#show();
    });
    this.dialog.addEventListener("close", () => document.querySelector("main").after(byId("status")));
    Object.entries({ link: addLink, point: addPoint, wall: addWall }).forEach(([part, add]) =>
      byId(`add-${part}`).addEventListener("click", () => this.#add(add, byId(`edit-${part}s`))));
    byId("edit-base").addEventListener("change", ({ target }) => this.#change((file) => setBase(file, target.value)));
    byId("edit-choose").addEventListener("click", () => byId("edit-file").click());
    byId("edit-file").addEventListener("change", ({ target }) => {
      this.#read(target.files[0]);
      target.value = ""; // the field is emptied, so that choosing the same file again is a change, too
    });
    byId("edit-first").addEventListener("click", () => {
      openScene.openFirst();
      this.#refused.clear();
      this.#draw();
    });
    const onFiles = (kind, take) => document.addEventListener(kind, (event) => {
      // a dropped text is left to the browser, which puts it into a field
      if (!event.dataTransfer.types.includes("Files")) return;
      event.preventDefault();
      take([...event.dataTransfer.files]);
    });
    onFiles("dragover", () => {});
    onFiles("drop", ([file]) => file && this.#read(file, () => this.dialog.open || this.#show()));
  }

  /** Open the dialog, which has the line on the last run while it covers the page. */
  #show() {
    byId("edit-text").after(byId("status"));
    this.dialog.showModal();
  }

  /** Show the present scene in the open dialog, without refused texts, after the scene has changed elsewhere. */
  refresh() {
    this.#refused.clear();
    if (this.dialog.open) this.#draw();
    this.#say("");
  }

  /** Open a scene file that the reader has chosen or dropped; if it cannot be opened, call `onFault` and show the reason. */
  async #read(file, onFault = () => {}) {
    const text = await file.text().catch((error) => error);
    this.#try(() => {
      if (text instanceof Error) throw text; // reading fails for a folder, and for a file that no longer exists
      this.openScene.open(contentsIn(text));
      this.#refused.clear();
    }, `${file.name} is open.`, (error) => {
      onFault();
      return `${file.name} cannot be opened: ${fileFault(error, String(text))}`;
    });
  }

  /** Make an edit as `#apply` does, and show the edited scene; if the edit is refused, call `onFault` with the reason. */
  #change(edit, onFault = () => {}) {
    this.#try(() => {
      const removed = this.#apply(edit);
      this.#tryAgain();
      return removed.length ? `The edit also removes: ${removed.join(", ")}.` : "";
    }, "", (error) => {
      onFault(error);
      return this.#refusalText(error);
    });
  }

  /** Add a part to the scene as `#change` does; unless the part is refused, focus the first field of its row, the last row of `table`. */
  #add(edit, table) {
    let isAdded = true;
    this.#change(edit, () => {
      isAdded = false;
    });
    if (isAdded) [...table.querySelectorAll("tbody tr:not(.told)")].at(-1).querySelector("input").focus();
  }

  /** Apply the function `edit` to the contents of the scene that the page shows; return a list of words for what the edit also removes. */
  #apply(edit) {
    const file = contentsOf(this.changes);
    const before = partsOf(file);
    edit(file);
    const removed = this.openScene.openEdited(file, before);
    this.#refused = new Map([...this.#refused].map(([name, entry]) => [fieldAfter(name, before, partsOf(file)), entry]));
    return removed;
  }

  /** Apply the text of a field to the scene; a refused text stays in the field, and the reason stands below its row. */
  #take(name, text) {
    this.#refused.delete(name);
    this.#change(this.#editOf(name, text), (error) => this.#refused.set(name, { text, told: this.#refusalText(error) }));
    if (!this.#refused.has(name)) {
      this.#taken = { name, scene: this.changes.scene };
      return;
    }
    this.#say("");
    this.dialog.querySelector("tr:has(input:invalid) + .told")?.scrollIntoView({ block: "nearest" });
  }

  /** Mark the field whose text the solver refuses, until a run has a motion (`hasMotion`). */
  tellRun(hasMotion) {
    const { name, scene } = this.#taken;
    const failing = hasMotion ? "" : this.#failing || (scene === this.changes.scene ? name : "");
    if (failing === this.#failing) return;
    this.#failing = failing;
    this.#mark();
    this.dialog.querySelector("tr:has([aria-invalid=true])")?.scrollIntoView({ block: "center" });
  }

  #mark() {
    this.dialog.querySelectorAll("td input").forEach((field) =>
      field.setAttribute("aria-invalid", !field.validity.valid || field.getAttribute("aria-label") === this.#failing));
  }

  /** Apply the refused texts again, because another edit may allow them or change why they are refused. */
  #tryAgain() {
    this.#draw(); // for the fields of the edited scene
    [...this.#refused].forEach(([name, { text }]) => {
      this.#refused.delete(name);
      try {
        this.#apply(this.#editOf(name, text));
      } catch (error) {
        this.#refused.set(name, { text, told: this.#refusalText(error) });
      }
    });
  }

  /** Return the function that puts the text of a field into a scene file. */
  #editOf(name, text) {
    return (file) => this.#edits.get(name)(file, text);
  }

  /** Return why the editor refuses something, with words in place of paths of the file: "Length of link 1" for chain.links[1].length. */
  #refusalText({ message }) {
    const { tables, changes: { valueOf } } = this;
    const label = (table, key) => tables[table][key]?.label ?? capitalized(key.replaceAll("_", " "));
    const named = message
      .replace(/\bchain\.links\[(\d+)\]\.points\[(\d+)\]\.(\w+)/g, (_, link, point, key) =>
        `${label("point", key)} of point ${point} of link ${link}`)
      .replace(/\bchain\.links\[(\d+)\]\.(\w+)/g, (_, link, key) => `${label("link", key)} of link ${link}`)
      .replace(/\bchain\.slider\.(\w+)/g, (_, key) => `${label("slider", key)} of the slider`)
      .replace(/\bbox\.([xy]_(?:min|max))\b/g, (_, wall) => `Position of the ${boxWallText(wall, valueOf)}`);
    return readable(inShownUnit(`Not taken: ${named}.`));
  }

  /** Give up the refused text of a field: the field shows the value of the scene again. */
  #giveUp(name) {
    this.#refused.delete(name);
    this.#draw();
    this.#say("");
  }

  #try(action, done, refused) {
    let [text, isFault] = [done, false];
    try {
      text = action() ?? done;
    } catch (error) {
      [text, isFault] = [refused(error), true];
    }
    this.#draw();
    this.#say(text, isFault);
  }

  #say(text, isFault = false) {
    Object.assign(byId("edit-text"), { textContent: readable(text), className: isFault ? "fault" : "" });
  }

  #draw() {
    const { scene: { file } } = this.changes;
    this.text.show();
    this.#edits.clear();
    byId("edit-base").value = file.chain.base;
    const heads = ["Link", ...this.#heads("link", this.#keysOfLinks(file)), ""];
    this.#fill(byId("edit-links"), heads, file.chain.links.map((link, k) => this.#linkRow(file, link, k)));
    const points = sitesOf(file).map((site, s) => [site, s]).filter(([{ corner }]) => !corner);
    const ofPoints = ["Point", "Link", ...this.#heads("point"), ""];
    this.#fill(byId("edit-points"), ofPoints, points.map(([site, s]) => this.#pointRow(file, site, s)));
    byId("edit-points").hidden = points.length === 0;
    const { slider } = file.chain;
    byId("edit-slider").hidden = !slider;
    if (slider) {
      const cellOf = (key) =>
        this.#field(`slider.${key}`, slider[key], (value, all) => setOrRemove(all.chain.slider, key, value), this.tables.slider[key].unit);
      this.#fill(byId("edit-slider"), this.#heads("slider"), [this.#keysIn("slider").map(cellOf)]);
    }
    this.#fill(byId("edit-box"), this.#heads("box"), [this.#keysIn("box").map((key) =>
      this.#field(`box.${key}`, file.box[key], (value, all) => setBox(all, key, value), this.tables.box[key].unit))]);
    const atPoint = ["x", "y"].map((axis) => `${axis}, ${unitText(this.tables.wall.point.each.unit)}`);
    const ofWalls = ["Wall", ...atPoint, ...this.#heads("wall"), ""];
    this.#fill(byId("edit-walls"), ofWalls, file.walls.map((wall, k) => this.#wallRow(wall, k)));
    byId("edit-walls").hidden = byId("edit-walls-title").hidden = file.walls.length === 0;
    [...this.#refused.keys()].filter((name) => !this.#edits.has(name)).forEach((name) => this.#refused.delete(name));
    this.#mark();
  }

  /** Return the keys with a label in a table of scene files: the keys that the editor shows. */
  #keysIn(table) {
    return Object.keys(this.tables[table]).filter((key) => this.tables[table][key].label);
  }

  /** Return the keys of links that the editor shows; a free chain of one link has no joint, so the keys of stops are left out for it. */
  #keysOfLinks({ chain: { base, links } }) {
    const hasJoints = base !== "free" || links.length > 1;
    return this.#keysIn("link").filter((key) => hasJoints || !STOPS.includes(key));
  }

  /** Return the heads of the columns for some keys (`shown`) of a table: their labels, with units. */
  #heads(table, shown = this.#keysIn(table)) {
    return shown.map((key) => {
      const { label, unit } = this.tables[table][key];
      return [capitalized(label), unit && shownIn({ unit }).text].filter(Boolean).join(", ");
    });
  }

  /**
   * Return the cells of a link's row. Link 1 of a free chain, which has no joint 1, has no fields for stops. The only link of a chain has
   * no button that removes it.
   */
  #linkRow(file, link, k) {
    const { base, links } = file.chain;
    const field = (key) =>
      this.#field(`link[${k + 1}].${key}`, link[key], (value, all) => setOfLink(all, k, key, value), this.tables.link[key].unit);
    const hasJoint = k > 0 || base !== "free";
    const cells = this.#keysOfLinks(file).map((key) => (hasJoint || !STOPS.includes(key) ? field(key) : ""));
    const remover = links.length > 1 ? this.#remover(`link ${k + 1}`, (all) => removeLink(all, k)) : "";
    return [`${k + 1}`, ...cells, remover];
  }

  /**
   * Return the cells of the row for a point of a link, which has the index `s` in the result of `sitesOf`; one of the cells is the field
   * for the number of the point's link.
   */
  #pointRow(file, site, s) {
    const { link, entry } = site;
    const number = file.chain.links.length + 1 + s;
    const label = `point[${number}]`;
    const pointOf = (all) => ownPoint(all, link, entry);
    const of = this.#field(`${label}.link`, link + 1, (value, all) => moveToLink(all, link, entry, value));
    const fields = this.#keysIn("point").map((key) => this.#field(`${label}.${key}`, site[key] === "" ? undefined : site[key],
      (value, all) => setOrRemove(pointOf(all), key, value), this.tables.point[key].unit));
    const remover = this.#remover(`point ${number}`, (all) => removePoint(all, link, entry));
    return [`${number}`, of, ...fields, remover];
  }

  #wallRow({ name, point, angle }, k) {
    const coordinates = ["x", "y"].map((axis, index) => this.#field(`wall.${name}.${axis}`, point[index], (value, all) => {
      all.walls[k].point[index] = value;
    }, this.tables.wall.point.each.unit));
    const turn = this.#field(`wall.${name}.angle`, angle, (value, all) => {
      all.walls[k].angle = value;
    }, this.tables.wall.angle.unit);
    return [name, ...coordinates, turn, this.#remover(`wall ${name}`, (all) => removeWall(all, k))];
  }

  /**
   * Return a field for the value of a key; an empty field means that the file does not give the key. `name`: name of the parameter; `set`:
   * a function of a value, undefined for an empty field, and the contents of a scene file, into which it puts the value.
   */
  #field(name, value, set, unit = "") {
    const whole = typeof value === "number" ? valueText(value, unit) : (value ?? "");
    // a long number is shown with 4 significant digits, so that it fits into the field
    const short = whole.length > 8 && Number(whole) ? numberText(Number(Number(whole).toPrecision(4))) : whole;
    const { text, told = "" } = this.#refused.get(name) ?? {};
    const field = make("input", { value: text ?? short, title: told || whole, autocomplete: "off" });
    field.setAttribute("aria-label", name);
    field.setCustomValidity(told);
    // an empty field shows as its placeholder the value that applies without the key, if this value is a number
    const derived = value === undefined && this.changes.valueOf(name);
    if (Number.isFinite(derived)) field.placeholder = valueText(Number(derived.toPrecision(4)), unit);
    this.#edits.set(name, (file, given) => set(given === "" ? undefined : typed(given, unit), file));
    field.addEventListener("change", () => this.#take(name, field.value.trim()));
    field.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !this.#refused.has(name)) return;
      event.preventDefault(); // the dialog stays
      this.#giveUp(name);
    });
    return field;
  }

  #remover(what, remove) {
    const button = make("button", { type: "button", className: "remove", textContent: "×", title: `Remove ${what}` });
    button.setAttribute("aria-label", `Remove ${what}`);
    this.#edits.set(button.title, remove);
    button.addEventListener("click", () => this.#change(this.#edits.get(button.title)));
    return button;
  }

  /** Fill a table. If it already has fields with the names of the new fields, only their contents change, so that the focus stays. */
  #fill(table, heads, rows) {
    const head = make("tr", {}, ...heads.map((text) => (text ? make("th", { scope: "col", textContent: text }) : make("td"))));
    const lineOf = (cells) => make("tr", {}, ...cells.map((cell, k) => withHead(make("td", {}, cell), heads[k])));
    const filled = make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows.map(lineOf)));
    const [fields, next] = [table, filled].map((one) => [...one.querySelectorAll("input")]);
    const namesOf = (all) => all.map((field) => field.getAttribute("aria-label")).join();
    if (!fields.length || namesOf(fields) !== namesOf(next)) {
      table.replaceChildren(...filled.children);
    } else {
      fields.forEach((field, k) => {
        const { value, title, placeholder, validationMessage } = next[k];
        Object.assign(field, { value, title, placeholder }).setCustomValidity(validationMessage);
      });
    }
    this.#showRefusals(table, heads.length);
  }

  /** Show below each row with refused texts why each text is refused, and a button that gives the text up. */
  #showRefusals(table, columns) {
    table.querySelectorAll(".told").forEach((row) => row.remove());
    table.querySelectorAll("tbody tr:has(input:invalid)").forEach((row) => {
      const messages = Array.from(row.querySelectorAll("input:invalid"), (field) => {
        const name = field.getAttribute("aria-label");
        const button = make("button", { type: "button", className: "give-up", textContent: "Undo" });
        button.setAttribute("aria-label", `Undo ${name}`);
        button.addEventListener("click", () => this.#giveUp(name));
        return make("p", { className: "refusal" }, make("span", { role: "alert", textContent: field.validationMessage }), " ", button);
      });
      row.after(make("tr", { className: "told" }, make("td", { colSpan: columns }, ...messages)));
    });
  }
}


/** Return a cell that stores the head of its column: on a narrow screen the style sheet shows the head above the cell. */
function withHead(cell, head) {
  cell.dataset.head = head;
  return cell;
}
