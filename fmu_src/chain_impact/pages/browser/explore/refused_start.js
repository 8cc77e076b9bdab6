// The start that the solver refuses because a point lies beyond a wall: how far, in words, and in the drawing.

import { textWithUnit } from "../base/format.js";
import { edgesOf } from "../recording/free_region.js";
import { shownUpTo } from "../scene/angles.js";
import { radiusOf, sitesAt, startOf, wallsAt } from "../scene/geometry.js";
import { faultText } from "./console.js";

const REFUSED_MARGIN = 0.1; // free space around a refused chain, for its velocities, too, relative to the width of the view
const BEYOND_RING = 20; // [pixels] diameter of the ring around the point
// inputs whose signals move walls, or the base, away from where the parameters put them
const MOVES = /^(base|wall)\./;

/**
 * Return facts on the point that starts beyond a wall, for the `status` and the `part` of a run: the position of the point (`at`), the
 * `positions` of base and link ends [m], the `wall` with its free side, and `depth` [m], the distance of the point beyond the wall. The
 * result is undefined for any other fault, and if signals move base or walls. `valueOf`: function from the name of a parameter to its value
 * in the run.
 */
export function overlapOf({ status, part }, scene, valueOf) {
  const [point, name] = scene.pairs[part - 1] ?? [];
  const isMoved = scene.driven.some((input) => MOVES.test(input.name));
  if (status !== SHARED.kernel.STARTS_INSIDE_WALL || !name || isMoved) return undefined;
  const positions = startOf(scene, valueOf);
  const at = [...positions, ...sitesAt(positions, scene.sites, valueOf)][point];
  const wall = wallsAt(scene, valueOf)[name];
  const depth = radiusOf(scene, valueOf, point) + wall.offset - wall.normal[0] * at[0] - wall.normal[1] * at[1];
  return { at, positions, wall, depth };
}

/** Return words for the fault of a run that cannot start: for a part beyond a wall or stop, both names and, if known, the distance. */
export function startText(run, scene, overlap) {
  const words = scene.partsInWords[run.part - 1];
  if (run.status !== SHARED.kernel.STARTS_INSIDE_WALL || !words) return faultText(run, scene);
  const far = overlap ? `${textWithUnit(overlap.depth, shownUpTo({ unit: "m" }, overlap.depth), 2)} ` : "";
  return words.replace(/ at (?=(?:its|the wall) \w+$)/, ` starts ${far}beyond `);
}

/** A layer of the player, which draws the refused start in front of the last motion. */
export class RefusedStart {
  overlap = undefined; // the result of `overlapOf` for the last run

  constructor(drawing) {
    this.drawing = drawing;
  }

  /**
   * Show a refused start, `overlap`: the clock goes to the start, and the view contains the refused chain, unless a handle `isDragged`.
   * With the next motion (`isMotion`), the view and the time of before come back.
   */
  show(overlap, { clock, drawing, recording }, isMotion, isDragged) {
    this.overlap = overlap;
    if (!recording) return;
    if (isMotion) {
      if (this.time !== undefined && !isDragged) clock.seek(this.time);
      if (this.isFitted) drawing.lens = null;
      [this.time, this.isFitted] = [undefined, false];
      return;
    }
    if (isDragged) return clock.set({ playing: false });
    this.time ??= clock.time;
    clock.set({ playing: false, frame: 0 });
    if (!overlap) return;
    const all = [...overlap.positions, overlap.at];
    const margin = REFUSED_MARGIN * (recording.view[1][0] - recording.view[0][0]);
    drawing.lens = recording.view.map((end, k) => end.map((value, axis) =>
      (k ? Math.max : Math.min)(value, ...all.map((position) => position[axis] + (k ? margin : -margin)))));
    this.isFitted = true;
  }

  /** Draw the wall of a refused start and a ring around the point beyond it; the handles draw the chain there. */
  draw() {
    if (!this.overlap) return;
    const { at, wall } = this.overlap;
    const { above, camera } = this.drawing;
    const screen = (points) => points.map((point) => camera.toScreen(...point));
    edgesOf({ wall }, "wall", camera.rectangle).forEach((ends) => above.polyline(screen(ends)).addClass("refused").fill("none"));
    above.circle(BEYOND_RING).center(...camera.toScreen(...at)).addClass("refused").fill("none");
  }
}
