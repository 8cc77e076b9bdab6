// The contour of a limit in a map: the edges between the cells of runs within the limit and of those beyond it.

/**
 * Return the edges of the contour as pairs of ends [column, row]. `results`: the outputs of `points` × `points` runs, row by row. A run's
 * cell reaches half a column and half a row around it, but not beyond the map. A run without an output has no edge.
 */
export function contourOf(results, points, limit) {
  const at = (column, row) => (column < points && row < points ? results[row * points + column] ?? NaN : NaN);
  const isEdge = (one, other) => Number.isFinite(one) && Number.isFinite(other) && (one <= limit) !== (other <= limit);
  const within = (place) => Math.min(Math.max(place, 0), points - 1);
  return Array.from(results, (_, index) => [index % points, Math.floor(index / points)]).flatMap(([column, row]) => {
    const [left, right, below, above] = [column - 0.5, column + 0.5, row - 0.5, row + 0.5].map(within);
    const value = at(column, row);
    return [
      ...(isEdge(value, at(column + 1, row)) ? [[[right, below], [right, above]]] : []),
      ...(isEdge(value, at(column, row + 1)) ? [[[left, above], [right, above]]] : []),
    ];
  });
}
