// The drawing of a chain: walls, chain, trace of the tip or of the centre of a ball, arrows of forces; drawn by SVG.js, with colours from
// the style sheet.

import { forceText, unitsOf } from "../base/format.js";
import { freeRegionWithin } from "../recording/free_region.js";
import { lastBefore } from "../recording/recording.js";
import { STOPS } from "../scene/geometry.js";
import { ArrowScale } from "./arrow_scale.js";
import { Camera } from "./camera.js";
import { isCrossed, KeptPositions, LabelSpace, outOfBody, outOfChain, positionsAround } from "./label_positions.js";
import { impulsesOf, isOwnPlace, largestImpulse, numbersText, recentImpacts, ringsOf } from "./rings.js";
import { drawStrip, STRIP } from "./scale_strip.js";
import { drawRail } from "./slider_rail.js";
import { traceFinder, traceOf } from "./trace.js";

const LABEL_FROM = 14; // [pixels] an arrow that is shorter has no label
const [FORCE_TEXT, NUMBER_TEXT] = [13, 11]; // [pixels] size of the letters of forces and of numbers
// distances from an arrow's head to its label that are tried in this order, as multiples of the first
const FORCE_MULTIPLES = [1, 1.5, 2, 3, 4, 5];
const { TAIL } = SHARED.pacing; // [s] simulated time after which the bright end of the trace is faded
const TAIL_PARTS = 10;
const HATCH = 9; // [pixels] distance between the hatching lines beyond walls
const STOP_DOT = 11; // [pixels] diameter of the mark of a joint that touches its stop
const STICK_BAR = 12; // [pixels] half the length of the bar along the wall at a sticking contact
const [STUCK_DOT, BALL_DOT] = [10, 18]; // [pixels] diameters of the mark of a sticking joint, and of a ball that is a point
// RANGE_RADIUS: radius of the arc that shows a joint's range, relative to the link's length; RANGE_POINTS: number of the arc's points;
// RANGE_TICK: length of a stop's mark, relative to the radius
const { RANGE_RADIUS, RANGE_POINTS, RANGE_TICK } = SHARED.jointStops;
const NUMBER_GAP = 18; // [pixels] distance from a point to its number
// distances from a point to its number that are tried in this order, as multiples of NUMBER_GAP; farther away, a number would seem to
// belong to no point
const NAME_MULTIPLES = [1, 1.25, 1.5];
const MOST_NUMBERED_LINKS = 12; // with more links, points have no numbers
const MANY_LINKS = 60; // from this number of links on, the chain is drawn as one line without joints

export class ChainDrawing {
  constructor(element) {
    this.drawing = SVG(element);
    this.showTrace = true;
    this.kept = new KeptPositions();
    this.hatch = this.drawing.pattern(HATCH, HATCH, (tile) => {
      tile.rect(HATCH, HATCH).addClass("beyond-walls");
      // three lines, so that the lines of adjacent tiles meet
      [-HATCH, 0, HATCH].forEach((x) => tile.line(x, HATCH, x + HATCH, 0).addClass("hatch"));
    });
    this.ground = this.drawing.group();
    this.behind = this.drawing.group(); // the group behind the chain in which other modules draw
    this.trace = this.drawing.polyline().addClass("trace").fill("none");
    this.tail = Array.from({ length: TAIL_PARTS }, (_, part) =>
      this.drawing.polyline().addClass("tail").fill("none").opacity((part + 1) / TAIL_PARTS));
    // `letters` has those of compared motions
    const groups = "rings arcs circles bodies links joints stopTexts letters numbers arrows labels strip"; // from the hindmost on
    groups.split(" ").forEach((name) => Object.assign(this, { [name]: this.drawing.group() }));
    this.above = this.drawing.group().addClass("above"); // the group in front of the chain in which other modules draw
    this.linesAbove = () => []; // function that returns the lines in `above`, which labels must not cover
    // function that returns the positions of `letters`, which labels must not cover, and the `lines` in `behind`, which they avoid
    this.comparedNow = () => ({ letters: [], lines: [] });
  }

  /** Show another recording from the next frame of the browser on. */
  show(recording) {
    this.recording = recording;
    [this.arcs, this.circles, this.bodies, this.links, this.joints, this.numbers].forEach((group) => group.clear());
    this.ranges = recording.stops.map(() => ["range", "range-mark", "range-mark"].map((kind) =>
      this.arcs.polyline().addClass(kind).fill("none")));
    this.#makeChain();
    this.isFitted = false;
  }

  #makeChain() {
    const { links, pointCount, touching, pointNames, radius, ball, isPoint, traced, bodies, rail } = this.recording;
    const names = new Map(pointNames);
    const lines = links < MANY_LINKS ? Array.from({ length: links }, (_, link) => [link, link + 2]) : [[0, links + 1]];
    // The edge of a link, in the colour of the free region, shows which of two crossing links is in front. A ball is shown by a thin line
    // from its centre to a mark on the ball, as in pictures; a ball that is a point has no line.
    const kinds = ball === null ? ["link-edge", "link"] : isPoint ? [] : ["radius"];
    this.lines = lines.flatMap((range) => kinds.map((kind) =>
      [range, this.links.polyline().addClass(kind).fill("none")]));
    this.discs = radius > 0 ? touching.map(([point, ownRadius]) => [point, ownRadius, this.circles.circle().addClass("disc")]) : [];
    this.outlines = [...bodies.map(() => "body"), ...(rail ? ["carriage"] : [])].map((kind) => this.bodies.polygon().addClass(kind));
    this.names = Array.from({ length: links <= MOST_NUMBERED_LINKS ? pointCount : 0 }, (_, point) =>
      this.numbers.plain(names.get(point) ?? (isPoint && point !== ball ? "" : String(point))).addClass("point-number"));
    this.bodyOf = this.names.map((_, point) => this.#nearestBody(point));
    const shown = ball !== null ? [ball] : links < MANY_LINKS ? Array.from({ length: links + 1 }, (_, point) => point) : [0, links];
    this.dots = shown.map((point) => {
      const [kind, size] = isPoint ? ["ball", BALL_DOT] : point === traced ? ["tip", 11] : ["joint", 8];
      return [point, this.joints.circle(size).addClass(kind)];
    });
    for (let point = links + 1; point < pointCount; point += 1) {
      this.dots.push([point, this.joints.circle(7).addClass("site")]);
    }
  }

  /**
   * Return the index of the body beside which the number of a point stands: for an end of the chain the outline of its link, or −1 if the
   * link has none; for a point of a link the outline with the nearest corner, or −1 if no link has any; undefined for a joint between two
   * links.
   */
  #nearestBody(point) {
    const { links, bodies } = this.recording;
    if (point > 0 && point < links) return undefined;
    if (point <= links) return bodies.findIndex(([link]) => link === Math.max(point, 1));
    const [x, y] = this.recording.pointAt(0, point);
    const distances = this.recording.bodiesAt(0).slice(0, bodies.length)
      .map((corners) => Math.min(...corners.map(([cx, cy]) => Math.hypot(cx - x, cy - y))));
    return distances.indexOf(Math.min(...distances));
  }

  /** Set width and height [pixels] of the drawing, which the next frame uses. */
  resize(width, height) {
    this.size = [width, height];
    this.isFitted = false;
  }

  /** Fit the camera to the size of the drawing, and draw again what is the same in all frames. */
  #fit() {
    [this.isFitted, this.shownLens] = [true, this.lens];
    const [width, height] = this.size;
    this.drawing.size(width, height).viewbox(0, 0, width, height);
    this.camera = new Camera(this.lens ? { view: this.lens, anchor: [0.5, 0.5] } : this.recording, width, height, STRIP);
    const { recording } = this;
    this.arrowScale = new ArrowScale(recording.peakForce, width, height);
    this.impulseScale = new ArrowScale(largestImpulse(recording), width, height, "N·s");
    this.ruler = undefined;
    this.ground.clear();
    this.ground.rect(width, height).fill(this.hatch);
    this.walls = this.ground.group();
    this.#drawWalls(0);
    this.pin = this.recording.pin.map((line) => [line, this.ground.polyline().addClass("pin")]);
    this.rail = drawRail(this.ground, this.stopTexts, this.recording, (points) => this.#toScreen(points));
    this.discs.forEach(([, ownRadius, disc]) => disc.radius(ownRadius * this.camera.scale));
    const trace = traceOf(this.recording, this.camera);
    ({ frames: this.traceFrames, positions: this.tracePositions } = trace);
    this.isOnTrace = traceFinder(trace, width);
  }

  #toScreen(points) {
    return points.map(([x, y]) => this.camera.toScreen(x, y));
  }

  /** Draw the walls, and the free region between them, in their positions at a frame. */
  #drawWalls(frame) {
    const { corners, edges } = freeRegionWithin(this.recording.wallsAt(frame), this.camera.rectangle);
    this.walls.clear();
    if (corners.length) this.walls.polygon(this.#toScreen(corners)).addClass("free-region");
    this.edges = edges.map((ends) => this.#toScreen(ends));
    this.edges.forEach((ends) => this.walls.polyline(ends).addClass("wall"));
  }

  /** Let labels avoid the space beyond the walls, if they have room elsewhere. */
  #avoidWalls(frame) {
    const walls = Object.values(this.recording.wallsAt(frame));
    this.labelSpace.avoid(([left, top, right, bottom]) => {
      const corners = [[left, top], [right, top], [left, bottom], [right, bottom]].map((corner) => this.camera.toMetres(...corner));
      return walls.some(({ normal: [nx, ny], offset }) => corners.some(([x, y]) => nx * x + ny * y < offset));
    });
  }

  /** Draw the ground mark of a pinned base at the position of the base in a frame. */
  #drawPin(frame) {
    const [[x0, y0], [x, y]] = [0, frame].map((at) => this.recording.pointAt(at, 0));
    this.pin.forEach(([line, mark]) => mark.plot(this.#toScreen(line.map(([px, py]) => [px + x - x0, py + y - y0]))));
  }

  /** Draw everything at a frame. The camera changes only at the start of this function, so that all parts of a frame have the same one. */
  draw(frame) {
    if (!this.isFitted || this.lens !== this.shownLens) this.#fit(); // lens: the rectangle [m] in place of the recording's view
    const { recording, camera } = this;
    const all = Array.from({ length: recording.pointCount }, (_, point) => camera.toScreen(...recording.pointAt(frame, point)));
    const chain = all.slice(0, recording.links + 1);
    this.lines.forEach(([range, line]) => line.plot(chain.slice(...range)));
    const bodies = recording.bodiesAt(frame).map((corners) => this.#toScreen(corners));
    bodies.forEach((corners, k) => this.outlines[k].plot(corners));
    this.dots.forEach(([point, dot]) => dot.center(...all[point]));
    this.discs.forEach(([point, , disc]) => disc.center(...all[point]));
    if (recording.moved.length) this.#drawWalls(frame);
    this.#drawPin(frame);
    this.#drawRanges(frame);
    this.#drawTrace(frame, all[recording.traced]);
    this.labelSpace = new LabelSpace(...this.size, STRIP);
    if (this.showTrace) this.labelSpace.avoid((box) => this.isOnTrace(box, frame));
    this.#avoidWalls(frame);
    const marks = [...this.pin.map(([, mark]) => mark), ...this.ranges.flat()].map((mark) => mark.array());
    [chain, ...this.edges, ...this.rail, ...marks, ...this.linesAbove()].forEach((line) => this.labelSpace.reserveLine(line));
    bodies.forEach((corners) => this.labelSpace.reserveLine([...corners, corners[0]]));
    this.kept.follow(recording.impacts, recording.timeAt(frame));
    const { letters, lines } = this.comparedNow();
    this.labelSpace.avoid((box) => lines.some((line) => isCrossed(box, line)));
    [...this.dots.map(([point]) => all[point]), ...letters].forEach((at) => this.labelSpace.reserveAround(at));
    this.discs.forEach(([point, ownRadius]) => this.labelSpace.reserveRing({ position: all[point], radius: ownRadius * camera.scale }));
    const rings = this.#drawRings(frame);
    const texts = [...this.#drawArrows(frame), ...this.#drawLoads(frame)];
    const impulses = impulsesOf(recording, rings);
    this.#showRuler(impulses.length > 0, this.arrows.find(".arrow").length > 0);
    texts.push(...impulses.flatMap(({ position, away, impulse, text }) =>
      this.#arrow(position, away, this.impulseScale.lengthOf(impulse), "force", text)));
    texts.forEach((text, k) => this.#label(k, ...text)); // labels are written after all arrows are drawn, so that they keep off each arrow
    this.#drawNames(all, bodies);
    this.#numberRings(rings);
  }

  /** Show the ruler of impulses if these have arrows, but forces have none, or if no wall has a force; else that of forces. */
  #showRuler(hasImpulses, hasForces) {
    const isOfImpulses = !this.arrowScale.peak || (hasImpulses && !hasForces);
    const name = isOfImpulses ? "impulse" : hasImpulses ? "force, not impulse" : "force";
    if (name === this.ruler?.name) return;
    this.ruler = { name, scale: isOfImpulses ? this.impulseScale : this.arrowScale };
    drawStrip(this.strip, this);
  }

  /**
   * Draw the name, or else the number, of each point, if there is a free position for this text. `all`: positions of the points, `bodies`:
   * corners of the bodies, both on the screen.
   */
  #drawNames(all, bodies) {
    const { links } = this.recording;
    this.names.forEach((name, point) => {
      const corners = bodies[this.bodyOf[point]];
      const outward = corners ? outOfBody(all[point], corners) : outOfChain(all.slice(0, links + 1), point);
      const text = name.text();
      const around = positionsAround(all[point], outward, NUMBER_GAP, NAME_MULTIPLES);
      const beside = corners ? around : around.map((candidate) => ({ ...candidate, anchor: "middle" }));
      const position = this.kept.findPosition(this.labelSpace, name, all[point], text, NUMBER_TEXT, beside);
      name.css("visibility", position ? "visible" : "hidden");
      if (position) name.attr({ x: position.at[0], y: position.at[1] + 4 }).css({ "text-anchor": position.anchor });
    });
  }

  #drawTrace(frame, tip) {
    const { recording } = this;
    const now = recording.timeAt(frame);
    const end = this.showTrace ? lastBefore(this.traceFrames, frame) + 1 : 0;
    this.trace.plot([...this.tracePositions.slice(0, end), tip]);
    this.tail.forEach((line, part) => {
      const [from, to] = [TAIL_PARTS - part, TAIL_PARTS - part - 1].map((share) =>
        lastBefore(this.traceFrames, recording.frameAt(now - (TAIL * share) / TAIL_PARTS)));
      const last = part === TAIL_PARTS - 1 ? [tip] : [];
      line.plot(this.showTrace ? [...this.tracePositions.slice(from, Math.max(to, from) + 1), ...last] : []);
    });
  }

  /** Draw the arcs of the joints with stops, with a mark at each stop. */
  #drawRanges(frame) {
    this.recording.stops.forEach(({ joint, arc: [from, to], marks }, index) => {
      const at = (point) => this.recording.pointAt(frame, point);
      const [centre, end, before] = [at(joint - 1), at(joint), joint > 1 ? at(joint - 2) : undefined];
      const along = before ? Math.atan2(centre[1] - before[1], centre[0] - before[0]) : 0;
      const radius = RANGE_RADIUS * Math.hypot(end[0] - centre[0], end[1] - centre[1]);
      const onArc = (angle, share) => this.camera.toScreen(
        centre[0] + share * radius * Math.cos(along + angle), centre[1] + share * radius * Math.sin(along + angle));
      const angles = Array.from({ length: RANGE_POINTS }, (_, k) => from + ((to - from) * k) / (RANGE_POINTS - 1));
      const [line, ...ticks] = this.ranges[index];
      line.plot(angles.map((angle) => onArc(angle, 1)));
      marks.forEach((angle, k) => ticks[k].plot([1 - RANGE_TICK / 2, 1 + RANGE_TICK / 2].map((share) => onArc(angle, share))));
    });
  }

  /**
   * Return the `position` of a contact on the screen, and a direction, `away`, for its label. At a wall or a stop of a slider, the position
   * is the point's projection onto it, and the direction is the normal of the wall or stop. At a stop of a joint, the position is where the
   * link crosses the arc of the joint's range, and the direction is at a right angle to the link.
   */
  #contactPosition(frame, point, wall) {
    const side = this.recording.sidesAt(frame)[wall];
    if (!side) return this.#stopPosition(frame, point);
    const { normal: [nx, ny], offset } = side;
    const [x, y] = this.recording.pointAt(frame, point);
    const gap = nx * x + ny * y - offset;
    return { position: this.camera.toScreen(x - gap * nx, y - gap * ny), away: [nx, -ny] };
  }

  #stopPosition(frame, joint) {
    const [[x0, y0], [x1, y1]] = [joint - 1, joint].map((point) => this.recording.pointAt(frame, point));
    const length = Math.hypot(x1 - x0, y1 - y0) || 1;
    const [dx, dy] = [(x1 - x0) / length, (y1 - y0) / length];
    // the label of the moment is at a right angle to the link
    return { position: this.camera.toScreen(x0 + RANGE_RADIUS * (x1 - x0), y0 + RANGE_RADIUS * (y1 - y0)), away: [dy, dx] };
  }

  /** Return whether a contact can be drawn: it is at a stop, or the recording has its wall. */
  #isShown({ point, wall }) {
    const { walls, stops, rail } = this.recording;
    return wall in walls || wall in (rail?.stops ?? {}) || stops.some(({ joint }) => joint === point);
  }

  /** Draw the rings of recent impacts at a frame, and keep labels off them; return the rings, as `ringsOf` does. */
  #drawRings(frame) {
    const { recording } = this;
    const recent = recentImpacts(recording, frame).filter((impact) => this.#isShown(impact));
    const places = recent.map(({ onset, point, wall }) => this.#contactPosition(recording.frameAt(onset), point, wall));
    const rings = ringsOf(recent, places, recording.timeAt(frame));
    this.rings.clear();
    rings.forEach((ring) => {
      this.rings.circle(2 * ring.radius).center(...ring.position).addClass("ring").opacity(ring.opacity);
      if (ring.isSeen) this.labelSpace.reserveRing(ring);
    });
    return rings;
  }

  /** Write the numbers of impacts beside their rings; numbers without a free place beside their ring are left out. */
  #numberRings(rings) {
    rings.filter(({ numbers }) => numbers.length).forEach((ring) => {
      const { numbers, position, away, radius } = ring;
      const text = numbersText(numbers);
      const candidates = positionsAround(position, [-away[1], away[0]], radius + NUMBER_GAP / 2, [1, 1 + NUMBER_GAP / 2 / radius]);
      const label = this.kept.findPosition(
        this.labelSpace, `#${ring.number}`, position, text, NUMBER_TEXT, candidates, isOwnPlace(ring, rings));
      if (!label) return;
      const [x, y] = label.at;
      this.labels.plain(text).attr({ x, y: y + 4, "text-anchor": label.anchor }).addClass("ring-number");
    });
  }

  /**
   * Draw the arrows of the forces of walls, and the marks of stops and of sticking; return the labels for forces and moments as arguments
   * of `#label`.
   */
  #drawArrows(frame) {
    const { recording } = this;
    this.arrows.clear();
    this.labels.clear();
    const texts = [];
    recording.contactsAt(frame).filter((contact) => this.#isShown(contact)).forEach((contact) => {
      const { point, wall, force: normal, friction, sticks, holds } = contact;
      const { position: [x, y], away: [nx, ny] } = this.#contactPosition(frame, point, wall);
      const [force, held] = [Math.hypot(normal, friction), holds ? "holds " : ""]; // the list of impacts has the impulse before
      // unit vector of the whole force on the screen, where y points down: the unit vector t of dry friction is (−ny, nx) there
      const [dx, dy] = [(normal * nx - friction * ny) / force, (normal * ny + friction * nx) / force];
      if (STOPS.includes(wall)) {
        this.arrows.circle(STOP_DOT).center(x, y).addClass("stop-dot");
        this.labelSpace.reserveAround([x, y], STOP_DOT / 2);
        texts.push([[x, y], [dx, dy], 2 * STOP_DOT, held + forceText(force, 3, unitsOf({ atStop: true }).peak_force), "force"]);
        return;
      }
      if (sticks) {
        this.arrows.line([-STICK_BAR, STICK_BAR].map((along) => [x - along * ny, y + along * nx])).addClass("stick-bar");
      }
      // the label tells if friction changes the shown force, because the list of impacts has the force without friction
      const whole = forceText(force);
      const rubs = friction && whole !== forceText(normal);
      texts.push(...this.#arrow([x, y], [dx, dy], this.arrowScale.lengthOf(force), "force", held + whole + (rubs ? " with friction" : "")));
    });
    recording.stuckJointsAt(frame).forEach((joint) => {
      const centre = this.camera.toScreen(...recording.pointAt(frame, Math.max(joint - 1, 0)));
      this.arrows.circle(STUCK_DOT).center(...centre).addClass("stuck-joint");
    });
    return texts;
  }

  /**
   * Draw the arrows of the forces in joints at a frame, but none that would be too short; return the label of the largest force, in a list,
   * as arguments of `#label`.
   */
  #drawLoads(frame) {
    const { recording, camera } = this;
    const sized = recording.drawnAt("loads", frame).map((load) => ({ ...load, size: Math.hypot(load.x, load.y) }));
    const most = Math.max(...sized.map(({ size }) => size));
    return sized.filter(({ size }) => this.arrowScale.isOnScale(size)).flatMap(({ n, x, y, size }) => {
      const position = camera.toScreen(...recording.pointAt(frame, n - 1));
      return this.#arrow(position, [x / size, -y / size], this.arrowScale.lengthOf(size), "load", size === most ? forceText(size) : "");
    });
  }

  /**
   * Draw an arrow of a `length` [pixels] from a position in a direction (a unit vector), both on the screen; `kind`: its class in the style
   * sheet. Return a list with the arguments of `#label` for its text; the list is empty without a text, and for a short arrow.
   */
  #arrow([x, y], [dx, dy], length, kind, text) {
    const head = Math.min(14, 0.6 * length);
    const at = (along, across) => [x + dx * along - dy * across, y + dy * along + dx * across];
    this.arrows.line([at(0, 0), at(length - head, 0)]).addClass(`arrow ${kind}`);
    this.arrows.polygon([at(length, 0), at(length - head, 0.45 * head), at(length - head, -0.45 * head)])
      .addClass(`arrow-head ${kind}`);
    this.labelSpace.reserveLine([at(0, 0), at(length, 0)]);
    this.labelSpace.reserveAround(at(length - 0.6 * head, 0), 0.5 * head);
    return text && length >= LABEL_FROM ? [[at(length, 0), [dx, dy], 14, text, kind]] : [];
  }

  /**
   * Write a text at the first free place at a distance [pixels] from a position: first in the given direction, then in other directions,
   * then farther away. Without a free place, write nothing.
   */
  #label(key, position, direction, distance, text, kind) {
    const around = positionsAround(position, direction, distance, FORCE_MULTIPLES);
    const label = this.kept.findPosition(this.labelSpace, key, position, text, FORCE_TEXT, around);
    if (!label) return;
    const [x, y] = label.at;
    this.labels.plain(text).attr({ x, y: y + 4, "text-anchor": label.anchor }).addClass(`force-text ${kind}`);
  }
}
