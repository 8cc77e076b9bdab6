// The dialog in which links, walls and stops are added and removed, and scene files are opened.

import { numberText } from "./changes.js";
import { find, make } from "./dom.js";
import { contentsOf } from "./outside.js";
import { movablePoints, stopsOf } from "./scene_file.js";
import { STOPS } from "./view.js";

const BOX = { x_min: "left", x_max: "right", y_min: "floor", y_max: "ceiling" };
const BELOW = 0.5; // of the longest link: a new wall is so far below the chain

/** The text of a file as the contents of a scene file; an error names the line. */
export function contentsIn(text) {
  try {
    return TOML.parse(text.replace(/^\ufeff/, ""));
  } catch (error) {
    throw new RangeError(`not valid TOML: ${error.message.split("\n")[0].replace(/^Invalid TOML document: /, "")} (at line ${error.line})`);
  }
}

export class Editor {
  /** `open` shows a scene of some contents, and throws what is wrong with them; `first` shows the page's own scene. */
  constructor(changes, open, first) {
    Object.assign(this, { changes, open });
    this.dialog = find("edit");
    find("edit-open").addEventListener("click", () => {
      this.#draw();
      this.#say("");
      this.dialog.showModal();
    });
    find("add-link").addEventListener("click", () => this.#change(addLink));
    find("add-wall").addEventListener("click", () => this.#change(addWall));
    find("edit-base").addEventListener("change", ({ target }) => this.#change((file) => setBase(file, target.value)));
    find("edit-choose").addEventListener("click", () => find("edit-file").click());
    find("edit-file").addEventListener("change", ({ target }) => {
      this.#read(target.files[0]);
      target.value = ""; // so that the same file can be chosen again
    });
    find("edit-first").addEventListener("click", () => {
      first();
      this.#draw();
    });
    const onFiles = (kind, take) => document.addEventListener(kind, (event) => {
      if (!event.dataTransfer.types.includes("Files")) return; // text is dropped into fields
      event.preventDefault();
      take([...event.dataTransfer.files]);
    });
    onFiles("dragover", () => {});
    onFiles("drop", ([file]) => file && this.#read(file, () => this.dialog.open || this.dialog.showModal()));
  }

  /** Open a scene file; `onFault` is called if it cannot be. */
  async #read(file, onFault = () => {}) {
    const text = await file.text().catch((error) => error);
    this.#try(() => {
      if (text instanceof Error) throw text; // of a folder, or of a file that is gone
      this.open(contentsIn(text));
    }, `${file.name} is open.`, (error) => {
      onFault();
      return `${file.name} cannot be opened: ${error.message.replace(/\.$/, "")}.`;
    });
  }

  /** Change the contents of the scene as the page shows it. */
  #change(edit) {
    const file = contentsOf(this.changes);
    this.#try(() => {
      edit(file);
      this.open(file);
    }, "", (error) => `Not taken: ${error.message}.`);
  }

  #try(action, done, refused) {
    let text = done;
    try {
      action();
    } catch (error) {
      text = refused(error);
    }
    this.#draw();
    this.#say(text);
  }

  #say(text) {
    find("edit-text").textContent = text;
  }

  #draw() {
    const { scene: { file } } = this.changes;
    find("edit-base").value = file.chain.base;
    const heads = ["Link", "Length, m", "Mass, kg", "Stop from, rad", "Stop to, rad", ""];
    fillTable(find("edit-links"), heads, file.chain.links.map((link, k) => this.#linkRow(file, link, k)));
    fillTable(find("edit-box"), Object.values(BOX).map((text) => `${text}, m`), [Object.keys(BOX).map((key) =>
      this.#field(`box.${key}`, file.box[key], (value, all) => setBox(all, key, value)))]);
    fillTable(find("edit-walls"), ["Wall", "x, m", "y, m", "Angle, rad", ""], file.walls.map((wall, k) => this.#wallRow(wall, k)));
    find("edit-walls").hidden = file.walls.length === 0;
  }

  /** The fields of a link; a free base has no joint that could have a stop, and the last link stays. */
  #linkRow({ chain: { base, links } }, link, k) {
    const field = (key) => this.#field(`link[${k + 1}].${key}`, link[key], (value, all) => setOfLink(all, k, key, value));
    const stops = k === 0 && base === "free" ? ["", ""] : STOPS.map(field);
    const remover = links.length > 1 ? this.#remover(`link ${k + 1}`, (all) => removeLink(all, k)) : "";
    return [`${k + 1}`, field("length"), field("mass"), ...stops, remover];
  }

  #wallRow({ name, point, angle }, k) {
    const place = ["x", "y"].map((axis, way) => this.#field(`wall.${name}.${axis}`, point[way], (value, all) => {
      all.walls[k].point[way] = value;
    }));
    const turn = this.#field(`wall.${name}.angle`, angle, (value, all) => {
      all.walls[k].angle = value;
    });
    return [name, ...place, turn, this.#remover(`wall ${name}`, (all) => removeWall(all, k))];
  }

  /** A field for a number, or an angle in text; nothing in it stands for no value. */
  #field(name, value, set) {
    const field = make("input", { value: value === undefined ? "" : numberText(value), autocomplete: "off" });
    field.setAttribute("aria-label", name);
    field.addEventListener("change", () => {
      const text = field.value.trim();
      const given = text === "" ? undefined : Number.isNaN(Number(text)) ? text : Number(text);
      this.#change((file) => set(given, file));
    });
    return field;
  }

  #remover(what, remove) {
    const button = make("button", { type: "button", className: "remove", textContent: "×", title: `Remove ${what}` });
    button.setAttribute("aria-label", `Remove ${what}`);
    button.addEventListener("click", () => this.#change(remove));
    return button;
  }
}

function fillTable(table, heads, rows) {
  const head = make("tr", {}, ...heads.map((text) => (text ? make("th", { scope: "col", textContent: text }) : make("td"))));
  const body = rows.map((cells) => make("tr", {}, ...cells.map((cell) => make("td", {}, cell))));
  table.replaceChildren(make("thead", {}, head), make("tbody", {}, ...body));
}

function setOrRemove(table, key, value) {
  if (value === undefined) delete table[key];
  else table[key] = value;
}

function setOfLink(file, k, key, value) {
  setOrRemove(file.chain.links[k], key, value);
  if (!stopsOf(file).length) file.stops = {}; // the law of stops goes with the last of them
}

/** What a free base cannot have goes; so does what a pinned one cannot. */
function setBase(file, base) {
  file.chain.base = base;
  if (base === "free") {
    STOPS.forEach((stop) => setOfLink(file, 0, stop, undefined));
    file.inputs.base_motion = false;
  } else {
    file.initial.velocity = [0, 0];
  }
  keepPoints(file);
}

/** Of the points that the file lists, those stay that are there and can move. */
function keepPoints(file) {
  const movable = movablePoints(file);
  file.contact.points &&= file.contact.points.filter((point) => movable.includes(point));
}

/** Another link behind the last one, equal to it and in line with it. */
function addLink({ chain: { links }, initial, contact }) {
  const tip = links.length;
  links.push({ ...links.at(-1) });
  if (tip === 1) STOPS.forEach((stop) => delete links[tip][stop]); // which are those of the angle from +x
  [initial.angles, initial.angular_velocities].forEach((list) => list.push(list.at(-1)));
  if (contact.points?.includes(tip)) contact.points.push(tip + 1);
}

function removeLink(file, k) {
  [file.chain.links, file.initial.angles, file.initial.angular_velocities].forEach((list) => list.splice(k, 1));
  const { links } = file.chain;
  // the link that is the first one now has no stop that it had against the removed one
  STOPS.forEach((stop) => setOfLink(file, 0, stop, k === 0 ? undefined : links[0][stop]));
  const points = file.contact.points?.map((point) => (point > k ? point - 1 : point)); // both ends of the link are one
  file.contact.points &&= [...new Set(points)];
  keepPoints(file);
}

/** A level wall below the chain at its start. */
function addWall(file) {
  const { chain: { links }, initial, walls } = file;
  let [height, least] = [initial.position[1], initial.position[1]];
  links.forEach(({ length }, k) => {
    height += length * Math.sin(initial.angles[k]);
    least = Math.min(least, height);
  });
  const names = new Set(walls.map(({ name }) => name));
  let number = 1;
  while (names.has(`wall${number}`)) number += 1;
  const y = least - (file.contact.radius ?? 0) - BELOW * Math.max(...links.map(({ length }) => length));
  walls.push({ name: `wall${number}`, point: [initial.position[0], Number(y.toPrecision(4))], angle: 0 });
}

function removeWall(file, k) {
  const [{ name }] = file.walls.splice(k, 1);
  forget(file, name);
}

function setBox(file, key, value) {
  setOrRemove(file.box, key, value);
  if (value === undefined) forget(file, key);
}

/** A wall that goes takes its material and its motion along. */
function forget({ contact, inputs }, name) {
  delete contact.wall[name];
  inputs.wall_motion = inputs.wall_motion.filter((one) => one !== name);
}
