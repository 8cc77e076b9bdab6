// The contour of a limit in a map: the line on which the output, linear between neighbouring runs, equals the limit.

/** Return where the limit lies between two runs, as a fraction; undefined if both are on the same side, or if one has no output. */
function crossing(limit, from, to) {
  return (from < limit) === (to < limit) || !Number.isFinite(from) || !Number.isFinite(to) ? undefined : (limit - from) / (to - from);
}

/**
 * Return the lines of the contour as pairs of ends [column, row], which are fractions of columns and rows. `results`: the outputs of
 * `points` × `points` runs, row by row. In each square of four runs the contour has a line or, where it crosses all four sides, two lines.
 */
export function contourOf(results, points, limit) {
  const at = (column, row) => results[row * points + column] ?? NaN;
  const lines = [];
  for (let row = 0; row < points - 1; row += 1) {
    for (let column = 0; column < points - 1; column += 1) {
      const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([right, up]) => [column + right, row + up]);
      const ends = corners.flatMap((from, k) => {
        const to = corners[(k + 1) % 4];
        const share = crossing(limit, at(...from), at(...to));
        return share === undefined ? [] : [from.map((value, axis) => value + share * (to[axis] - value))];
      });
      for (let k = 0; k + 1 < ends.length; k += 2) lines.push([ends[k], ends[k + 1]]);
    }
  }
  return lines;
}
