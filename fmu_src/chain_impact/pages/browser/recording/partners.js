// Which impacts of two recordings belong together.

/** Return the impact of the same point and wall whose onset is nearest to that of `impact`; undefined without one. */
function nearestIn(impacts, { what, wall, onset }) {
  const gap = (one) => Math.abs(one.onset - onset);
  return impacts.filter((one) => one.what === what && one.wall === wall)
    .reduce((best, one) => (best && gap(best) <= gap(one) ? best : one), undefined);
}

/**
 * Return the impact of `others` that belongs to an impact of `impacts`: each of the two is, of all impacts of its point and wall in its
 * list, the nearest in time to the other. The result is undefined without one.
 */
export function partnerOf(impact, impacts, others) {
  const partner = nearestIn(others, impact);
  return partner && nearestIn(impacts, partner) === impact ? partner : undefined;
}
