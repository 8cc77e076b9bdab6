// The dialog in which the reader adds and removes links, points, walls and stops, and opens scene files.

import { find, make } from "../base/dom.js";
import { numberText } from "../base/format.js";
import { contentsOf } from "../scene/changed_file.js";
import { STOPS } from "../scene/geometry.js";
import { movablePoints, sitesOf, stopsOf } from "../scene/scene_file.js";

const BOX = { x_min: "left", x_max: "right", y_min: "floor", y_max: "ceiling" };
const SLIDER = { angle: "Slider: angle, rad", mass: "Mass, kg", friction: "Friction, N", min: "Stop from, m", max: "Stop to, m" };
const CORNERS = 4; // number of corners of a box, which a scene file leaves out
const BELOW = 0.5; // distance of a new wall below the chain, over the length of the longest link

/** Return the contents of a scene file from its text; an error names the line. */
export function contentsIn(text) {
  try {
    return TOML.parse(text.replace(/^\ufeff/, ""));
  } catch (error) {
    throw new RangeError(`not valid TOML: ${error.message.split("\n")[0].replace(/^Invalid TOML document: /, "")} (at line ${error.line})`);
  }
}

export class Editor {
  /** `open` shows a scene with some contents and changed inputs, or throws an error; `first` shows the page's own scene. */
  constructor(changes, open, first) {
    Object.assign(this, { changes, open });
    this.dialog = find("edit");
    find("edit-open").addEventListener("click", () => {
      this.#draw();
      this.#say("");
      this.dialog.showModal();
    });
    find("add-link").addEventListener("click", () => this.#change(addLink));
    find("add-point").addEventListener("click", () => this.#change(addPoint));
    find("add-wall").addEventListener("click", () => this.#change(addWall));
    find("edit-base").addEventListener("change", ({ target }) => this.#change((file) => setBase(file, target.value)));
    find("edit-choose").addEventListener("click", () => find("edit-file").click());
    find("edit-file").addEventListener("change", ({ target }) => {
      this.#read(target.files[0]);
      target.value = ""; // so that the same file can be chosen a second time
    });
    find("edit-first").addEventListener("click", () => {
      first();
      this.#draw();
    });
    const onFiles = (kind, take) => document.addEventListener(kind, (event) => {
      if (!event.dataTransfer.types.includes("Files")) return; // a text that is dropped into a field is not a file
      event.preventDefault();
      take([...event.dataTransfer.files]);
    });
    onFiles("dragover", () => {});
    onFiles("drop", ([file]) => file && this.#read(file, () => this.dialog.open || this.dialog.showModal()));
  }

  /** Open a scene file; `onFault` is called if this is not possible. */
  async #read(file, onFault = () => {}) {
    const text = await file.text().catch((error) => error);
    this.#try(() => {
      if (text instanceof Error) throw text; // fails for a folder, and for a file that no longer exists
      this.open(contentsIn(text));
    }, `${file.name} is open.`, (error) => {
      onFault();
      return `${file.name} cannot be opened: ${error.message.replace(/\.$/, "")}.`;
    });
  }

  /** Change the contents of the present scene of the page; its inputs keep their changes. */
  #change(edit) {
    const { values, held } = this.changes;
    const file = contentsOf(this.changes);
    this.#try(() => {
      edit(file);
      this.open(file, { values, held });
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
    const heads = ["Link", "Length, m", "Mass, kg", "Offset, m", "Box height, m", "Stop from, rad", "Stop to, rad", ""];
    fillTable(find("edit-links"), heads, file.chain.links.map((link, k) => this.#linkRow(file, link, k)));
    const own = sitesOf(file).map((site, s) => [site, s]).filter(([{ corner }]) => !corner);
    fillTable(find("edit-points"), ["Point", "Link", "Along, m", "Left, m", "Radius, m", "Name", ""], own.map(([site, s]) => this.#pointRow(file, site, s)));
    find("edit-points").hidden = own.length === 0;
    const { slider } = file.chain;
    find("edit-slider").hidden = !slider;
    if (slider) {
      fillTable(find("edit-slider"), Object.values(SLIDER), [Object.keys(SLIDER).map((key) =>
        this.#field(`slider.${key}`, slider[key], (value, all) => setOrRemove(all.chain.slider, key, value)))]);
    }
    fillTable(find("edit-box"), Object.values(BOX).map((text) => `${text}, m`), [Object.keys(BOX).map((key) =>
      this.#field(`box.${key}`, file.box[key], (value, all) => setBox(all, key, value)))]);
    fillTable(find("edit-walls"), ["Wall", "x, m", "y, m", "Angle, rad", ""], file.walls.map((wall, k) => this.#wallRow(wall, k)));
    find("edit-walls").hidden = file.walls.length === 0;
  }

  /** Return the fields of a link. A free base has no joint, and so no stop; the last link cannot be removed. */
  #linkRow({ chain: { base, links } }, link, k) {
    const field = (key) => this.#field(`link[${k + 1}].${key}`, link[key], (value, all) => setOfLink(all, k, key, value));
    const stops = k === 0 && base === "free" ? ["", ""] : STOPS.map(field);
    const remover = links.length > 1 ? this.#remover(`link ${k + 1}`, (all) => removeLink(all, k)) : "";
    return [`${k + 1}`, ...["length", "mass", "center_of_mass_offset", "height"].map(field), ...stops, remover];
  }

  /** Return the fields of a point of a link, among them the link to which the point belongs. */
  #pointRow(file, site, s) {
    const { link, entry } = site;
    const label = `point[${file.chain.links.length + 1 + s}]`;
    const pointOf = (all) => ownPoint(all, link, entry);
    const of = this.#field(`${label}.link`, link + 1, (value, all) => moveToLink(all, link, entry, value));
    const fields = ["x", "y", "radius"].map((key) => this.#field(`${label}.${key}`, site[key], (value, all) => setOrRemove(pointOf(all), key, value)));
    const name = this.#field(`${label}.name`, site.name || undefined, (value, all) => setOrRemove(pointOf(all), "name", value));
    const remover = this.#remover(`point ${file.chain.links.length + 1 + s}`, (all) => removePoint(all, link, entry));
    return [`${file.chain.links.length + 1 + s}`, of, ...fields, name, remover];
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

  /** Return a field for a number, or for an angle as text; an empty field stands for no value. */
  #field(name, value, set) {
    const field = make("input", { value: typeof value === "number" ? numberText(value) : (value ?? ""), autocomplete: "off" });
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
  const link = file.chain.links[k];
  setOrRemove(link, key, value);
  if (key === "height") setOrRemove(link, "shape", value === undefined ? undefined : "box");
  if (!stopsOf(file).length) file.stops = {}; // the law of stops is removed with the last stop
}

/** Return a point of a link by its index among the points; the first points are the corners of a box. */
function ownPoint({ chain: { links } }, link, entry) {
  return links[link].points[entry - (links[link].shape ? CORNERS : 0)];
}

function removePoint({ chain: { links } }, link, entry) {
  links[link].points.splice(entry - (links[link].shape ? CORNERS : 0), 1);
}

function moveToLink(file, link, entry, number) {
  const { chain: { links } } = file;
  if (!links[number - 1]) throw new RangeError(`the link of a point = ${number} must be 1 to ${links.length}`);
  const point = ownPoint(file, link, entry);
  removePoint(file, link, entry);
  links[number - 1].points.push(point);
}

/** Add a point to the left of the middle of the last link. */
function addPoint({ chain: { links } }) {
  const { length, points } = links.at(-1);
  points.push({ x: length / 2, y: length / 10 });
}

/** Set the kind of the base, and remove all values that such a base cannot have. */
function setBase(file, base) {
  file.chain.base = base;
  if (base !== "slider") {
    delete file.chain.slider;
    delete file.initial.slider_velocity;
    file.inputs.slider_force = false;
  }
  if (base === "free") {
    STOPS.forEach((stop) => setOfLink(file, 0, stop, undefined));
    file.inputs.base_motion = false;
  } else {
    file.initial.velocity = [0, 0];
    if (base === "slider") file.inputs.base_motion = false;
  }
  keepPoints(file);
}

/** Keep, among the listed points of the file, the points that exist and can move. */
function keepPoints(file) {
  const movable = movablePoints(file);
  file.contact.points &&= file.contact.points.filter((point) => movable.includes(point));
}

/** Add another link after link k, equal to it and in line with it. */
function addLink({ chain: { links }, initial, contact }) {
  const tip = links.length;
  links.push(structuredClone(links.at(-1)));
  if (tip === 1) STOPS.forEach((stop) => delete links[tip][stop]); // both lists are absolute, from +x
  [initial.angles, initial.angular_velocities].forEach((list) => list.push(list.at(-1)));
  if (contact.points?.includes(tip)) contact.points.push(tip + 1);
}

function removeLink(file, k) {
  [file.chain.links, file.initial.angles, file.initial.angular_velocities].forEach((list) => list.splice(k, 1));
  const { links } = file.chain;
  // the link that is the first one now has no stop, because its stops were relative to the removed link
  STOPS.forEach((stop) => setOfLink(file, 0, stop, k === 0 ? undefined : links[0][stop]));
  // the two ends of the removed link become one point
  const points = file.contact.points?.map((point) => (point > k ? point - 1 : point));
  file.contact.points &&= [...new Set(points)];
  keepPoints(file);
}

/** Add a horizontal wall below the chain at its start. */
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

/** Remove the material and the motion of a wall that is removed. */
function forget({ contact, inputs }, name) {
  delete contact.wall[name];
  inputs.wall_motion = inputs.wall_motion.filter((one) => one !== name);
}
