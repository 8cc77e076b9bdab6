// The free region between walls: the points on the free sides n·p ≥ offset of all walls.
// The twin in Python is `recording/view.py`.

/** Return the part of a polygon on the free side of a wall n·p ≥ offset (Sutherland & Hodgman, 1974). */
function clipped(polygon, { normal: [nx, ny], offset }) {
  const gap = ([x, y]) => nx * x + ny * y - offset;
  return polygon.flatMap((here, index) => {
    const before = polygon.at(index - 1);
    const [gapBefore, gapHere] = [gap(before), gap(here)];
    const kept = gapHere >= 0 ? [here] : [];
    if (gapBefore * gapHere >= 0) return kept;
    const fraction = gapBefore / (gapBefore - gapHere);
    return [before.map((value, axis) => value + fraction * (here[axis] - value)), ...kept];
  });
}

/**
 * Return the free region between walls inside a rectangle [m]: its `corners` and, for each wall that bounds it, the two ends of the wall's
 * visible part (`edges`).
 */
export function freeRegionWithin(walls, [[x0, y0], [x1, y1]]) {
  const all = Object.values(walls);
  const corners = all.reduce(clipped, [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]);
  const size = Math.hypot(x1 - x0, y1 - y0);
  const edges = all.map(({ normal: [nx, ny], offset }) =>
    corners.filter(([x, y]) => Math.abs(nx * x + ny * y - offset) < 1e-9 * (size + Math.abs(offset))),
  );
  return { corners, edges: edges.filter((ends) => ends.length > 1) };
}

/**
 * Return the point at which the perpendicular from the middle of a view, [low, high], to a wall beyond the view leaves a rectangle that is
 * smaller than the view by `inside` [m] at each side; undefined if the middle is not on the wall's free side.
 */
export function edgeBefore({ normal, offset }, [low, high], inside) {
  const middle = [0, 1].map((axis) => (low[axis] + high[axis]) / 2);
  if (!(normal[0] * middle[0] + normal[1] * middle[1] > offset)) return undefined;
  const halves = [0, 1].map((axis) => (high[axis] - low[axis]) / 2 - inside);
  const distance = Math.min(...halves.map((half, axis) => half / Math.abs(normal[axis])));
  return middle.map((coordinate, axis) => coordinate - distance * normal[axis]);
}

/** Return a list of the visible parts, each as two ends, of the wall `name` in a rectangle; the list is empty if no part is visible. */
export function edgesOf(walls, name, rectangle) {
  const { normal: [nx, ny], offset } = walls[name];
  const { edges } = freeRegionWithin(walls, rectangle);
  const isOn = ([x, y]) => Math.abs(nx * x + ny * y - offset) < 1e-6 * (1 + Math.abs(offset));
  return edges.filter((ends) => ends.every(isOn));
}
