// Which run of a map a pointer or the arrow keys stand for.

import { axisScale, isLogarithmic } from "./map_scales.js";

/** Return the index of the run of the map `shown` at a pointer's position on its canvas; undefined if the run is not simulated yet. */
export function runAt({ clientX, clientY }, canvas, shown) {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  const points = canvas.width / 2 + 1;
  const numberAt = (share) => Math.min(Math.max(Math.round(share * (points - 1)), 0), points - 1);
  const [column, row] = [numberAt((clientX - left) / width), points - 1 - numberAt((clientY - top) / height)];
  const index = row * points + column;
  return shown?.results[index] === undefined ? undefined : index;
}

/** Return column and row of the present run, if the map has it (`hasRing`), or else of the run in the middle. */
export function firstRun({ names, axes, points }, changes, hasRing) {
  const shares = names.map((name, k) =>
    axisScale(axes[k][0], axes[k].at(-1), isLogarithmic(name)).shareOf(changes.valueOf(name)));
  return shares.map((share) => Math.round((points - 1) * (hasRing && share >= 0 && share <= 1 ? share : 0.5)));
}
