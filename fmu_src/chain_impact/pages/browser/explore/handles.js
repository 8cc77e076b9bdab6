// The handles with which the reader changes the start of the motion, the points of links and the walls, by dragging or with the arrow
// keys, while the clock stands at the start: grips of base, joints, tip, points of links and walls, and of the arrows of velocities.

import { isCrossed } from "../drawing/label_positions.js";
import { STRIP } from "../drawing/scale_strip.js";
import { edgeBefore, edgesOf } from "../recording/free_region.js";
import { sitesAt, startOf, wallsAt } from "../scene/geometry.js";
import { boxWallText } from "../scene/words.js";
import { HandleStops } from "./handle_stops.js";
import { gripFor, valueTextOf, writeAt } from "./handle_text.js";

const ARROW_TIME = 0.1; // [s] the arrow of a velocity is as long as the way that a point would move in at most this time
// largest length of an arrow of velocity, relative to the longer side of the view; ARROW_TIME is shortened so that no arrow is longer
const LONGEST_HANDLE = 0.2;
const GRIP = 26; // [pixels] diameter of a grip, large enough for a finger
// [pixels] distance from a point to the start of its arrow, so that the grip of a velocity of 0 lies beside the point
const STEM = 32;
const WALL = 18; // [pixels] size of the grip of a wall
const FOOT = 32; // [pixels] height of the line at the foot of the drawing that tells what can be dragged
const PLACES = 9; // number of places on each side of the middle of a wall that are tried for its grip
const BESIDE_GRIP = 2; // [pixels] least distance between the grip of a wall and any other grip
const MOST_DECIMALS = 15;
const STEPS_OF_KEYS = [4, 24]; // [pixels] distances by which an arrow key moves a grip: alone, and with Shift
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const SLIDER_VELOCITY = "initial.slider_velocity";

/** Return the value of a handle, rounded to the fewest decimals whose last place is at most `pixel`, the change of value by one pixel. */
function byHand(value, pixel) {
  const decimals = Math.min(Math.max(Math.ceil(-Math.log10(pixel)), 0), MOST_DECIMALS);
  return Number(value.toFixed(decimals));
}

export class Handles {
  constructor(player, changes, element) {
    Object.assign(this, { player, changes, element, footWidth: 0 }); // footWidth: width [pixels] of the line at the foot of the drawing
    // the handle that moves, or null: {kind, index, apart: distance [m] of a wall's handle from the wall, time: `#arrowTime`}, also with
    // `pointer`, the number of its pointer, or `by`, the step [x, y] of a key [pixels]; `#move` adds the position `at` and its `values`
    this.dragged = null;
    const isDragging = ({ pointerId }) => this.dragged?.pointer === pointerId;
    player.drawing.linesAbove = () => (this.areShown ? this.#arrows().map(({ from, to }) => [from, to]) : []);
    element.addEventListener("pointerdown", (event) => this.#grasp(event));
    element.addEventListener("pointermove", (event) => isDragging(event) && this.#drag(event));
    ["pointerup", "pointercancel"].forEach((name) => element.addEventListener(name, (event) => isDragging(event) && this.#drop()));
    element.setAttribute("role", "group"); // a drawing that contains grips is a group, and not an image, for screen readers
    element.addEventListener("keydown", (event) => this.#press(event));
    this.stops = new HandleStops(element);
    // a pointer does not move the focus to a grip, so that the arrow keys go on stepping through time
    element.addEventListener("mousedown", (event) => gripOf(event) && event.preventDefault());
    // a finger that drags a handle does not scroll the page
    const keepStill = (event) => gripOf(event) && event.preventDefault();
    element.addEventListener("touchstart", keepStill, { passive: false });
  }

  get areShown() {
    const { clock, recording } = this.player;
    return !clock.playing && clock.time === recording.start;
  }

  #value(name) {
    return this.changes.valueOf(name) ?? 0;
  }

  /** Return { positions [m], velocity [m/s] } of the base and the link ends at the start, for the present parameters. */
  get #start() {
    // a base that a signal drives does not have the position of the parameters, but that at the start of the shown motion
    const isDriven = this.changes.scene.driven.some(({ name }) => name === "base.x" || name === "base.y");
    const base = isDriven ? this.player.recording.pointAt(0, 0) : undefined;
    const positions = startOf(this.changes.scene, this.changes.valueOf, base);
    const sliding = this.#line?.map((component) => component * this.#value(SLIDER_VELOCITY));
    const velocity = [sliding ?? [this.#value("initial.vx"), this.#value("initial.vy")]];
    positions.slice(1).forEach((_, k) => {
      const link = k + 1;
      const rate = this.#value(`initial.angular_velocity[${link}]`);
      const [x, y] = vectorTo(positions[link - 1], positions[link]);
      velocity.push([velocity.at(-1)[0] - rate * y, velocity.at(-1)[1] + rate * x]);
    });
    return { positions, velocity };
  }

  /** Return the unit vector along the slider's line; null without a slider. */
  get #line() {
    const angle = this.#value("slider.angle");
    return this.changes.parameters.has(SLIDER_VELOCITY) ? [Math.cos(angle), Math.sin(angle)] : null;
  }

  /** Return how long the arrow of 1 m/s is [pixels]. */
  get arrowScale() { return this.#arrowTime(this.#start.velocity) * this.player.drawing.camera.scale; }

  /**
   * Return the time t [s] that scales the arrows of velocities: the arrow of a velocity v has the length v·t. The time is shorter for fast
   * motions, so that no arrow is too long, and does not change while a handle is dragged.
   */
  #arrowTime(velocity) {
    if (this.dragged) return this.dragged.time;
    const [low, high] = this.player.recording.view;
    const size = Math.max(high[0] - low[0], high[1] - low[1]);
    return Math.min(ARROW_TIME, (LONGEST_HANDLE * size) / Math.max(...velocity.map(([x, y]) => Math.hypot(x, y)), 1e-300));
  }

  /**
   * Return the grips of the walls that can be moved: name, position on the screen `at`, and whether the wall is in the view. A grip lies
   * near the middle of the visible part of its wall or, for a wall beyond the view, just inside the edge of the view; if possible, the grip
   * lies apart from points, arrows, links, texts and other grips.
   */
  get #walls() {
    const { camera } = this.player.drawing;
    const walls = wallsAt(this.changes.scene, (name) => this.changes.valueOf(name));
    const others = this.#marks();
    return Object.entries(walls).flatMap(([name, wall]) => {
      const movable = this.changes.valueOf(`box.${name}`) !== undefined || this.changes.valueOf(`wall.${name}.x`) !== undefined;
      if (!movable) return [];
      const [ends] = edgesOf(walls, name, camera.rectangle);
      const line = ends ?? this.#edgeBefore(wall);
      if (!line) return [];
      const at = this.#freePlace(line.map((end) => camera.toScreen(...end)), others);
      others.points.push(at);
      return [{ name, at, isSeen: Boolean(ends) }];
    });
  }

  /** Return `points` and `lines` on the screen from which grips of walls keep a distance: other grips, the foot's line, links, arrows. */
  #marks() {
    const screen = (point) => this.player.drawing.camera.toScreen(...point);
    const { positions } = this.#start;
    const [chain, arrows] = [positions.map(screen), this.#arrows()];
    const points = [...chain, ...this.#sites(positions).map(({ at }) => screen(at)), ...arrows.map(({ to }) => to)];
    const [, height] = this.player.drawing.size;
    for (let x = 0; x < this.footWidth + GRIP; x += GRIP) points.push([x, height - FOOT / 2]);
    return { points, lines: [...chain.slice(1).map((to, k) => [chain[k], to]), ...arrows.map(({ from, to }) => [from, to])] };
  }

  /**
   * Return where on a line on the screen a wall's grip is put: of some places along the line, moved into the drawing, the free place
   * nearest to the middle of the line, or the place at the middle if none is free.
   */
  #freePlace([from, to], { points, lines }) {
    const { labelSpace } = this.player.drawing;
    const [left, top, right, bottom] = labelSpace.limits;
    const [lows, highs] = [[left, top], [right, bottom]].map((end, k) => end.map((limit) => limit + (k ? -1 : 1) * (WALL / 2)));
    const inside = (place) => place.map((value, axis) => Math.min(Math.max(value, lows[axis]), highs[axis]));
    const steps = Array.from({ length: PLACES }, (_, k) => k + 1).flatMap((step) => [step, -step]);
    const shares = [0, ...steps].map((step) => 0.5 + (0.5 * step) / (PLACES + 1));
    const places = shares.map((share) => inside(from.map((end, axis) => end + share * (to[axis] - end))));
    return places.find(([x, y]) => {
      const box = [x - WALL / 2, y - WALL / 2, x + WALL / 2, y + WALL / 2];
      return labelSpace.isClear(box) && !lines.some((line) => isCrossed(box, line))
        && points.every((point) => Math.hypot(point[0] - x, point[1] - y) >= (GRIP + WALL) / 2 + BESIDE_GRIP);
    }) ?? places[0];
  }

  /**
   * Return the two ends of the line, just inside the edge of the view, on which the grip of a wall beyond the view may be put; undefined if
   * there is no such line.
   */
  #edgeBefore(wall) {
    const { rectangle: [[left, bottom], [right, top]] } = this.player.drawing.camera;
    const [low, high] = [[left, bottom + FOOT * this.#pixel], [right, top - STRIP * this.#pixel]];
    const middle = edgeBefore(wall, [low, high], WALL * this.#pixel);
    if (!middle) return undefined;
    const half = Math.min(high[0] - low[0], high[1] - low[1]) / 2;
    return [-half, half].map((along) => [middle[0] - along * wall.normal[1], middle[1] + along * wall.normal[0]]);
  }

  /** Draw the handles if the clock is paused at the start; otherwise remove them. */
  draw() {
    const { drawing } = this.player;
    const focused = gripOf({ target: document.activeElement });
    drawing.above.clear();
    if (!this.areShown) return;
    const { positions } = this.#start;
    const screen = (point) => drawing.camera.toScreen(...point);
    const group = drawing.above;
    group.polyline(positions.map(screen)).addClass("pose").fill("none");
    this.#walls.forEach(({ name, at, isSeen }) => {
      const grip = gripFor("wall", name, boxWallText(name, this.changes.valueOf));
      const [x, y] = at;
      group.rect(WALL, WALL).radius(5).center(x, y).addClass(isSeen ? "wall-grip" : "wall-grip wall-beyond").attr(grip);
    });
    this.#arrows().forEach(({ from, foot, to, k }) => {
      group.line([from, foot]).addClass("velocity-stem");
      group.line([foot, to]).addClass("velocity");
      group.circle(9).center(...to).addClass("velocity-tip");
      group.circle(GRIP).center(...to).addClass("grip").attr(gripFor("velocity", k));
    });
    const names = new Map(this.player.recording.pointNames);
    this.#sites(positions).forEach(({ number, at }) => {
      const label = names.has(number) ? ` (${names.get(number)})` : "";
      group.circle(13).center(...screen(at)).addClass("joint-ring");
      group.circle(GRIP).center(...screen(at)).addClass("grip").attr(gripFor("site", number, label));
    });
    positions.forEach((point, k) => {
      group.circle(15).center(...screen(point)).addClass("joint-ring");
      group.circle(GRIP).center(...screen(point)).addClass("grip").attr(gripFor("joint", k));
    });
    const { at, values } = this.dragged ?? {};
    if (at) writeAt(drawing, valueTextOf(this.changes, values), at);
    this.stops.show();
    if (focused) this.element.querySelector(`[data-grip="${focused}"]`)?.focus({ preventScroll: true });
  }

  /** Return the points of links that the reader can move, all but corners of boxes, with their positions at the start [m]. */
  #sites(positions) {
    const { links, sites } = this.changes.scene;
    const all = sitesAt(positions, sites, (name) => this.#value(name));
    return sites.flatMap((site, s) => (site.corner ? [] : [{ number: links + 1 + s, site, at: all[s] }]));
  }

  /**
   * Return the arrows of the velocities that the reader can change, in pixels of the drawing: a stem from the point `k` (`from`) to `foot`,
   * and the arrow from `foot` to `to`.
   */
  #arrows() {
    const { positions, velocity } = this.#start;
    const time = this.#arrowTime(velocity);
    const screen = (point) => this.player.drawing.camera.toScreen(...point);
    const first = this.#line || this.changes.parameters.has("initial.vx") ? 0 : 1;
    return positions.map((point, k) => {
      const from = screen(point);
      const vector = vectorTo(from, screen(tipOf(point, velocity[k], time)));
      const length = Math.hypot(...vector);
      const direction = length > 0 ? vector.map((component) => component / length) : this.#aside(k, from);
      const foot = from.map((coordinate, axis) => coordinate + STEM * direction[axis]);
      return { from, foot, to: foot.map((coordinate, axis) => coordinate + vector[axis]), k };
    }).slice(first);
  }

  /**
   * Return the direction on the screen of the stem at a point `k` whose velocity is 0. At the base of a slider, the stem lies along the
   * slider's line; at another base, opposite to link 1; at the end of a link, in the direction in which an anticlockwise turn of this link
   * moves it. If the grip would then not be in the drawing, another direction is tried, except at a slider.
   */
  #aside(k, [x, y]) {
    if (k === 0 && this.#line) return [this.#line[0], -this.#line[1]];
    const angle = this.#value(`initial.angle[${Math.max(k, 1)}]`);
    const [dx, dy] = k === 0 ? [-Math.cos(angle), Math.sin(angle)] : [-Math.sin(angle), -Math.cos(angle)];
    const [width, height] = this.player.drawing.size;
    const isInside = (at, size) => at > GRIP / 2 && at < size - GRIP / 2;
    const isWhole = ([ux, uy]) => isInside(x + STEM * ux, width) && isInside(y + STEM * uy, height);
    return [[dx, dy], [-dy, dx], [dy, -dx], [-dx, -dy]].find(isWhole) ?? [dx, dy];
  }

  #grasp(event) {
    const grip = gripOf(event);
    if (!grip || this.dragged || event.button !== 0) return;
    const [kind, index] = grip.split(" ");
    const apart = this.#apart(event.target.closest("[data-grip]"), kind, index);
    this.dragged = { kind, index, apart, pointer: event.pointerId, time: this.#arrowTime(this.#start.velocity) };
    this.element.setPointerCapture(event.pointerId);
    event.preventDefault();
  }

  #drop() {
    this.dragged = null;
    this.changes.replace({ ...this.changes.values }); // the values stay, but the run is repeated, now with a view that fits the motion
  }

  #drag(event) {
    const { left, top } = this.element.getBoundingClientRect();
    this.#move(event.clientX - left, event.clientY - top);
  }

  /** Move the grip that has the focus when an arrow key is pressed. */
  #press(event) {
    const grip = gripOf(event);
    const direction = KEYS[event.key];
    if (!grip || !direction || this.dragged) return;
    event.preventDefault();
    event.stopPropagation();
    const [kind, index] = grip.split(" ");
    const { x, y, width, height } = event.target.getBBox();
    const step = STEPS_OF_KEYS[Number(event.shiftKey)];
    const by = [direction[0] * step, direction[1] * step];
    this.dragged = { kind, index, by, apart: this.#apart(event.target, kind, index), time: this.#arrowTime(this.#start.velocity) };
    this.#move(x + width / 2 + by[0], y + height / 2 + by[1]);
    this.dragged = null;
    this.draw(); // drawn at once, so that the next press of a key starts from the grip's new position
  }

  /**
   * Return the distance [m] of a wall's grip from the wall, along the wall's normal; 0 for other grips, and for a wall beyond the view,
   * which jumps to its grip.
   */
  #apart(element, kind, name) {
    if (kind !== "wall" || element.classList.contains("wall-beyond")) return 0;
    const { x, y, width, height } = element.getBBox();
    return this.#beyond(this.player.drawing.camera.toMetres(x + width / 2, y + height / 2), name);
  }

  /** Return the distance [m] of a position from the wall `name`: positive on the wall's free side. */
  #beyond([x, y], name) {
    const { normal: [nx, ny], offset } = this.#wall(name);
    return nx * x + ny * y - offset;
  }

  #wall(name) {
    return wallsAt(this.changes.scene, (parameter) => this.changes.valueOf(parameter))[name];
  }

  /** Move the dragged handle to a position on the screen, if the scene allows the values that belong to the position. */
  #move(left, top) {
    const at = this.player.drawing.camera.toMetres(left, top);
    const { kind, index } = this.dragged;
    try {
      const values = this[kind](at, index);
      this.changes.set(values);
      Object.assign(this.dragged, { at: [left, top], values });
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
      // the scene refuses this position, so the handle stays at its old position
    }
  }

  /** Return the size of a pixel [m]. */
  get #pixel() {
    const { camera } = this.player.drawing;
    return Math.abs(camera.toMetres(1, 0)[0] - camera.toMetres(0, 0)[0]);
  }

  /** Return the changes that move the base (`index` 0) to a position [m], or turn the link that ends at point `index` to the position. */
  joint([x, y], index) {
    const k = Number(index);
    if (k === 0) return { "initial.x": byHand(x, this.#pixel), "initial.y": byHand(y, this.#pixel) };
    const [x0, y0] = this.#start.positions[k - 1];
    const name = `initial.angle[${k}]`;
    const angle = Math.atan2(y - y0, x - x0);
    const turns = Math.round((this.#value(name) - angle) / (2 * Math.PI));
    return { [name]: byHand(angle + 2 * Math.PI * turns, this.#pixel / this.#value(`link[${k}].length`)) };
  }

  /** Return the changes of the coordinates of the point `number` on its link, such that the point is at the position [x, y] in meters. */
  site([x, y], number) {
    const { positions } = this.#start;
    const { site: { link, entry } } = this.#sites(positions).find(({ number: other }) => other === Number(number));
    const angle = this.#value(`initial.angle[${link + 1}]`);
    const [dx, dy] = vectorTo(positions[link], [x, y]);
    const along = { x: dx * Math.cos(angle) + dy * Math.sin(angle), y: dy * Math.cos(angle) - dx * Math.sin(angle) };
    return Object.fromEntries(Object.entries(along).map(([key, value]) =>
      [`link[${link + 1}].point[${entry + 1}].${key}`, byHand(value, this.#pixel)]));
  }

  /**
   * Return the changes of parameters with which the arrow at the point `index` follows the pointer to a position [m]: of the velocity of
   * the base (0), or of the angular velocity of the link that ends at the point.
   */
  velocity([x, y], index) {
    const k = Number(index);
    const { positions, velocity } = this.#start;
    const pixel = this.#pixel / this.dragged.time;
    const line = k === 0 ? this.#line : null;
    const from = vectorTo(positions[k], [x, y]);
    const vector = line ? line.map((component) => component * componentOf(from, line)) : from;
    const share = Math.max(0, 1 - (STEM * this.#pixel) / Math.hypot(...vector)); // part of the vector that is the arrow, without its stem
    const speed = vector.map((component) => (share * component) / this.dragged.time);
    if (line) {
      // A key changes the speed itself, not the length of the arrow, so that the speed can pass 0, where the arrow turns round.
      const { by } = this.dragged;
      const own = by ? this.#value(SLIDER_VELOCITY) + componentOf([by[0], -by[1]], line) * pixel : componentOf(speed, line);
      return { [SLIDER_VELOCITY]: byHand(own, pixel) };
    }
    if (k === 0) return { "initial.vx": byHand(speed[0], pixel), "initial.vy": byHand(speed[1], pixel) };
    const link = [0, 1].map((axis) => positions[k][axis] - positions[k - 1][axis]);
    const added = [0, 1].map((axis) => speed[axis] - velocity[k - 1][axis]);
    const rate = (link[0] * added[1] - link[1] * added[0]) / (link[0] ** 2 + link[1] ** 2);
    return { [`initial.angular_velocity[${k}]`]: byHand(rate, pixel / this.#value(`link[${k}].length`)) };
  }

  /** Return the changes of parameters that move the wall `name` along its normal so that its grip lies at a position [m]. */
  wall(position, name) {
    const { normal: [nx, ny] } = this.#wall(name);
    const distance = this.#beyond(position, name) - this.dragged.apart;
    if (this.changes.valueOf(`box.${name}`) !== undefined) {
      return { [`box.${name}`]: byHand(this.#value(`box.${name}`) + distance * (nx + ny), this.#pixel) };
    }
    return Object.fromEntries([["x", nx], ["y", ny]].map(([axis, component]) =>
      [`wall.${name}.${axis}`, byHand(this.#value(`wall.${name}.${axis}`) + distance * component, this.#pixel)]));
  }
}

/** Return kind and index, or kind and wall, of an event's grip as a text: "joint 2", "wall y_min"; undefined if the event is on no grip. */
function gripOf({ target }) {
  return target.closest("[data-grip]")?.dataset.grip;
}

/** Return the vector from one position to another. */
function vectorTo([x0, y0], [x1, y1]) {
  return [x1 - x0, y1 - y0];
}

/** Return the component of a vector along a direction. */
function componentOf([x, y], [dx, dy]) {
  return x * dx + y * dy;
}

/** Return the position [m] that a point reaches with a constant velocity [m/s] in a time [s]. */
function tipOf([x, y], [vx, vy], time) {
  return [x + vx * time, y + vy * time];
}
